#!/usr/bin/env bash
# VTK 9.7.0 (PyPI): an XML file in ASCII mode names a compressor in its header although nothing in it is
# compressed, and so do LZ4 and LZMA: a reader that refuses files by this attribute refuses plain text.
# Seen 2026-11: compressor="vtkZLibDataCompressor" (the default) and "vtkLZ4DataCompressor" beside format="ascii" arrays only.
# For us: the reader decides by the format of each array (a test in crates/superegg-exchange/src/read/vtk).
# usage: findings/vtk_ascii_compressor.sh   (needs python3 with venv, and the network)
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/venv"
"$work/venv/bin/pip" install --quiet vtk==9.7.0
"$work/venv/bin/python" - "$work" <<'PYTHON'
import re
import sys

import vtk

points = vtk.vtkPoints()
points.InsertNextPoint(1, 2, 3)
data = vtk.vtkPolyData()
data.SetPoints(points)
for name, compressor in (("default", None), ("lz4", vtk.vtkLZ4DataCompressor())):
    writer = vtk.vtkXMLPolyDataWriter()
    writer.SetFileName(f"{sys.argv[1]}/{name}.vtp")
    writer.SetInputData(data)
    writer.SetDataModeToAscii()
    if compressor:
        writer.SetCompressor(compressor)
    assert writer.Write() == 1
    text = open(f"{sys.argv[1]}/{name}.vtp").read()
    found = re.search(r'compressor="(\w+)"', text)
    formats = set(re.findall(r'<DataArray[^>]*format="(\w+)"', text))
    print(name, "compressor:", found and found.group(1), "formats:", formats)
    assert found, "no compressor is named now"
    assert formats == {"ascii"}, "arrays are no longer ASCII"
PYTHON
echo "as before"
