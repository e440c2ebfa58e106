#!/usr/bin/env bash
# VTK 9.7.2 (PyPI): the gradient of vtkSuperquadric is (0, 0, 0) everywhere, without a warning, although its values are right
# (vtkSphere beside it has a gradient). So vtkSampleFunction with ComputeNormals gives zero normals for a superquadric, and
# whatever follows the gradient of the implicit function (a projection onto the surface, a signed distance) stands still.
# Seen 2026-11: gradient (0.0, 0.0, 0.0) where the difference quotient of the values is (0.556, 0.031, 0.062); the longest of
# 8,000 normals has length 0. 9.5.2 does the same.
# For us: a row in docs/formats.md; normals come from the surface of the mesh, or from `superegg measure` and Python's `normal`.
# usage: findings/vtk_superquadric_gradient.sh   (needs python3 with venv, and the network)
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
shape = vtk.vtkSuperquadric()
shape.ToroidalOff()
shape.SetSize(1)
shape.SetScale(1, 2, 3)
shape.SetPhiRoundness(0.5)
shape.SetThetaRoundness(1)
surface = [shape.FunctionValue(point) for point in ((1, 0, 0), (0, 2, 0), (0, 0, 3))]
print("values at the ends of the axes:", surface)
assert np.allclose(surface, 0, atol=1e-12)

at, step = np.array([0.5, 0.5, 0.5]), 1e-5
quotient = [(shape.FunctionValue(at + h) - shape.FunctionValue(at - h)) / (2 * step) for h in step * np.eye(3)]
gradient = shape.FunctionGradient(at)
print("difference quotient:", np.round(quotient, 3), "gradient:", gradient)
assert min(quotient) > 0.01
assert vtk.vtkSphere().FunctionGradient(at) == (1, 1, 1)
assert gradient == (0, 0, 0), "vtkSuperquadric has a gradient now"

sample = vtk.vtkSampleFunction()
sample.SetImplicitFunction(shape)
sample.SetModelBounds(-4, 4, -4, 4, -4, 4)
sample.SetSampleDimensions(20, 20, 20)
sample.ComputeNormalsOn()
sample.Update()
longest = np.linalg.norm(vtk_to_numpy(sample.GetOutput().GetPointData().GetNormals()), axis=1).max()
print("longest normal of vtkSampleFunction:", longest)
assert longest == 0, "vtkSampleFunction has normals now"
PYTHON
echo "as before"
