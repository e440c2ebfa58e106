#!/usr/bin/env bash
# bench/fit.sh EMS_FOLDER [options of bench/fit.py]
# Fits by Superegg, EMS and sage-superquadric on the same clouds in one run: builds the wheel, installs all into a
# folder that is removed, and runs bench/fit.py. EMS_FOLDER is Python/src of a checkout of bmlklwx/EMS-superquadric_fitting.
set -euo pipefail
cd "$(dirname "$0")/.."
ems=${1:?usage: bench/fit.sh EMS_FOLDER [options]}
shift

scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
python3 -m venv "$scratch/venv"
"$scratch/venv/bin/pip" install --quiet --disable-pip-version-check \
    'maturin>=1.8,<2' numpy==2.4.6 scipy==1.17.1 numba==0.68.1 sage-superquadric==1.0.0
(cd crates/superegg-python && "$scratch/venv/bin/maturin" build --quiet --release --locked --out "$scratch/wheels")
"$scratch/venv/bin/pip" install --quiet --disable-pip-version-check "$scratch"/wheels/*.whl
"$scratch/venv/bin/python" bench/fit.py --ems "$ems" "$@"
