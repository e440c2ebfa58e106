#!/usr/bin/env bash
# Builds the wheel and the sdist of the Python package, installs the wheel into a fresh virtual environment, and tests it there.
set -euo pipefail
cd "$(dirname "$0")"

skip() {
    echo "skipped: $1"
    [ "${CI:-false}" = false ] || exit 1
    exit 0
}

command -v python3 >/dev/null || skip "python3 is not on this machine"
python3 -c 'import sys; sys.exit(sys.version_info < (3, 10))' || skip "python3 is older than 3.10"

scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
python3 -m venv "$scratch/venv" || skip "python3 has no venv"
# shellcheck disable=SC1091
source "$scratch/venv/bin/activate"
pip install --quiet --disable-pip-version-check 'maturin>=1.8,<2' numpy pytest scipy tqdm mypy pyright trimesh nbclient ipykernel distributed anywidget ||
    skip "maturin and the test tools cannot be installed"

# The artifacts of the workspace's release profile are shared, so that only this crate is compiled.
maturin build --quiet --release --locked --out "$scratch/wheels"
maturin sdist --out "$scratch/sdist"
pip install --quiet --disable-pip-version-check "$scratch"/wheels/*.whl

mypy
pyright --project .
# Outside of the source, so that the installed package is tested; `--import-mode` keeps it that way.
installed=$(cd "$scratch" && python -c 'import superegg, pathlib; print(pathlib.Path(superegg.__file__).parent)')
python -m pytest -q --import-mode=importlib -p no:cacheprovider --override-ini=testpaths= \
    tests README.md ../../README.md ../../docs/python.md "$installed"
"$scratch/venv/bin/superegg" --version

# The view in the browser, in JupyterLab, where crates/superegg-web/build.sh has built its module.
web=../superegg-web
if [ ! -f python/superegg/web/widget.js ] || [ ! -d $web/node_modules/playwright-core ] || [ ! -x "${CHROMIUM:-/usr/bin/chromium}" ]; then
    echo "skipped: the view in JupyterLab needs crates/superegg-web/build.sh and Chromium"
elif pip install --quiet --disable-pip-version-check jupyterlab; then
    JUPYTER_LAB=$scratch/venv/bin/jupyter-lab node --test --test-reporter=spec $web/widget/test/jupyter.test.js
else
    echo "skipped: JupyterLab cannot be installed"
fi
