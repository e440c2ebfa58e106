#!/usr/bin/env bash
# FURY 2.0.0 (PyPI, with pygfx 0.17.0): actor.superquadric draws three superquadrics with one size (a, b, c) with equal
# semi-axes: a for the first, b for the second, c for the third. One, two or four superquadrics get the size that its
# documentation promises. A list of as many numbers as there are centres is read as one factor a centre
# (primitive.repeat_primitive), and three axes are three numbers. The directions turn the x axis of the shape, although its axis
# of symmetry is z, and a direction of -x mirrors the shape at its centre: its triangles then face inwards.
# Seen 2026-12, roundness 0.5 and size (1, 2, 3): half-widths 1 2 3 for one, two and four centres, and 1 1 1, 2 2 2 and 3 3 3 for
# three. Size (1, 1, 3) in the direction +z lies along x. Volume 18.157 in the direction +x, -18.157 in the direction -x.
# For us: a row in docs/formats.md; scales as an array of one row a shape are right for any number.
# usage: findings/fury_superquadric_scales.sh   (needs python3 with venv, and the network)
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/venv"
"$work/venv/bin/pip" install --quiet fury==2.0.0 pygfx==0.17.0
"$work/venv/bin/python" - <<'PYTHON'
import fury
import numpy as np
from fury import actor

print("FURY", fury.__version__)


def half_widths(centres, **options):
    """The half-widths of each superquadric, from the triangles that are drawn."""
    shapes = actor.superquadric(centres, **options).geometry.positions.data
    return [np.ptp(points, axis=0) / 2 for points in shapes.reshape(len(centres), -1, 3)]


def volume(**options):
    """The volume within the triangles of one superquadric, negative if they face inwards."""
    geometry = actor.superquadric(np.zeros((1, 3)), **options).geometry
    corners = geometry.positions.data.astype(float)[geometry.indices.data]
    return np.sum(corners[:, 0] * np.cross(corners[:, 1], corners[:, 2])) / 6


for count in (1, 2, 3, 4):
    centres = np.arange(count)[:, None] * np.array([10.0, 0, 0])
    found = half_widths(centres, roundness=(0.5, 0.5), scales=(1, 2, 3))
    print(f"{count} centres, size (1, 2, 3):", *(np.round(one, 2).tolist() for one in found))
    expected = [[1, 1, 1], [2, 2, 2], [3, 3, 3]] if count == 3 else [[1, 2, 3]] * count
    assert np.allclose(found, expected, rtol=0.01), "the sizes are others now"
    rows = half_widths(centres, roundness=(0.5, 0.5), scales=np.tile([1.0, 2, 3], (count, 1)))
    assert np.allclose(rows, [[1, 2, 3]] * count, rtol=0.01), "rows of sizes are read differently now"

for direction, expected in (((1, 0, 0), (1, 1, 3)), ((0, 0, 1), (3, 1, 1))):
    found, = half_widths(np.zeros((1, 3)), roundness=(0.2, 1), scales=(1, 1, 3), directions=direction)
    print(f"size (1, 1, 3), direction {direction}:", np.round(found, 2).tolist())
    assert np.allclose(found, expected, rtol=0.01), "another axis is turned now"

forwards, backwards = (
    volume(roundness=(0.2, 1), scales=(1, 1, 3), directions=direction) for direction in ((1, 0, 0), (-1, 0, 0)))
print("volume, direction +x:", round(forwards, 3), "direction -x:", round(backwards, 3))
# A section of area pi (e = 1) times the integral of the profile with n = 0.2 over the height 6, exactly 18.60.
heights = np.linspace(-1, 1, 200001)
exact = 3 * np.pi * np.trapezoid((1 - np.abs(heights) ** 10) ** 0.2, heights)
assert abs(forwards / exact - 1) < 0.05, exact
assert np.isclose(backwards, -forwards), "triangles face outwards now"
PYTHON
echo "as before"
