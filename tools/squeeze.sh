#!/usr/bin/env bash
# Packs PNG pictures as tightly as PNG can, where ImageMagick is; their pixels stay.
#
#     tools/squeeze.sh PICTURE.png ...
set -euo pipefail
command -v convert >/dev/null || exit 0
small=$(mktemp --suffix=.png)
trap 'rm -f "$small"' EXIT
for picture in "$@"; do
    convert "$picture" -strip -define png:compression-level=9 -define png:compression-filter=5 -define png:color-type=2 "$small"
    if [ "$(wc -c <"$small")" -lt "$(wc -c <"$picture")" ]; then cp "$small" "$picture"; fi
done
