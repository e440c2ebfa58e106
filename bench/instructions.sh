#!/usr/bin/env bash
# Instructions a ray of each method, by callgrind: the run of a method less the run that only makes the rays.
# Under valgrind the lanes are those of AVX2: eight at a time.
set -euo pipefail
cd "$(dirname "$0")/.."
count=${1:-40000}
cargo build --release --quiet -p superegg-geom --example one_method
total() {
    valgrind --tool=callgrind --callgrind-out-file=/dev/null target/release/examples/one_method "$@" 2>&1 |
        sed -n 's/.*Collected : //p'
}
echo "| e | n | textbook | f64 | certified | lanes |"
echo "|---|---|---|---|---|---|"
for pair in "1 1" "0.5 0.5" "0.1 0.1" "0.0001 0.0001" "2.5 2.5"; do
    # shellcheck disable=SC2086
    none=$(total none $pair "$count")
    row="| ${pair/ / | } |"
    for method in textbook f64 certified lanes; do
        if [ "$method $pair" = "lanes 2.5 2.5" ]; then row="$row - |"; continue; fi
        # shellcheck disable=SC2086
        all=$(total $method $pair "$count")
        row="$row $(((all - none) / count)) |"
    done
    echo "$row"
done
