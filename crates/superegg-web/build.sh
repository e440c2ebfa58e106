#!/usr/bin/env bash
# Builds the WebAssembly module, the npm package around it (package/dist), the page (page/dist) and the widget of notebooks
# (widget/dist), which the next wheel of the Python package carries.
#
#     crates/superegg-web/build.sh            # all
#     crates/superegg-web/build.sh --widget   # the module, the package and the widget
#     crates/superegg-web/build.sh --engine   # the module and the package only
#
# It needs Node.js 20 and npm 11, and the standard library of Rust for WebAssembly:
#
#     rustup target add wasm32-unknown-unknown
#     cargo install wasm-bindgen-cli --version "$(crates/superegg-web/build.sh --bindgen-version)"
#
# or, where rustup has none, Debian's compiler, which builds it from its source in some minutes:
#
#     apt-get install rustc-web cargo-web rust-web-src lld-22
#
# Status 3: a tool is missing.
set -euo pipefail
cd "$(dirname "$0")"
root=$(cd ../.. && pwd)

# The command has to have the version of the library.
bindgen=$(awk '/^name = "wasm-bindgen"$/ { getline; gsub(/"/, "", $3); print $3 }' "$root/Cargo.lock")
if [ "${1:-}" = --bindgen-version ]; then
    echo "$bindgen"
    exit 0
fi

missing() {
    echo "missing: $1" >&2
    exit 3
}

command -v npm >/dev/null || missing "npm"
[ "$(wasm-bindgen --version 2>/dev/null)" = "wasm-bindgen $bindgen" ] ||
    missing "wasm-bindgen $bindgen: cargo install wasm-bindgen-cli --version $bindgen"

target=wasm32-unknown-unknown
build=(-p superegg-web --profile web --target "$target" --locked)
flags="-C target-feature=+simd128"
# Deep scenes need more than the linker's 1 MiB.
link=(-- -C link-arg=-zstack-size=4194304)
out=${CARGO_TARGET_DIR:-$root/target}
if rustup target list --installed 2>/dev/null | grep -qx "$target"; then
    (cd "$root" && CARGO_TARGET_WASM32_UNKNOWN_UNKNOWN_RUSTFLAGS=$flags cargo rustc "${build[@]}" "${link[@]}")
else
    # A compiler beside rustup's, with the source of its library and a linker for WebAssembly.
    linker=$(compgen -c wasm-ld | sort -V | tail -n 1)
    [ -x /usr/bin/cargo ] && [ -d "$(/usr/bin/rustc --print sysroot)/lib/rustlib/src/rust/library" ] && [ -n "$linker" ] ||
        missing "the target $target: rustup target add $target, or Debian's rustc-web, cargo-web, rust-web-src and lld-22"
    # Its own folder: the files of the two compilers do not mix.
    out=$out/web
    (cd "$root" && RUSTC=/usr/bin/rustc RUSTC_BOOTSTRAP=1 CARGO_TARGET_DIR=$out \
        CARGO_TARGET_WASM32_UNKNOWN_UNKNOWN_LINKER=$linker \
        CARGO_TARGET_WASM32_UNKNOWN_UNKNOWN_RUSTFLAGS="$flags -C linker-flavor=wasm-ld" \
        /usr/bin/cargo rustc "${build[@]}" -Zbuild-std=std,panic_abort "${link[@]}")
fi

# Not wasm-opt: version 108 breaks the table of references that wasm-bindgen adds, and the compressed module gets no smaller.
wasm-bindgen --target web --omit-default-module-path --remove-name-section --remove-producers-section \
    --out-dir package/engine --out-name superegg "$out/$target/web/superegg_web.wasm"
module=package/engine/superegg_bg.wasm
printf 'module: %d bytes, %d compressed\n' "$(wc -c <"$module")" "$(gzip -9c "$module" | wc -c)"

[ -d node_modules ] || npm ci --no-audit --no-fund --ignore-scripts --silent
npm run --silent build --workspace package
[ "${1:-}" = --engine ] && exit 0
npm run --silent build --workspace widget
carried=../superegg-python/python/superegg/web
mkdir -p "$carried"
cp widget/dist/widget.js widget/dist/superegg.wasm.gz "$carried"
[ "${1:-}" = --widget ] && exit 0
# Scenes that pages name by their address, and the pictures that they name.
mkdir -p page/public/scenes/features
cp ../../scenes/*.scn ../../scenes/*.hdr ../../scenes/*.png page/public/scenes
cp ../../scenes/features/*.scn ../../scenes/features/*.png page/public/scenes/features
npm run --silent build --workspace page
