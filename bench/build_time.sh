#!/usr/bin/env bash
# Processor seconds of cold builds, one after the other on this machine: the program with its window at an old
# commit, then what is checked out: the README's first command, and the program with its window.
# usage: bench/build_time.sh [OLD_COMMIT]   (downloads are not counted; 5 GB of disk in a temporary folder)
set -euo pipefail
cd "$(dirname "$0")/.."
old=${1:-ce55dc8}
work=$(mktemp -d)
trap 'git worktree remove --force "$work/old" 2>/dev/null || true; rm -rf "$work"' EXIT
git worktree add --quiet --detach "$work/old" "$old"

# cold NAME FOLDER ARGUMENT ...: user and system seconds of `cargo build` with an empty target folder.
cold() {
    local name=$1 folder=$2
    shift 2
    (cd "$folder" && cargo fetch --quiet --locked)
    local TIMEFORMAT='%U %S'
    local seconds
    seconds=$({ time (cd "$folder" && CARGO_TARGET_DIR="$work/target" cargo build --quiet --release --locked --offline "$@" 2>"$work/log") ; } 2>&1) ||
        { cat "$work/log" >&2; exit 1; }
    rm -rf "$work/target"
    awk -v name="$name" -v first="${first:-}" '{
        total = $1 + $2
        printf "%-44s %7.0f s", name, total
        if (first != "") printf "   %.3f", total / first
        printf "\n"
    }' <<<"$seconds"
    first=${first:-$(awk '{ print $1 + $2 }' <<<"$seconds")}
}

cold "$old, whole" "$work/old"
cold "the README's first command" . --bin superegg
cold "the program with its window" . --bin superegg --features viewer
