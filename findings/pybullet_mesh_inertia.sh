#!/usr/bin/env bash
# PyBullet 3.2.7 (PyPI) takes the inertia of a mesh (GEOM_MESH) from its bounding box, not from its shape: a ball as a mesh has
# 2/3 m r^2, and not the 2/5 m r^2 of GEOM_SPHERE. The box is that of the mesh's own axes, so the same grain, turned in its file,
# has another inertia. Each mesh has also a margin of 0.001 units, whatever its size: the box of the inertia grows by three times
# that on each side, and distances go to a surface that lies 0.001 outside. In metres a ball of radius 10 mm has 2.8 times its
# inertia, and one of 1 mm has 27 times its inertia and touches a neighbour that is 1 mm away.
# Seen 2026-12: inertia / (m r^2) 0.671, 1.127 and 10.667 for meshes of radius 1, 0.01 and 0.001; 0.400 for each sphere.
# getClosestPoints gives 0.999 r, 0.900 r and 0.000 r for a gap of r. changeDynamics with collisionMargin=0 makes it 1.000 r, but
# leaves the inertia. An ellipsoid of 1 2 3: 4.34 3.34 1.67, exact 2.6 2.0 1.0; turned by 45 degrees about z 3.84 3.84 1.67.
# For us: a row in docs/formats.md; `superegg measure` and `inertia` in Python give the tensor for changeDynamics.
# usage: findings/pybullet_mesh_inertia.sh   (needs python3 with venv, of a version for which PyPI has a wheel, such as 3.11, and
# the network)
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/venv"
"$work/venv/bin/pip" install --quiet --only-binary=:all: pybullet==3.2.7 numpy
"$work/venv/bin/python" - <<'PYTHON'
from importlib.metadata import version

import numpy as np
import pybullet

print("PyBullet", version("pybullet"))
pybullet.connect(pybullet.DIRECT)
MASS = 1.0


def points(semi_axes):
    """Points of an ellipsoid, the ends of its axes among them."""
    longitude, latitude = np.meshgrid(np.linspace(0, 2 * np.pi, 48, endpoint=False), np.linspace(-np.pi / 2, np.pi / 2, 25))
    unit = np.stack([np.cos(latitude) * np.cos(longitude), np.cos(latitude) * np.sin(longitude), np.sin(latitude)], axis=-1)
    return np.unique(unit.reshape(-1, 3).round(12), axis=0) * semi_axes


def body(shape, at=(0, 0, 0)):
    return pybullet.createMultiBody(MASS, shape, basePosition=at)


def mesh(semi_axes, turn=np.eye(3)):
    return body(pybullet.createCollisionShape(pybullet.GEOM_MESH, vertices=(points(semi_axes) @ turn.T).tolist()))


def inertia(of):
    return np.array(pybullet.getDynamicsInfo(of, -1)[2])


def gap(one, other):
    return pybullet.getClosestPoints(one, other, 100)[0][8]


for radius, expected_inertia, expected_gap in ((1, 0.671, 0.999), (0.01, 1.127, 0.9), (0.001, 10.667, 0)):
    pybullet.resetSimulation()
    ball = mesh([radius] * 3)
    # The sphere is 3 r away from the ball, so that one r of space is between them.
    sphere = body(pybullet.createCollisionShape(pybullet.GEOM_SPHERE, radius=radius), (3 * radius, 0, 0))
    of_mesh, of_sphere = inertia(ball) / (MASS * radius**2), inertia(sphere) / (MASS * radius**2)
    before = gap(ball, sphere) / radius
    pybullet.changeDynamics(ball, -1, collisionMargin=0)
    after = gap(ball, sphere) / radius
    print(f"radius {radius:g}: inertia {of_mesh[0]:.3f} as a mesh, {of_sphere[0]:.3f} as a sphere; "
          f"gap {before:.3f}, without the margin {after:.3f}")
    assert np.allclose(of_sphere, 0.4)
    assert np.allclose(of_mesh, expected_inertia, atol=0.001), "the inertia of a mesh is another now"
    assert np.allclose(inertia(ball) / (MASS * radius**2), of_mesh)
    assert abs(before - expected_gap) < 0.001, "the margin is another now"
    assert abs(after - 1) < 0.001, "collisionMargin has another effect now"
    pybullet.changeDynamics(ball, -1, localInertiaDiagonal=[0.4 * MASS * radius**2] * 3)
    assert np.allclose(inertia(ball) / (MASS * radius**2), 0.4), "localInertiaDiagonal is not taken now"

a, b, c = 1, 2, 3
exact = MASS / 5 * np.array([b * b + c * c, a * a + c * c, a * a + b * b])
box = MASS / 3 * np.array([b * b + c * c, a * a + c * c, a * a + b * b])
turn = np.array([[1, -1, 0], [1, 1, 0], [0, 0, np.sqrt(2)]]) / np.sqrt(2)
straight, turned = inertia(mesh([a, b, c])), inertia(mesh([a, b, c], turn))
print("ellipsoid 1 2 3:", np.round(straight, 2).tolist(), "exact:", exact.tolist())
print("turned by 45 degrees about z:", np.round(turned, 2).tolist())
assert np.allclose(straight, box, rtol=0.01), "the inertia is no longer that of the bounding box"
# The bounding box of the turned ellipsoid has the half-widths sqrt((a^2 + b^2) / 2) in x and y.
assert np.allclose(turned[:2], MASS / 3 * ((a * a + b * b) / 2 + c * c), rtol=0.02), "the turned inertia is another now"
PYTHON
echo "as before"
