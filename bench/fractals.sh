#!/usr/bin/env bash
# Fractals whose parts overlap, 320x240, one sample, at depths 25 and 40: processor seconds, peak memory and the rays
# whose work was bounded. With PROGRAM (an older build, at most 300 s a scene): its seconds at depth 25 too.
# usage: bench/fractals.sh [PROGRAM]
set -euo pipefail
cd "$(dirname "$0")/.."
old=${1:-}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cargo build --quiet --release --bin superegg
python3 bench/fractals.py "$work"
for scene in "$work"/*.scn; do
    for depth in 25 40; do
        { cat "$scene"; echo "setDepth $depth"; } >"$work/scene.txt"
        row=$( { /usr/bin/time -f "%U + %S s, %M kB" target/release/superegg render "$work/scene.txt" --size 320x240 \
            --samples 1 --quiet -o "$work/new.png" --stats "$work/stats.json"; } 2>&1 | tail -1)
        coarsened=$(grep -o '"coarsened_rays": [0-9]*' "$work/stats.json" | grep -o '[0-9]*')
        before=""
        if [ -n "$old" ] && [ "$depth" = 25 ]; then
            before="; before: $( { timeout 300 /usr/bin/time -f "%U + %S s" "$old" render "$work/scene.txt" --size 320x240 \
                --samples 1 --quiet -o "$work/old.png"; } 2>&1 | tail -1)"
        fi
        echo "$(basename "$scene" .scn), depth $depth: $row, $coarsened rays bounded$before"
    done
done
