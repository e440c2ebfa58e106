"""Renders a scene on a Dask cluster: the shards of one picture, or the frames of a film.

    python render.py SCENE -o picture.png --shards 16 [--scheduler ADDRESS] [-- OPTION OF 'superegg render' ...]
    python render.py SCENE -o folder --frames 0 48     [--scheduler ADDRESS] [-- OPTION OF 'superegg render' ...]

Without a scheduler a LocalCluster is started here. The package superegg must be installed on the workers; the scene
travels to them, so they share no disk. The picture is the same to the bit however many shards there are.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
import tempfile
from pathlib import Path

from dask.distributed import Client, LocalCluster, as_completed

PROGRAM = [sys.executable, "-m", "superegg"]


def rendered(scene: bytes, ending: str, output: str, arguments: list[str]) -> bytes:
    """Renders on the worker, and returns the bytes of the output file."""
    with tempfile.TemporaryDirectory() as folder:
        source, target = Path(folder, "scene" + ending), Path(folder, output)
        source.write_bytes(scene)
        command = [*PROGRAM, "render", str(source), "-o", str(target), "--quiet", "--threads", "1", *arguments]
        run = subprocess.run(command, capture_output=True, text=True)
        if run.returncode != 0:
            raise RuntimeError(run.stderr)
        return target.read_bytes()


def picture(client: Client, scene: Path, output: Path, shards: int, options: list[str]) -> None:
    """Renders the shards of a picture and merges them."""
    data = client.scatter(scene.read_bytes(), broadcast=True)
    shares = [f"{k}/{shards}" for k in range(1, shards + 1)]
    jobs = [
        client.submit(rendered, data, scene.suffix, "shard.part", ["--shard", share, *options], pure=False)
        for share in shares
    ]
    with tempfile.TemporaryDirectory() as folder:
        parts = [Path(folder, f"{k}.part") for k in range(shards)]
        for job, part in zip(jobs, parts, strict=True):
            part.write_bytes(job.result())
        subprocess.run([*PROGRAM, "merge", *map(str, parts), "-o", str(output)], check=True)


def film(client: Client, scene: Path, folder: Path, frames: range, options: list[str]) -> None:
    """Renders the frames of a film into a folder; those that are there stay."""
    folder.mkdir(parents=True, exist_ok=True)
    data = client.scatter(scene.read_bytes(), broadcast=True)
    jobs = {}
    for frame in frames:
        target = folder / f"frame-{frame:05}.png"
        if not target.exists():
            arguments = ["--frame", str(frame), *options]
            jobs[client.submit(rendered, data, scene.suffix, "frame.png", arguments, pure=False)] = target
    for job in as_completed(jobs):
        jobs[job].write_bytes(job.result())


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("scene", type=Path)
    parser.add_argument("-o", "--output", type=Path, required=True)
    parser.add_argument("--scheduler", help="the address of a running scheduler")
    what = parser.add_mutually_exclusive_group(required=True)
    what.add_argument("--shards", type=int)
    what.add_argument("--frames", type=int, nargs=2, metavar=("FIRST", "LAST"))
    own, options = sys.argv[1:], []
    if "--" in own:
        at = own.index("--")
        own, options = own[:at], own[at + 1 :]
    args = parser.parse_args(own)
    cluster = args.scheduler or LocalCluster(threads_per_worker=1, dashboard_address=None)
    with Client(cluster) as client:
        if args.shards:
            picture(client, args.scene, args.output, args.shards, options)
        else:
            first, last = args.frames
            film(client, args.scene, args.output, range(first, last + 1), options)


if __name__ == "__main__":
    main()
