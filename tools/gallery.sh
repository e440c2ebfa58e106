#!/usr/bin/env bash
# Makes the gallery: docs/pictures/gallery/NAME.png of every scene in scenes/, and docs/gallery.md with their texts.
#
#     tools/gallery.sh               # renders all, some minutes on two cores
#     tools/gallery.sh NAME ...      # renders these only, and makes the page anew
#     tools/gallery.sh --page        # makes the page anew, with the pictures that are there
#
# Each picture links to its scene in the browser: to SUPEREGG_PAGE?scene=NAME, by default the page in this repository, which
# tools/site.sh replaces by the published one.
#
# A picture has the size and samples that its scene sets, or 640x480. They are kept beside the pictures with the number of
# rays, in rays.txt: name, width, height, samples, rays.
set -euo pipefail
cd "$(dirname "$0")/.."
size=640x480
pictures=docs/pictures/gallery
page=docs/gallery.md
live=${SUPEREGG_PAGE:-../crates/superegg-web/page/index.html}
most_lines=120        # a longer scene is quoted in part
mkdir -p "$pictures"
touch "$pictures/rays.txt"

# A number in a file of --stats; 0 where it has none of this name.
stat() { awk -F'[:,]' -v key="\"$2\"" '{ gsub(/^ +/, "") } $1 == key { found = $2 } END { print found + 0 }' "$1"; }

render() {
    local name=$1 stats sized=()
    stats=$(mktemp)
    grep -qi '^set size' "scenes/$name.scn" || sized=(--size "$size")
    nice target/release/superegg render "scenes/$name.scn" "${sized[@]}" --quiet -o "$pictures/$name.png" --stats "$stats"
    tools/squeeze.sh "$pictures/$name.png"
    local rays=0 kind
    for kind in camera shadow ambient reflection refraction; do rays=$((rays + $(stat "$stats" "$kind"))); done
    grep -v "^$name " "$pictures/rays.txt" >"$stats.rays" || true
    echo "$name $(stat "$stats" width) $(stat "$stats" height) $(stat "$stats" samples) $rays" >>"$stats.rays"
    LC_ALL=C sort "$stats.rays" >"$pictures/rays.txt"
    echo "$name: $(stat "$stats" render) s" >&2
    rm "$stats" "$stats.rays"
}

# The comment that a scene begins with, as one line.
says() { awk '!/^# / { exit } { sub(/^# /, ""); printf "%s%s", (NR > 1 ? " " : ""), $0 } END { print "" }' "$1"; }

# A scene's text between fences: all of it, or where it is long what comes before its first primitive, and its last object.
quote() {
    local file=$1 fence='```' first last
    if [ "$(wc -l <"$file")" -le "$most_lines" ]; then
        printf '%s\n%s\n%s\n' "$fence" "$(cat "$file")" "$fence"
        return
    fi
    # Comments just above belong to what follows.
    first=$(awk '/^primitive / { print begin ? begin : NR; exit } /^#/ { if (!begin) begin = NR; next } { begin = 0 }' "$file")
    last=$(awk '/^object / { last = NR } END { print last }' "$file")
    printf '%s\n%s\n%s\n\n' "$fence" "$(head -n $((first - 1)) "$file")" "$fence"
    printf '... and, after its primitives and smaller objects:\n\n'
    printf '%s\n%s\n%s\n' "$fence" "$(tail -n "+$last" "$file")" "$fence"
}

section() {
    local file=$1 name lines
    name=$(basename "$file" .scn)
    lines=$(wc -l <"$file")
    printf '## %s\n\n%s\n\n[![%s](pictures/gallery/%s.png)](%s?scene=%s)\n\n' \
        "$name" "$(says "$file")" "$name" "$name" "$live" "$name"
    awk -v name="$name" -v lines="$lines" '$1 == name {
        printf "[%s.scn](../scenes/%s.scn), %d lines; %dx%d, %d samples a pixel, %.1f million rays.\n\n",
            name, name, lines, $2, $3, $4, $5 / 1e6 }' "$pictures/rays.txt"
    printf '<details><summary>The scene</summary>\n\n%s\n\n</details>\n\n' "$(quote "$file")"
}

write_page() {
    cat <<END
# Gallery

Every picture here is made by Superegg from the text below it: \`superegg render scenes/NAME.scn\`. \`tools/gallery.sh\` renders all of
them and writes this page. Each picture links to its scene on the [page](web.md), where it can be turned and changed. The number
of rays, shadow rays included, says which scenes are heavy.

END
    local file name
    for file in scenes/*.scn; do section "$file"; done
    cat <<END
## Features

One small scene for each thing that the renderer can do; their pictures are those that the tests compare with.

| | | |
|---|---|---|
END
    for file in scenes/features/*.scn; do
        name=$(basename "$file" .scn)
        printf '| [![%s](../tests/golden/features/%s.png)](%s?scene=features/%s) | [%s](../scenes/features/%s.scn) | %s |\n' \
            "$name" "$name" "$live" "$name" "$name" "$name" "$(says "$file")"
    done
}

if [ "${1:-}" != --page ]; then
    cargo build --release --quiet --bin superegg
    if [ $# -eq 0 ]; then
        for file in scenes/*.scn; do render "$(basename "$file" .scn)"; done
    else
        for name in "$@"; do render "$name"; done
    fi
fi
write_page >"$page.new"
mv "$page.new" "$page"
