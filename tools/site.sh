#!/usr/bin/env bash
# Puts the page and the book beside it into a folder, for any static server and any folder of it: OUT is the page, OUT/book the book.
#
#     crates/superegg-web/build.sh && tools/site.sh OUT
#
# It needs mdBook. Links of the book to the page become ../index.html. Files outside of docs to which the book links are copied
# beside it, so that those links lead somewhere; texts among them stay texts.
#
# Status 3: a tool is missing, or the page is not built.
set -euo pipefail
cd "$(dirname "$0")/.."
out=${1:?"usage: tools/site.sh OUT"}
page=crates/superegg-web/page

missing() {
    echo "missing: $1" >&2
    exit 3
}
command -v mdbook >/dev/null || missing "mdbook: cargo install mdbook"
[ -f $page/dist/index.html ] || missing "the page: crates/superegg-web/build.sh"

mkdir -p "$out"
out=$(cd "$out" && pwd)
cp -R $page/dist/. "$out"

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cp -R docs "$work"
pages=$(find "$work/docs" -name '*.md')
# shellcheck disable=SC2086
sed -i "s#(\(\.\./\)*$page/index\.html#(../index.html#g" $pages

# Paths from the folder of the repository, of all links that lead out of docs and not to the page.
linked() {
    grep -oE '\]\(\.\./[^)#? ]*' "$work"/docs/*.md | sed 's#.*(\.\./##'
    grep -oE '\]\(\.\./\.\./[^)#? ]*' "$work"/docs/*/*.md | sed 's#.*(\.\./\.\./##'
}
linked | sort -u | while read -r path; do
    mkdir -p "$out/$(dirname "$path")"
    if [ -d "$path" ]; then
        mkdir -p "$out/$path"
        (cd "$path" && ls -p) >"$out/$path/index.txt"
        # shellcheck disable=SC2086
        sed -i -E "s#\]\(((\.\./)+$path)/?\)#](\1/index.txt)#g" $pages
    elif [ ! -e "$out/$path" ]; then
        # mdBook makes a link to .md one to .html, and a server shows what ends in .txt.
        case $path in
        *.md | *.sh | *.cff) cp "$path" "$out/${path%.*}.txt" ;;
        *) cp "$path" "$out/$path" ;;
        esac
    fi
done
texts='[A-Za-z_/-]+)\.(md|sh|cff)(#[^)]*)?\)'
sed -i -E 's@\]\((\.\./'"$texts"'@](\1.txt)@g' "$work"/docs/*.md
sed -i -E 's@\]\((\.\./\.\./'"$texts"'@](\1.txt)@g' "$work"/docs/*/*.md
mdbook build "$work/docs" -d "$out/book" >/dev/null
echo "the page: $out/index.html, the book: $out/book/index.html"
