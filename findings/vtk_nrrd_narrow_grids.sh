#!/usr/bin/env bash
# VTK 9.7.2, PyVista 0.49.2 (PyPI): vtkNrrdReader takes the first axis of a NRRD file for the components of a vector if it has
# nine samples or fewer, even where the file has "kinds: domain domain domain". A grid of n x ny x nz values becomes a flat
# picture of ny x nz points with n components, with the spacing of y in x, without a warning. A grid around a slender shape
# along y or z has no volume, and one with ten samples in x is right. "axis mins" are left out as well: such a grid begins at 0.
# The documentation lists limits of the reader, but neither of these. SimpleITK and pynrrd read three axes and one component.
# Seen 2026-12, 9 x 40 x 50 samples with a spacing of 0.1 x 0.2 x 0.3: 40 x 50 x 1 points with 9 components, a size of 7.8 x
# 14.7 x 0; with 10 x 40 x 50 samples 0.9 x 7.8 x 14.7. The origin of a grid with "axis mins: -1 -2 -3": 0 0 0.
# For us: a row in docs/formats.md; `superegg export scene.scn -o grid.vti --grid N` for VTK and ParaView, or ten samples or
# more along x.
# usage: findings/vtk_nrrd_narrow_grids.sh   (needs python3 with venv, and the network)
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/venv"
"$work/venv/bin/pip" install --quiet vtk==9.7.2 pyvista==0.49.2 pynrrd==1.1.3 simpleitk==2.5.7 numpy
"$work/venv/bin/python" - "$work/grid.nrrd" <<'PYTHON'
import sys

import nrrd
import numpy as np
import pyvista
import SimpleITK
import vtk
from vtk.util.numpy_support import vtk_to_numpy

path = sys.argv[1]
print("VTK", vtk.vtkVersion().GetVTKVersion(), "PyVista", pyvista.__version__)
DIRECTIONS = "space directions: (0.1,0,0) (0,0.2,0) (0,0,0.3)\nspace origin: (-1,-2,-3)\n"
MINS = "spacings: 0.1 0.2 0.3\naxis mins: -1 -2 -3\ncenterings: node node node\n"


def read(counts, fields):
    values = np.arange(np.prod(counts), dtype="<f4")
    space = "space dimension: 3\n" if "space" in fields.split() else ""
    header = (f"NRRD0004\ntype: float\ndimension: 3\n{space}sizes: {' '.join(map(str, counts))}\n{fields}"
              "kinds: domain domain domain\nendian: little\nencoding: raw\n\n")
    with open(path, "wb") as file:
        file.write(header.encode() + values.tobytes())
    # Two other readers agree about the axes.
    data, _ = nrrd.read(path)
    image = SimpleITK.ReadImage(path)
    assert data.shape == image.GetSize() == counts and image.GetNumberOfComponentsPerPixel() == 1
    assert np.allclose(image.GetSpacing(), (0.1, 0.2, 0.3)) and np.allclose(image.GetOrigin(), (-1, -2, -3))
    assert np.array_equal(data.ravel(order="F"), values)
    reader = vtk.vtkNrrdReader()
    reader.SetFileName(path)
    reader.Update()
    grid = reader.GetOutput()
    assert reader.GetErrorCode() == 0
    assert np.array_equal(vtk_to_numpy(grid.GetPointData().GetScalars()).ravel(), values)
    assert pyvista.read(path).dimensions == grid.GetDimensions()
    return grid


for first in (4, 9, 10):
    counts = (first, 40, 50)
    grid = read(counts, DIRECTIONS)
    bounds = np.reshape(grid.GetBounds(), (3, 2))
    found = grid.GetDimensions(), grid.GetNumberOfScalarComponents(), np.ptp(bounds, axis=1).round(3).tolist()
    print(counts, "samples: {} points, components {}, size {}".format(*found))
    size = [0.1 * (first - 1), 7.8, 14.7]
    expected = (counts, 1, size) if first == 10 else ((40, 50, 1), first, [7.8, 14.7, 0])
    assert found[:2] == expected[:2], "the first axis is read differently now"
    assert np.allclose(found[2], expected[2]), "the size is another now"

for fields, expected in ((DIRECTIONS, (-1, -2, -3)), (MINS, (0, 0, 0))):
    origin = read((20, 40, 50), fields).GetOrigin()
    print(fields.splitlines()[1], "-> VTK's origin:", origin)
    assert np.allclose(origin, expected), "the origin is another now"
PYTHON
echo "as before"
