#!/usr/bin/env bash
# The same scenes by Superegg and by POV-Ray (apt-get install povray): processor seconds of one thread each, their ratio, and how the pictures
# differ. Both cast one ray a pixel, with shadows.
#
#     bench/povray.sh [--size WxH] [SCENE ...]      # robot and cloud:10000 unless given; scene files too
set -euo pipefail
cd "$(dirname "$0")/.."
command -v povray >/dev/null || { echo "povray is not on this machine: apt-get install povray" >&2; exit 2; }
size=1280x960
if [ "${1:-}" = --size ]; then size=$2; shift 2; fi
[ $# -gt 0 ] || set -- robot cloud:10000
cargo build --release --quiet --bin superegg
cargo build --release --quiet -p superegg-golden --example difference
superegg=$PWD/target/release/superegg
difference=$PWD/target/release/examples/difference
out=target/povray
mkdir -p "$out"

# Processor seconds of a command, user and system.
seconds() {
    local TIMEFORMAT='%U %S'
    { time "$@" >"$out/log.txt" 2>&1; } 2>&1 | awk '{ printf "%.3f", $1 + $2 }'
}

echo "| scene | superegg s | povray s | ratio | pictures |"
echo "|---|---|---|---|---|"
for name in "$@"; do
    if [ -f "$name" ]; then
        scene=$name
    else
        scene=$("$superegg" bench "$name" --save "$out")
    fi
    stem=$out/$(basename "$scene" .scn)
    "$superegg" export "$scene" -o "$stem.pov"
    ours=$(seconds "$superegg" render "$scene" -o "$stem.superegg.png" --size "$size" --samples 1 --threads 1 --quiet)
    theirs=$(seconds povray +I"$stem.pov" +O"$stem.povray.png" +W"${size%x*}" +H"${size#*x}" +WT1 -A -D +FN File_Gamma=sRGB)
    apart=$("$difference" "$stem.superegg.png" "$stem.povray.png")
    echo "| $name | $ours | $theirs | $(awk "BEGIN { printf \"%.1f\", $theirs / $ours }") | $apart |"
done
