#!/usr/bin/env python3
"""Runs the notebooks of examples/python and writes each as a page of docs/python, with its outputs and pictures.

    python3 tools/notebooks.py            write the pages
    python3 tools/notebooks.py --check    fail if a page does not say what its notebook says now

Needs superegg, nbclient, ipykernel and scipy. The check takes numbers as equal up to 2 %, and does not compare pictures: both
depend on the machine in their last digits.
"""

from __future__ import annotations

import base64
import re
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
NOTEBOOKS = sorted((ROOT / "examples" / "python").glob("*.ipynb"))
PAGES = ROOT / "docs" / "python"

NUMBER = re.compile(r"-?\d+(?:\.\d*)?(?:[eE][-+]?\d+)?")


def executed(path):
    """The notebook with its outputs."""
    import nbclient
    import nbformat

    notebook = nbformat.read(path, as_version=4)
    nbclient.NotebookClient(notebook, timeout=300, kernel_name="python3").execute()
    return notebook


def page_of(notebook, name):
    """The page of an executed notebook, and its pictures by file name."""
    parts, pictures = [], {}
    for cell in notebook.cells:
        source = cell["source"].strip()
        if cell["cell_type"] == "markdown":
            parts.append(source)
            continue
        parts.append(f"```python\n{source}\n```")
        for output in cell.get("outputs", []):
            data = output.get("data", {})
            if "image/png" in data:
                file = f"{name}-{len(pictures) + 1}.png"
                pictures[file] = base64.b64decode(data["image/png"])
                parts.append(f"![{data.get('text/plain', 'a picture')}]({file})")
            else:
                text = output.get("text") or data.get("text/plain", "")
                parts.append(f"```text\n{text.strip()}\n```")
    source = f"[examples/python/{name}.ipynb](../../examples/python/{name}.ipynb)"
    parts.append(f"Made from {source} by `tools/notebooks.py`.")
    return "\n\n".join(parts) + "\n", pictures


def is_same(page, other):
    """Whether two pages say the same: equal words, and numbers that are nearly equal."""
    if NUMBER.sub("#", page) != NUMBER.sub("#", other):
        return False
    pairs = zip(NUMBER.findall(page), NUMBER.findall(other), strict=True)
    return all(abs(float(a) - float(b)) <= 0.02 * max(abs(float(a)), abs(float(b)), 1e-2) for a, b in pairs)


def difference(notebook, name):
    """What is wrong with the page of an executed notebook; an empty text if nothing is."""
    page, pictures = page_of(notebook, name)
    path = PAGES / f"{name}.md"
    if not path.is_file():
        return f"{path} is not there"
    if not is_same(page, path.read_text()):
        return f"{path} is not what its notebook says now"
    missing = [file for file in pictures if not (PAGES / file).is_file()]
    return f"{PAGES} lacks {', '.join(missing)}" if missing else ""


def main():
    is_check = sys.argv[1:] == ["--check"]
    if sys.argv[1:] and not is_check:
        sys.exit(__doc__)
    found = []
    for path in NOTEBOOKS:
        notebook = executed(path)
        if is_check:
            found.append(difference(notebook, path.stem))
            continue
        page, pictures = page_of(notebook, path.stem)
        PAGES.mkdir(exist_ok=True)
        (PAGES / f"{path.stem}.md").write_text(page)
        for file, png in pictures.items():
            (PAGES / file).write_bytes(png)
        print(f"{path.stem}: {len(pictures)} pictures")
    if any(found):
        sys.exit("\n".join(text for text in found if text) + "\ntools/notebooks.py makes them anew")


if __name__ == "__main__":
    main()
