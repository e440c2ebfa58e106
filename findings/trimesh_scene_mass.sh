#!/usr/bin/env bash
# trimesh 5.2.0 (PyPI): volume, area, center_mass and moment_inertia of a Scene leave out the scale of each node. A file of
# instances that have their sizes in their nodes, as a .glb can, gets the volume of that many unit shapes, without a warning.
# Bounds and to_mesh() take the scale into account. 4.12.2 and 5.0.0 do the same.
# Seen 2026-12, two balls of radius 2 and 0.5, ten apart, one mesh: volume 8.36 and not 33.96, area 25.1 and not 53.3, the centre
# of mass at 5 and not 0.154, the largest moment of inertia 1686 and not 105.
# For us: a row in docs/formats.md; scene.to_mesh() first, or `superegg measure`.
# usage: findings/trimesh_scene_mass.sh   (needs python3 with venv, and the network)
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/venv"
"$work/venv/bin/pip" install --quiet trimesh==5.2.0 numpy scipy networkx
"$work/venv/bin/python" - "$work" <<'PYTHON'
import sys

import numpy as np
import trimesh

print("trimesh", trimesh.__version__)
written = trimesh.Scene()
name = written.add_geometry(trimesh.creation.icosphere(subdivisions=4), node_name="large", transform=np.diag([2, 2, 2, 1]))
small = np.diag([0.5, 0.5, 0.5, 1])
small[0, 3] = 10
written.graph.update(frame_to="small", geometry=written.graph["large"][1], matrix=small)
written.export(f"{sys.argv[1]}/two.glb")

scene = trimesh.load_scene(f"{sys.argv[1]}/two.glb")
assert len(scene.geometry) == 1 and len(scene.graph.nodes_geometry) == 2
mesh = scene.to_mesh()

radii, xs = np.array([2, 0.5]), np.array([0, 10])
masses = 4 / 3 * np.pi * radii**3
centre = masses @ xs / masses.sum()
exact = {
    "volume": masses.sum(),
    "area": 4 * np.pi * np.sum(radii**2),
    "x of center_mass": centre,
    "largest of moment_inertia": np.sum(0.4 * masses * radii**2 + masses * (xs - centre) ** 2),
}


def measures(of):
    return of.volume, of.area, of.center_mass[0], np.linalg.eigvalsh(of.moment_inertia)[-1]


unit = 4 / 3 * np.pi
for what, of_scene, of_mesh in zip(exact, measures(scene), measures(mesh)):
    print(f"{what}: scene {of_scene:.3f}, its mesh {of_mesh:.3f}, exact {exact[what]:.3f}")
    assert abs(of_mesh / exact[what] - 1) < 0.01
    assert abs(of_scene / exact[what] - 1) > 0.5, f"the {what} of a scene is right now"
assert abs(scene.volume / (2 * unit) - 1) < 0.01, "not the volume of two unit balls now"
assert abs(scene.area / (8 * np.pi) - 1) < 0.01, "not the area of two unit balls now"
assert abs(scene.center_mass[0] - 5) < 0.01, "not the middle of the two balls now"
assert np.allclose(scene.bounds, [[-2, -2, -2], [10.5, 2, 2]], atol=1e-6)
PYTHON
echo "as before"
