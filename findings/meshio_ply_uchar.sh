#!/usr/bin/env bash
# meshio 5.3.5 (PyPI) reads a property "uchar" of a binary PLY file as a signed byte: a colour of 255 is -1, and 200 is -56. The
# same header in an ASCII file gives 255 and 200, and so does "uint8" in a binary one. "uchar" is the name of the type in the
# first description of the format, and many programs write it. A conversion keeps the error: the PLY that meshio writes declares
# int8, and its legacy .vtk declares vtktypeint8, a type that VTK 9.7.2 rejects.
# Seen 2026-12: red [-1, -56] of type int8 from binary "uchar"; [255, 200] of type uint8 from ASCII "uchar" and from binary
# "uint8".
# For us: a row in docs/formats.md; `array.view("uint8")` restores the colours of our .ply.
# usage: findings/meshio_ply_uchar.sh   (needs python3 with venv, and the network)
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/venv"
"$work/venv/bin/pip" install --quiet meshio==5.3.5 vtk==9.7.2 numpy
"$work/venv/bin/python" - "$work" <<'PYTHON'
import sys

import meshio
import numpy as np
import vtk

work = sys.argv[1]
print("meshio", meshio.__version__)
red = [255, 200, 1]
vertices = np.zeros(3, dtype=[("at", "<f4", 3), ("red", "u1")])
vertices["at"] = np.eye(3)
vertices["red"] = red


def header(encoding, byte):
    return (f"ply\nformat {encoding} 1.0\nelement vertex 3\n"
            "property float x\nproperty float y\nproperty float z\n"
            f"property {byte} red\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n").encode()


def write(name, data):
    with open(f"{work}/{name}", "wb") as file:
        file.write(data)


body = vertices.tobytes() + b"\3" + np.arange(3, dtype="<i4").tobytes()
rows = [f"{x:g} {y:g} {z:g} {byte}\n" for (x, y, z), byte in vertices.tolist()]
write("binary_uchar.ply", header("binary_little_endian", "uchar") + body)
write("binary_uint8.ply", header("binary_little_endian", "uint8") + body)
write("ascii_uchar.ply", header("ascii", "uchar") + "".join(rows).encode() + b"3 0 1 2\n")

read = {}
for name in ("binary_uchar", "binary_uint8", "ascii_uchar"):
    mesh = meshio.read(f"{work}/{name}.ply")
    assert np.array_equal(mesh.points, np.eye(3)), "the points are others now"
    read[name] = mesh.point_data["red"]
    print(f"{name}: {read[name].tolist()} of type {read[name].dtype}")
assert read["binary_uint8"].tolist() == read["ascii_uchar"].tolist() == red
assert read["binary_uchar"].dtype == np.int8, "binary uchar is unsigned now"
assert read["binary_uchar"].tolist() == [-1, -56, 1]
assert read["binary_uchar"].view("uint8").tolist() == red

mesh = meshio.read(f"{work}/binary_uchar.ply")
mesh.write(f"{work}/converted.ply")
mesh.write(f"{work}/converted.vtk")
lines = open(f"{work}/converted.ply", "rb").read().split(b"\n")
written = next(line.decode() for line in lines if line.endswith(b" red"))
vtk.vtkObject.GlobalWarningDisplayOff()
reader = vtk.vtkUnstructuredGridReader()
reader.SetFileName(f"{work}/converted.vtk")
reader.Update()
data = reader.GetOutput().GetPointData()
print(f"converted: {written!r} in the .ply; VTK finds {data.GetNumberOfArrays()} arrays in the .vtk")
assert written == "property int8 red", "conversions write another type now"
assert data.GetNumberOfArrays() == 0, "VTK reads the colours now"
PYTHON
echo "as before"
