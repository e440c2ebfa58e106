#!/usr/bin/env bash
# OVITO 3.17.2 (PyPI) reads a LIGGGHTS text dump of superquadrics without an error or a warning, at half size,
# unrotated and as ellipsoids: it takes shapex..z for diameters (LAMMPS's meaning), does not map quat1..4 to
# Orientation, and does not map blockiness1/2 to Superquadric Roundness.
# Seen 2026-11: Aspherical Shape [0.5, 1, 1.5] for semi-axes 1 2 3; properties quat1..4 and blockiness1/2 as plain numbers.
# For us: docs/formats.md says what our .vtp gives OVITO instead (TENSOR, shapex.., blockiness1/2), which it reads right.
# usage: findings/ovito_liggghts_dump.sh   (needs python3 with venv, and the network)
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/venv"
"$work/venv/bin/pip" install --quiet ovito==3.17.2
cat > "$work/one.dump" <<'DUMP'
ITEM: TIMESTEP
0
ITEM: NUMBER OF ATOMS
1
ITEM: BOX BOUNDS ff ff ff
-5 5
-5 5
-5 5
ITEM: ATOMS id type x y z shapex shapey shapez quat1 quat2 quat3 quat4 blockiness1 blockiness2
1 1 0 0 0 1 2 3 0.707107 0.707107 0 0 8 2
DUMP
"$work/venv/bin/python" - "$work/one.dump" <<'PYTHON'
import sys
from ovito.io import import_file

particles = import_file(sys.argv[1]).compute().particles
shape = particles["Aspherical Shape"][0].tolist()
names = sorted(particles.keys())
print("Aspherical Shape:", shape)
print("properties:", ", ".join(names))
assert shape == [0.5, 1.0, 1.5], "the sizes are no longer halved"
assert "Orientation" not in names, "the rotation is read now"
assert "Superquadric Roundness" not in names, "the exponents are read now"
assert {"quat1", "blockiness1"} <= set(names), "the columns have other names now"
PYTHON
echo "as before"
