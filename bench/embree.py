#!/usr/bin/env python3
"""Rays a second of Superegg on superquadrics and of Embree 3 on triangles as fine as a twentieth of a pixel, and on as many spheres.

    bench/embree.py [--turns N] [SCENE ...]      # cloud:1000 and cloud:10000 unless given; the eye at one place

Needs Embree 3 and a compiler (apt-get install libembree-dev g++). The two programs take turns on one core, and the best of each counts: camera
rays at 1280 x 960 (Embree: packets of sixteen), and random rays from anywhere to anywhere (Embree: one by one or by sixteens, whichever is
quicker), both found in f32. Of Embree only the rays are measured, which have the tree of its slowest build.
"""

import argparse
import json
import pathlib
import shutil
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
OUT = ROOT / "target" / "embree"
ROUNDS = 3


def run(*command):
    return subprocess.run([str(word) for word in command], cwd=ROOT, check=True, stdout=subprocess.PIPE, text=True).stdout


def build():
    if shutil.which("g++") is None or not pathlib.Path("/usr/include/embree3/rtcore.h").exists():
        sys.exit("Embree 3 or g++ is not on this machine: apt-get install libembree-dev g++")
    OUT.mkdir(parents=True, exist_ok=True)
    run("cargo", "build", "--release", "--quiet", "--bin", "superegg")
    run("cargo", "build", "--release", "--quiet", "-p", "superegg-render", "--example", "triangles")
    run("g++", "-O3", "-march=native", "-o", OUT / "embree", ROOT / "bench" / "embree.cpp", "-lembree3")


def measure(scene, turns):
    """The best rates, in millions a second, and shares of hits: by (program, rays)."""
    file = run("target/release/superegg", "bench", scene, "--save", OUT).strip()
    mesh = pathlib.Path(file).with_suffix(".bin")
    triangles = run("target/release/examples/triangles", file, mesh).strip()
    best = {}

    def take(program, rays, rate, hits):
        rate_before, _ = best.get((program, rays), (0.0, 0.0))
        best[program, rays] = max(rate, rate_before), hits

    for _ in range(turns):
        (row,) = json.loads(run("target/release/superegg", "bench", scene, "--rounds", ROUNDS, "--json", "-"))
        for rays in ("camera", "random"):
            take("superegg", rays, row[f"{rays}_mrays"], row[f"{rays}_hits"])
        for line in run(OUT / "embree", mesh, ROUNDS).splitlines():
            program, rays, rate, hits = line.split()
            take(program, rays, float(rate), float(hits))
    mesh.unlink()
    return triangles, best


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--turns", type=int, default=3)
    parser.add_argument("scenes", nargs="*", default=["cloud:1000", "cloud:10000"])
    arguments = parser.parse_args()
    build()
    print("| scene | rays | superegg | triangles | ratio | spheres | ratio | hits: superegg, triangles, spheres | triangles in all |")
    print("|---|---|---|---|---|---|---|---|---|")
    for scene in arguments.scenes:
        triangles, best = measure(scene, arguments.turns)
        for rays in ("camera", "random"):
            ours, triangle, sphere = (best[program, rays] for program in ("superegg", "triangles", "spheres"))
            hits = ", ".join(f"{share:.3f}" for _, share in (ours, triangle, sphere))
            rates = f"{ours[0]:.2f} | {triangle[0]:.2f} | {ours[0] / triangle[0]:.2f} | {sphere[0]:.2f} | {ours[0] / sphere[0]:.2f}"
            print(f"| {scene} | {rays} | {rates} | {hits} | {triangles} |", flush=True)
    print("million rays a second on one core")


if __name__ == "__main__":
    main()
