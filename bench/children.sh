#!/usr/bin/env bash
# A text scene of N children (default a million) of 64 primitives to a picture 1280x960 with shadows, three turns:
# processor seconds and peak memory of each program named, of this one by default.
# usage: bench/children.sh [N [PROGRAM ...]]
set -euo pipefail
cd "$(dirname "$0")/.."
count=${1:-1000000}
shift || true
programs=("$@")
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
if [ ${#programs[@]} -eq 0 ]; then
    cargo build --quiet --release --bin superegg
    programs=(target/release/superegg)
fi
python3 bench/random_scene.py "$count" 64 > "$work/children.scn"
for turn in 1 2 3; do
    for program in "${programs[@]}"; do
        /usr/bin/time -f "$program: %U + %S s of processor, %M kB" \
            "$program" render "$work/children.scn" -o "$work/picture.png" --size 1280x960 --samples 1 --quiet
    done
done
