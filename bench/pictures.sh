#!/usr/bin/env bash
# Whole pictures with mirrors, glass, area lights and deep groups: processor seconds of one thread of this program, of an
# older one (a build of another commit) and of POV-Ray (apt-get install povray) on the exported scene, and how the pictures
# of the two programs differ. Least of three turns each.
# usage: bench/pictures.sh [--old PROGRAM] [--no-povray] [SCENE[:WxH[:SAMPLES]] ...]    (the gallery's own without scenes)
set -euo pipefail
cd "$(dirname "$0")/.."
old= povray=yes
while :; do
    case ${1:-} in
        --old) old=$2; shift 2 ;;
        --no-povray) povray=; shift ;;
        *) break ;;
    esac
done
[ -z "$povray" ] || command -v povray >/dev/null || { echo "povray is not on this machine: apt-get install povray, or --no-povray" >&2; exit 2; }
cargo build --release --quiet --bin superegg
cargo build --release --quiet -p superegg-golden --example difference
superegg=$PWD/target/release/superegg
difference=$PWD/target/release/examples/difference
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
if [ $# = 0 ]; then
    set -- "$("$superegg" bench robot --save "$work"):1280x960" scenes/{sunset,still_life,glass_lens,stars}.scn \
        scenes/{chess,nest,fractal_tree}.scn:320x240:4
fi

# seconds COMMAND ...: the least user and system seconds of three turns.
seconds() {
    local TIMEFORMAT='%U %S'
    for _ in 1 2 3; do
        { time "$@" >"$work/log" 2>&1; } 2>&1 || { cat "$work/log" >&2; exit 1; }
    done | awk '{ t = $1 + $2; if (NR == 1 || t < least) least = t } END { printf "%.3f", least }'
}
over() { awk "BEGIN { printf \"%.1f\", $1 / $2 }"; }

echo "| scene | superegg s | old s | old / superegg | povray s | povray / superegg | pictures of both programs |"
echo "|---|---|---|---|---|---|---|"
for given in "$@"; do
    IFS=: read -r scene size samples <<<"$given:::"
    size=${size:-320x240} samples=${samples%%:*} samples=${samples:-1}
    name=$(basename "$scene" .scn)
    flags=(--size "$size" --samples "$samples" --threads 1 --quiet)
    ours=$(seconds "$superegg" render "$scene" -o "$work/new.png" "${flags[@]}")
    before=- gain=- apart=- theirs=- ratio=-
    if [ -n "$old" ]; then
        before=$(seconds "$old" render "$scene" -o "$work/old.png" "${flags[@]}")
        gain=$(over "$before" "$ours") apart=$("$difference" "$work/new.png" "$work/old.png")
    fi
    # POV-Ray casts one ray a pixel here.
    if [ -n "$povray" ] && [ "$samples" = 1 ]; then
        "$superegg" export "$scene" -o "$work/scene.pov" >/dev/null 2>&1
        theirs=$(seconds povray +I"$work/scene.pov" +O"$work/povray.png" +W"${size%x*}" +H"${size#*x}" +WT1 -A -D +FN File_Gamma=sRGB)
        ratio=$(over "$theirs" "$ours")
    fi
    echo "| $name $size, $samples | $ours | $before | $gain | $theirs | $ratio | $apart |"
done
