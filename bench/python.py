#!/usr/bin/env python3
"""A million random rays on cloud:1000 from Python: against `superegg bench`, and against trimesh with embreex where they are installed.

All in turns; the figures are processor seconds, the best of the turns, and against trimesh those by the clock too. The mesh has the same
shapes within 1e-3 of each largest semi-axis. Needs the package superegg; trimesh takes Embree where embreex is.
"""

import json
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

import superegg as se

RAYS, TURNS, TOLERANCE = 1_000_000, 3, 1e-3
PROGRAM = [sys.executable, "-m", "superegg"]


def seconds(work):
    start = time.process_time()
    result = work()
    return time.process_time() - start, result


def random_rays(bounds):
    rng = np.random.default_rng(1)
    directions = rng.normal(size=(RAYS, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    return rng.uniform(*bounds, (RAYS, 3)), directions


def cloud(n=1000):
    """The same number of shapes at the same density as cloud:1000."""
    rng = np.random.default_rng(2)
    side = n ** (1 / 3)
    radii = rng.uniform(0.1, 0.4, (n, 3))
    return rng.uniform(0, side, (n, 3)), radii, rng.uniform(0.2, 2.0, (n, 2)), rng.normal(size=(n, 4))


def mesh_of(columns):
    import trimesh
    from superegg._rotation import matrices

    vertices, faces, count = [], [], 0
    for position, radii, exponents, rotation in zip(*columns, strict=True):
        mesh = se.Superquadric(radii, exponents).mesh(TOLERANCE)
        vertices.append(mesh.vertices @ matrices(rotation).T + position)
        faces.append(mesh.faces.astype(np.int64) + count)
        count += len(mesh.vertices)
    return trimesh.Trimesh(np.concatenate(vertices), np.concatenate(faces), process=False)


def main():
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run([*PROGRAM, "bench", "cloud:1000", "--save", folder], check=True, capture_output=True)
        scene = se.load(next(Path(folder).glob("*.scn")))
    origins, directions = random_rays(scene.bounds)
    scene.intersect(origins[:1000], directions[:1000], threads=1)
    rust, python, occluded = [], [], []
    for _ in range(TURNS):
        run = [*PROGRAM, "bench", "cloud:1000", "--rounds", "2", "--size", "320x240", "--json", "-"]
        row = json.loads(subprocess.run(run, check=True, capture_output=True, text=True).stdout)
        row = row[0] if isinstance(row, list) else row.get("scenes", [row])[0]
        rust.append(row["random_settled_mrays"])
        python.append(RAYS / 1e6 / seconds(lambda: scene.intersect(origins, directions, threads=1))[0])
        occluded.append(RAYS / 1e6 / seconds(lambda: scene.occluded(origins, directions, threads=1))[0])
    print(f"cloud:1000, million random rays a second of one core: bench {max(rust):.2f}, ", end="")
    print(f"Python hits {max(python):.2f}, ratio {max(rust) / max(python):.2f}; occluded {max(occluded):.2f}")
    try:
        import embreex  # noqa: F401
        import trimesh  # noqa: F401
    except ImportError:
        print("trimesh and embreex are not installed: left out")
        return
    against_trimesh()


def against_trimesh():
    """1,000 shapes against a mesh of them: by processor time on one thread, and by the clock with the threads of each call's default."""
    columns = cloud()
    exact = se.Scene()
    exact.add_many(*columns)
    mesh = mesh_of(columns)
    origins, directions = random_rays(exact.bounds)

    def with_normals():
        places, rays, triangles = mesh.ray.intersects_location(origins, directions, multiple_hits=False)
        return places, rays, mesh.face_normals[triangles]

    calls = {
        "exact, one thread": lambda: exact.intersect(origins, directions, threads=1),
        "exact, all threads": lambda: exact.intersect(origins, directions),
        "intersects_first": lambda: mesh.ray.intersects_first(origins, directions),
        "intersects_location": lambda: mesh.ray.intersects_location(origins, directions, multiple_hits=False),
        "intersects_location and normals": with_normals,
    }
    # The first call of each builds trees and caches.
    results = {name: call() for name, call in calls.items()}
    processor, clock = ({name: [] for name in calls} for _ in range(2))
    for _ in range(TURNS):
        for name, call in calls.items():
            start = time.perf_counter()
            processor[name].append(seconds(call)[0])
            clock[name].append(time.perf_counter() - start)
    found, first = results["exact, one thread"], results["intersects_first"]
    print(f"1,000 shapes, {len(mesh.faces)} triangles; {100 * np.mean(found.hit == (first >= 0)):.2f} % of the rays agree")
    print("| call | processor s | ratio to exact, one thread | clock s | ratio to exact, all threads |\n|---|---|---|---|---|")
    for name in calls:
        spent, waited = min(processor[name]), min(clock[name])
        ratios = spent / min(processor["exact, one thread"]), waited / min(clock["exact, all threads"])
        print(f"| {name} | {spent:.3f} | {ratios[0]:.2f} | {waited:.3f} | {ratios[1]:.2f} |")
    print_mesh_error(found, *results["intersects_location and normals"])


def print_mesh_error(found, places, rays, normals):
    """How far the mesh's answers are from the exact ones, where both programs hit."""
    both = found.hit[rays]
    places, rays, normals = places[both], rays[both], normals[both]
    along = np.linalg.norm(places - found.position[rays], axis=1)
    turned = np.degrees(np.arccos(np.clip(np.einsum("ij,ij->i", normals, found.normal[rays]), -1, 1)))
    for name, values, unit in ("positions", along, ""), ("normals", turned, " degrees"):
        part = np.quantile(values, (0.5, 0.99))
        print(f"error of the mesh's {name}: median {part[0]:.2g}, 99 % {part[1]:.2g}, greatest {values.max():.2g}{unit}")


if __name__ == "__main__":
    main()
