"""The notebooks run and are what their pages say, and a Dask cluster renders the bytes that one process renders."""

import importlib.util
import subprocess
import sys
from pathlib import Path

import pytest

import superegg as se

EXAMPLES = Path(__file__).resolve().parents[3] / "examples"
NOTEBOOKS = sorted((EXAMPLES / "python").glob("*.ipynb"))


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_notebooks_run(path):
    pytest.importorskip("nbclient")
    nbformat = pytest.importorskip("nbformat")
    pytest.importorskip("ipykernel")
    if "scipy" in path.read_text():
        pytest.importorskip("scipy")
    notebook = nbformat.read(path, as_version=4)
    assert not any(cell.get("outputs") for cell in notebook.cells), "outputs are not kept"
    spec = importlib.util.spec_from_file_location("notebooks", EXAMPLES.parent / "tools" / "notebooks.py")
    notebooks = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(notebooks)
    notebook = notebooks.executed(path)
    outputs = [output for cell in notebook.cells for output in cell.get("outputs", [])]
    assert any("image/png" in output.get("data", {}) for output in outputs)
    assert notebooks.difference(notebook, path.stem) == ""


def test_a_dask_cluster_renders_the_same_bytes(tmp_path):
    pytest.importorskip("distributed")
    script = EXAMPLES / "dask" / "render.py"
    if not script.is_file():
        pytest.skip("the example is in the repository of the project alone")
    scene = tmp_path / "turning.scn"
    scene.write_text(
        "primitive egg\nsetCoeff 1 1 1.3\nsetExponent 1 0.5\nobject pair\naddPrimitive egg\n"
        "key 0 rotate 1 0 0 0\nkey 4 rotate 1 0 0 90\ncamera 3 4 5 0 0 0\n"
    )
    options = ["--", "--size", "96x64", "--samples", "2"]
    out = tmp_path / "picture.png"
    run = [sys.executable, str(script), str(scene)]
    subprocess.run([*run, "-o", str(out), "--shards", "3", *options], check=True, timeout=300)
    whole = se.load(scene).render(96, 64, samples=2)
    assert out.read_bytes() == whole.to_png()
    frames = tmp_path / "frames"
    subprocess.run([*run, "-o", str(frames), "--frames", "0", "2", *options], check=True, timeout=300)
    pictures = [path.read_bytes() for path in sorted(frames.glob("*.png"))]
    assert len(pictures) == 3 and len(set(pictures)) == 3
