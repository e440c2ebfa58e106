#!/usr/bin/env bash
# Makes the pictures of the window for the book: docs/pictures/window.png and docs/pictures/course_tests.png.
# It needs Xvfb, xdotool and ImageMagick, and a program built with `--features viewer`.
#
#     tools/screenshots.sh [PROGRAM]       # default: target/release/superegg
set -euo pipefail
cd "$(dirname "$0")/.."
program=$(realpath "${1:-target/release/superegg}")
pictures=$PWD/docs/pictures
work=$(mktemp -d)
export HOME=$work XDG_STATE_HOME=$work/state XDG_DATA_HOME=$work/data XDG_RUNTIME_DIR=$work DISPLAY=:93
Xvfb "$DISPLAY" -screen 0 1280x800x24 >/dev/null 2>&1 &
server=$!
trap 'kill "$server"; rm -rf "$work"' EXIT
sleep 2

# shoot NAME KEYS ARGUMENTS...: opens a window, presses keys, and keeps the screen at half its size.
shoot() {
    local name=$1 keys=$2 key view
    shift 2
    "$program" view "$@" >/dev/null 2>&1 &
    view=$!
    sleep 12
    xdotool windowfocus "$(xdotool search --name 'Superegg$' | head -1)"
    for key in $keys; do
        xdotool key "$key"
        sleep 3
    done
    import -window root "$work/screen.png"
    convert "$work/screen.png" -resize 640x400 -dither None -colors 120 -strip -define png:compression-level=9 "$pictures/$name.png"
    kill "$view"
    wait "$view" 2>/dev/null || true
}

cat >"$work/pawn.scn" <<'SCENE'
up z
camera 3 -9 4  0 0 1  26
light lamp 5 -6 8  1 0.95 0.85
sky 0.5 0.55 0.6  0.1 0.16 0.3
primitive board; color 0.75 0.68 0.55; pattern checker 0.16 0.1 0.07 1
floor 0 board
primitive ball; color 0.85 0.5 0.2
primitive disc; exponent 1 0.3; color 0.2 0.35 0.6
primitive waist; exponent 1 2.4; color 0.8 0.75 0.6
object pawn
addPrimitive disc foot; scale 0.85 0.85 0.16; translate 0 0 0.16
addPrimitive disc step; scale 0.66 0.66 0.14; translate 0 0 0.4
addPrimitive waist body; scale 0.75 0.75 2; translate 0 0 0.45
addPrimitive disc collar; scale 0.5 0.5 0.08; translate 0 0 1.62
addPrimitive ball head; scale 0.46 0.46 0.46; translate 0 0 2.05
SCENE
cat >"$work/cone.scn" <<'SCENE'
camera 5 4 11  0.5 0 0.5  30
primitive cone; exponent 1 2; color 0.75 0.6 0.3
object turned
addPrimitive cone; scale 2 2 3; rotate x 90; translate 1 0 0.5
SCENE
shoot window "" "$work/pawn.scn"
shoot course_tests "o i u" "$work/cone.scn"
ls -l "$pictures/window.png" "$pictures/course_tests.png"
