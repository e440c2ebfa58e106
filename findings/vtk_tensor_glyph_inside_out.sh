#!/usr/bin/env bash
# VTK 9.7.2 (PyPI): vtkTensorGlyph turns about half of its glyphs inside out. It takes the eigenvectors of a tensor as they are,
# and where these are left-handed, the glyph is mirrored: its triangles are wound inwards, and its normals point inwards, too. A
# comment in its source promises outward normals there, but the normals that it reverses were right already. The tensors are
# symmetric with positive eigenvalues, and the points of the surface are right. A mesh of glyphs in one file mixes volumes of
# both signs, and a viewer that leaves out back faces shows the inner side of half of them.
# Seen 2026-12, 200 tensors with the eigenvalues 1 2 3 in random rotations: 97 glyphs of volume -25 and 103 of 25; all normals
# of the 97 point inwards. diag(1, 2, 3) is inside out, diag(3, 2, 1) is not. vtkPolyDataNormals with AutoOrientNormals turns
# the triangles outwards, but keeps normals that the mesh already has; once they are removed, it makes right ones.
# For us: a row in docs/formats.md; the meshes that we export of tensors have positive volumes.
# usage: findings/vtk_tensor_glyph_inside_out.sh   (needs python3 with venv, and the network)
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/venv"
"$work/venv/bin/pip" install --quiet vtk==9.7.2 numpy
"$work/venv/bin/python" - <<'PYTHON'
import numpy as np
import vtk
from vtk.util.numpy_support import vtk_to_numpy

print("VTK", vtk.vtkVersion().GetVTKVersion())
EXACT = 4 / 3 * np.pi * 6


def glyph(tensor):
    """The glyph of one tensor at the origin: an ellipsoid whose semi-axes are the eigenvalues."""
    points = vtk.vtkPoints()
    points.InsertNextPoint(0, 0, 0)
    array = vtk.vtkDoubleArray()
    array.SetNumberOfComponents(9)
    array.InsertNextTuple(tensor.ravel().tolist())
    data = vtk.vtkPolyData()
    data.SetPoints(points)
    data.GetPointData().SetTensors(array)
    ball = vtk.vtkSphereSource()
    ball.SetRadius(1)
    ball.SetThetaResolution(48)
    ball.SetPhiResolution(48)
    glyphs = vtk.vtkTensorGlyph()
    glyphs.SetInputData(data)
    glyphs.SetSourceConnection(ball.GetOutputPort())
    glyphs.Update()
    return glyphs.GetOutput()


def volume(mesh):
    """The volume within the triangles, negative if they are wound inwards."""
    corners = vtk_to_numpy(mesh.GetPoints().GetData()).astype(float)[
        vtk_to_numpy(mesh.GetPolys().GetConnectivityArray()).reshape(-1, 3)]
    return np.sum(corners[:, 0] * np.cross(corners[:, 1], corners[:, 2])) / 6


def outward(mesh):
    """The share of the normals that point away from the centre."""
    points, normals = (vtk_to_numpy(of) for of in (mesh.GetPoints().GetData(), mesh.GetPointData().GetNormals()))
    return np.mean(np.sum(points * normals, axis=1) > 0)


def repaired(mesh, keep_normals=False):
    copy = vtk.vtkPolyData()
    copy.ShallowCopy(mesh)
    if not keep_normals:
        copy.GetPointData().SetNormals(None)
    normals = vtk.vtkPolyDataNormals()
    normals.SetInputData(copy)
    normals.SplittingOff()
    normals.ConsistencyOn()
    normals.AutoOrientNormalsOn()
    normals.Update()
    return normals.GetOutput()


for axes, sign in (((1, 2, 3), -1), ((3, 2, 1), 1)):
    mesh = glyph(np.diag(axes).astype(float))
    print(f"diag{axes}: volume {volume(mesh):.2f}, exact {EXACT:.2f}; normals that point outwards: {outward(mesh):.0%}")
    assert abs(volume(mesh) / EXACT - sign) < 0.02, "this glyph has the other orientation now"
    assert outward(mesh) == (sign > 0)
    kept = repaired(mesh, keep_normals=True)
    assert volume(kept) > 0 and outward(kept) == (sign > 0), "vtkPolyDataNormals replaces normals now"

random = np.random.default_rng(1)
inside_out = 0
for _ in range(200):
    rotation, _ = np.linalg.qr(random.normal(size=(3, 3)))
    rotation *= np.linalg.det(rotation)
    tensor = rotation @ np.diag([1.0, 2, 3]) @ rotation.T
    mesh = glyph((tensor + tensor.T) / 2)
    # The surface itself is right: x T^-2 x = 1.
    points = vtk_to_numpy(mesh.GetPoints().GetData()).astype(float)
    assert np.allclose(np.sum((points @ np.linalg.inv(tensor)) ** 2, axis=1), 1, atol=1e-4), "the surface is another now"
    assert abs(abs(volume(mesh)) / EXACT - 1) < 0.02
    assert outward(mesh) == (volume(mesh) > 0), "normals and triangles differ now"
    inside_out += volume(mesh) < 0
    assert volume(repaired(mesh)) > 0 and outward(repaired(mesh)) == 1, "vtkPolyDataNormals does not repair them now"
print(f"200 tensors in random rotations: {inside_out} glyphs inside out")
assert 60 < inside_out < 140, "glyphs have another orientation now"
PYTHON
echo "as before"
