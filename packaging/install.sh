#!/bin/sh
# Installs what belongs to the program `superegg` on Linux: man pages, shell completions, the icon, the menu entry and the file types.
# The program itself comes from `cargo install --path crates/superegg-cli --features viewer`.
#
#     packaging/install.sh              for this user, below ~/.local
#     packaging/install.sh /usr/local   for all users
#
# SUPEREGG names another program to make the pages and completions with; DESTDIR is put before all paths, as packagers expect.
set -eu

here=$(dirname "$0")
prefix=${1:-$HOME/.local}
superegg=${SUPEREGG:-superegg}
share=${DESTDIR:-}$prefix/share

command -v "$superegg" > /dev/null || {
    echo "there is no program '$superegg'; install it first: cargo install --path crates/superegg-cli --features viewer" >&2
    exit 2
}

mkdir -p "$share/man/man1" "$share/bash-completion/completions" "$share/zsh/site-functions" \
    "$share/fish/vendor_completions.d" "$share/powershell" "$share/applications" "$share/mime/packages" \
    "$share/icons/hicolor/scalable/apps"

"$superegg" man "$share/man/man1" > /dev/null
"$superegg" completions bash > "$share/bash-completion/completions/superegg"
"$superegg" completions zsh > "$share/zsh/site-functions/_superegg"
"$superegg" completions fish > "$share/fish/vendor_completions.d/superegg.fish"
"$superegg" completions powershell > "$share/powershell/superegg.ps1"

cp "$here/superegg.desktop" "$share/applications/superegg.desktop"
cp "$here/superegg.xml" "$share/mime/packages/superegg.xml"
cp "$here/superegg.svg" "$share/icons/hicolor/scalable/apps/superegg.svg"

# The caches of a desktop, where there is one; a packager's tools do this later.
if [ -z "${DESTDIR:-}" ]; then
    if command -v update-mime-database > /dev/null; then update-mime-database "$share/mime"; fi
    if command -v update-desktop-database > /dev/null; then update-desktop-database "$share/applications"; fi
    if command -v gtk-update-icon-cache > /dev/null; then gtk-update-icon-cache -q -t -f "$share/icons/hicolor" || true; fi
fi

echo "installed below $share"
echo "zsh: add $share/zsh/site-functions to fpath; PowerShell: . $share/powershell/superegg.ps1"
