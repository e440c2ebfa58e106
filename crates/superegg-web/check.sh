#!/usr/bin/env bash
# Builds the WebAssembly module, the npm package, the page and the widget of notebooks, and tests them in Node and in headless Chromium.
# What cannot be had on this machine is skipped, and says so.
set -euo pipefail
cd "$(dirname "$0")"
root=$(cd ../.. && pwd)

skip() {
    echo "skipped: $1"
    exit 0
}

# Debian's compiler with a standard library for WebAssembly, where rustup has none; and a browser.
if command -v apt-get >/dev/null && [ "$(id -u)" = 0 ]; then
    wanted=()
    rustup target list --installed 2>/dev/null | grep -qx wasm32-unknown-unknown || [ -x /usr/bin/cargo ] ||
        wanted+=(rustc-web cargo-web rust-web-src lld-22)
    command -v chromium >/dev/null || wanted+=(chromium)
    if [ ${#wanted[@]} -gt 0 ]; then
        apt-get update -qq || true
        DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "${wanted[@]}" >/dev/null ||
            echo "not installed: ${wanted[*]}"
    fi
fi

version=$(./build.sh --bindgen-version)
if [ "$(wasm-bindgen --version 2>/dev/null)" != "wasm-bindgen $version" ]; then
    # Without --locked: its lock file names versions that have been withdrawn.
    cargo install --quiet wasm-bindgen-cli --version "$version" || skip "wasm-bindgen $version cannot be installed"
fi

./build.sh || { status=$?; [ $status = 3 ] && skip "the module cannot be built on this machine"; exit $status; }

[ -x "${SUPEREGG:-$root/target/release/superegg}" ] || (cd "$root" && cargo build --release --locked --quiet)
npm run --silent test --workspace package
npm run --silent test --workspace page
# The test in JupyterLab is that of the Python package's check.
npm run --silent test --workspace widget
