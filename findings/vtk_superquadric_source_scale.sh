#!/usr/bin/env bash
# VTK 9.7.2, PyVista 0.49.2 (PyPI): vtkSuperquadricSource scales its surface before it turns the axis of symmetry, so the scale
# (a, b, c) is along x, y, z only with the axis of symmetry 2 (z). With the initial axis 1 (y) the half-widths are a, c, b, and
# with axis 0 (x) they are c, b, a. The documentation of both programs promises factors in x, y and z. PyVista's Superquadric
# does not change the axis, so each of its shapes has y and z exchanged. vtkSuperquadric, the implicit function with the same
# parameters and the same axis y, takes them in the order x, y, z: the surface of one is not where the other is 0.
# Seen 2026-12, scale (1, 2, 3): half-widths [1, 3, 2] for axis 1, [3, 2, 1] for axis 0, [1, 2, 3] for axis 2; PyVista [1, 3,
# 2]. On the vertices of the source the implicit function with the same parameters is between -0.556 and 1.25, and within 3e-7
# of 0 where the source has the scale (1, 3, 2).
# For us: a row in docs/formats.md; axis 2 gives the source the axes of our shapes, and (a, c, b) those of vtkSuperquadric.
# usage: findings/vtk_superquadric_source_scale.sh   (needs python3 with venv, and the network)
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/venv"
"$work/venv/bin/pip" install --quiet vtk==9.7.2 pyvista==0.49.2 numpy
"$work/venv/bin/python" - <<'PYTHON'
import numpy as np
import pyvista
import vtk

print("VTK", vtk.vtkVersion().GetVTKVersion(), "PyVista", pyvista.__version__)
SCALE = (1, 2, 3)


def set_up(shape, theta, phi, scale):
    shape.ToroidalOff()
    shape.SetSize(1)
    shape.SetScale(*scale)
    shape.SetThetaRoundness(theta)
    shape.SetPhiRoundness(phi)
    return shape


def surface(theta, phi, scale, axis=None):
    source = set_up(vtk.vtkSuperquadricSource(), theta, phi, scale)
    source.SetThetaResolution(64)
    source.SetPhiResolution(64)
    if axis is not None:
        source.SetAxisOfSymmetry(axis)
    source.Update()
    return source.GetOutput()


def half_widths(mesh):
    bounds = np.array(mesh.GetBounds())
    return (bounds[1::2] - bounds[::2]) / 2


assert vtk.vtkSuperquadricSource().GetAxisOfSymmetry() == 1
for axis, expected in ((None, (1, 3, 2)), (0, (3, 2, 1)), (1, (1, 3, 2)), (2, (1, 2, 3))):
    found = half_widths(surface(1, 1, SCALE, axis))
    print("scale (1, 2, 3), axis of symmetry", "as it is" if axis is None else axis, "half-widths:", found.round(3).tolist())
    assert np.allclose(found, expected, rtol=0.001), "the scale is along other axes now"

found = half_widths(pyvista.Superquadric(size=1, scale=SCALE))
print("PyVista, scale (1, 2, 3), half-widths:", found.round(3).tolist())
assert np.allclose(found, (1, 3, 2), rtol=0.001), "PyVista's scale is along other axes now"

# With axis 2 the surface is that of the usual equation: semi-axes a b c, exponents e = theta (in xy) and n = phi (along z).
for e, n in ((0.3, 1), (1, 0.3), (0.5, 0.8)):
    mesh = surface(e, n, SCALE, 2)
    x, y, z = np.abs([mesh.GetPoint(i) for i in range(mesh.GetNumberOfPoints())]).T / np.array(SCALE)[:, None]
    assert np.allclose((x ** (2 / e) + y ** (2 / e)) ** (e / n) + z ** (2 / n), 1, atol=1e-6), "axis 2 is another surface now"


def values(theta, phi, source_scale):
    """The least and the greatest value of the implicit function of scale (1, 2, 3) on the vertices of a source."""
    implicit = set_up(vtk.vtkSuperquadric(), theta, phi, SCALE)
    # The implicit function has its scale along x, y and z.
    ends = [implicit.FunctionValue(end) for end in ((1, 0, 0), (0, 2, 0), (0, 0, 3))]
    assert np.allclose(ends, 0, atol=1e-12), "the implicit function has another scale now"
    mesh = surface(theta, phi, source_scale)
    found = [implicit.FunctionValue(mesh.GetPoint(i)) for i in range(mesh.GetNumberOfPoints())]
    return min(found), max(found)


for theta, phi in ((1, 1), (0.3, 1), (1, 0.3), (0.5, 0.8)):
    same, exchanged = values(theta, phi, SCALE), values(theta, phi, (1, 3, 2))
    print(f"roundness theta {theta}, phi {phi}: implicit function on the source of the same scale {same[0]:.3f} to {same[1]:.3f}, "
          f"of scale (1, 3, 2) {exchanged[0]:.1e} to {exchanged[1]:.1e}")
    assert same[0] < -0.5 and same[1] > 1, "source and implicit function agree now"
    assert max(map(abs, exchanged)) < 1e-6, "the exchanged scale is not the same surface now"
PYTHON
echo "as before"
