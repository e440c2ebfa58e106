#!/usr/bin/env bash
# The same scenes by Superegg and by POV-Ray (apt-get install povray): processor seconds of one thread each, their ratio, and how the pictures
# differ. Both cast one ray a pixel, with shadows, unless there are more samples.
#
#     bench/povray.sh [--size WxH] [--samples N] [--pictures FOLDER] [SCENE ...]      # robot and cloud:10000 unless given; scene files too
#
# --samples takes a square number: Superegg's samples a pixel; POV-Ray takes a grid of as many. --pictures writes FOLDER/NAME.png with
# both pictures and eight times their difference, from left to right. For example, what POV-Ray can do too:
#
#     bench/povray.sh --size 320x240 --pictures target/side scenes/features/*.scn
set -euo pipefail
cd "$(dirname "$0")/.."
command -v povray >/dev/null || { echo "povray is not on this machine: apt-get install povray" >&2; exit 2; }
size=1280x960 samples=1 pictures=
while :; do
    case ${1:-} in
        --size) size=$2; shift 2 ;;
        --samples) samples=$2; shift 2 ;;
        --pictures) pictures=$2; mkdir -p "$pictures"; shift 2 ;;
        *) break ;;
    esac
done
[ $# -gt 0 ] || set -- robot cloud:10000
grid=$(awk "BEGIN { print int(sqrt($samples) + 0.5) }")
[ $((grid * grid)) = "$samples" ] || { echo "--samples takes a square number, as 1, 4, 9 or 16" >&2; exit 2; }
# A threshold of nothing: each pixel is sampled by the whole grid.
if [ "$grid" = 1 ]; then smooth=(-A); else smooth=(+A0.0 +AM1 "+R$grid" -J); fi
cargo build --release --quiet --bin superegg
cargo build --release --quiet -p superegg-golden --example difference
superegg=$PWD/target/release/superegg
difference=$PWD/target/release/examples/difference
out=target/povray
mkdir -p "$out"
trap 'echo "a program failed: $out/log.txt" >&2' ERR

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
    ours=$(seconds "$superegg" render "$scene" -o "$stem.superegg.png" --size "$size" --samples "$samples" --threads 1 --quiet)
    theirs=$(seconds povray +I"$stem.pov" +O"$stem.povray.png" +W"${size%x*}" +H"${size#*x}" +WT1 "${smooth[@]}" -D +FN File_Gamma=sRGB)
    side=()
    [ -z "$pictures" ] || side=("$pictures/$(basename "$scene" .scn).png")
    apart=$("$difference" "$stem.superegg.png" "$stem.povray.png" "${side[@]}")
    echo "| $name | $ours | $theirs | $(awk "BEGIN { printf \"%.1f\", $theirs / $ours }") | $apart |"
done
