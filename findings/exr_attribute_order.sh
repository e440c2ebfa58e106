#!/usr/bin/env bash
# The Rust crate exr 1.74.2 keeps the attributes of a header that are not of the standard in a HashMap and writes them in its
# order, which differs from run to run: one program with one picture writes different bytes.
# Seen 2026-11: eight runs that write one pixel and eight text attributes give more than one file.
# For us: attributes are sorted in the finished header, so that equal renders give equal files (superegg-render/src/film).
# usage: findings/exr_attribute_order.sh   (needs Rust and the network)
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
mkdir "$work/src"
cat > "$work/Cargo.toml" <<'TOML'
[package]
name = "order"
version = "0.0.0"
edition = "2024"

[dependencies]
exr = { version = "=1.74.2", default-features = false }
TOML
cat > "$work/src/main.rs" <<'RUST'
use exr::prelude::*;

fn main() {
    let channels = SpecificChannels::rgb(|_: Vec2<usize>| (0.5_f32, 0.5_f32, 0.5_f32));
    let mut image = Image::from_channels((1, 1), channels);
    for number in 0..8 {
        let name = format!("note{number}");
        image.layer_data.attributes.other.insert(Text::from(name.as_str()), AttributeValue::Text(Text::from("x")));
    }
    let file = std::env::args().nth(1).expect("the file to write");
    image.write().to_file(file).expect("one pixel is written");
}
RUST
(cd "$work" && cargo build --quiet)
for run in 1 2 3 4 5 6 7 8; do
    "$work/target/debug/order" "$work/$run.exr"
done
different=$(sha256sum "$work"/*.exr | cut -d' ' -f1 | sort -u | wc -l)
sizes=$(stat -c %s "$work"/*.exr | sort -u | wc -l)
echo "eight runs: $different different files, $sizes size"
[ "$different" -gt 1 ] && [ "$sizes" = 1 ]
echo "as before"
