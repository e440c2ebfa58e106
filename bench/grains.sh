#!/usr/bin/env bash
# A dump of N particles (default a million) to a picture 1280x960 with shadows: processor seconds and peak memory,
# beside OVITO's Tachyon on the same file in the same run if PYTHON has the package ovito; then trees over rows.
# usage: [PYTHON=...] bench/grains.sh [N]
set -euo pipefail
cd "$(dirname "$0")/.."
count=${1:-1000000}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cargo build --quiet --release --bin superegg
python3 bench/grains.py "$count" "$work/grains.dump"
measure() { /usr/bin/time -f "$1: %U + %S s of processor, %M kB" "${@:2}"; }
measure ours target/release/superegg render "$work/grains.dump" -o "$work/ours.png" --size 1280x960 --samples 1 --quiet
if [ -n "${PYTHON:-}" ]; then
    measure ovito "$PYTHON" - "$work" <<'EOF'
import sys
import numpy as np
from ovito.io import import_file
from ovito.vis import TachyonRenderer, Viewport

def right(frame, data):
    """Gives OVITO the sizes, rotations and exponents that it does not take from a LIGGGHTS dump."""
    p = data.particles_
    p.create_property("Aspherical Shape", data=2 * np.asarray(p["Aspherical Shape"]))
    p.create_property("Orientation", data=np.column_stack([p["quat2"], p["quat3"], p["quat4"], p["quat1"]]))
    exponents = [2 / np.asarray(p["blockiness2"]), 2 / np.asarray(p["blockiness1"])]
    p.create_property("Superquadric Roundness", data=np.column_stack(exponents))

pipeline = import_file(sys.argv[1] + "/grains.dump")
pipeline.modifiers.append(right)
pipeline.add_to_scene()
view = Viewport(type=Viewport.Type.Perspective, camera_pos=(1.8, -1.9, 1.5), camera_dir=(-1.3, 2.4, -1.0), fov=0.7)
renderer = TachyonRenderer(antialiasing=False, ambient_occlusion=False, shadows=True)
view.render_image(filename=sys.argv[1] + "/ovito.png", size=(1280, 960), renderer=renderer)
EOF
fi
for kind in random row same concentric; do
    python3 bench/grains.py 64000 "$work/$kind.dump" "$kind"
    target/release/superegg render "$work/$kind.dump" -o "$work/ours.png" --size 40x30 --quiet --stats "$work/stats.json"
    echo "compile 64,000, $kind: $(grep -o '"compile": [0-9.]*' "$work/stats.json") s"
done
