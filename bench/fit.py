#!/usr/bin/env python3
"""Fits of known shapes by Superegg, by EMS and by sage-superquadric, on the same clouds in one run.

    bench/fit.py --ems FOLDER [--trials N] [--points N] [--seed S] [--view all|half] [--only-superegg]

FOLDER is the folder Python/src of a checkout of bmlklwx/EMS-superquadric_fitting (measured with commit
5a213d4). The interpreter needs superegg, numpy, scipy, numba and sage-superquadric; bench/fit.sh installs
them into a folder that it removes. Prints a table in Markdown.

Each trial draws exponents even from 0.1 to 2 and semi-axes from 1 to 3 (even in the logarithm), a rotation
and a centre; points even by area with normal noise on each coordinate; outliers even in a box 1.2 times as
wide as the shape's diagonal. A half view has only points whose normals face one random direction. The size
is the geometric mean of the semi-axes. A fit is good if the mean distance between both surfaces, sampled
evenly and measured exactly both ways, is below 1 % of the size. Times are processor seconds of one thread.
"""

from __future__ import annotations

import argparse
import os
import sys
import time
import types

for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "NUMBA_NUM_THREADS", "RAYON_NUM_THREADS"):
    os.environ[name] = "1"

import numpy as np  # noqa: E402
from scipy.spatial.transform import Rotation  # noqa: E402

import superegg as se  # noqa: E402

ROWS = [
    # noise, outliers, half view
    (0.0, 0.0, False),
    (0.01, 0.0, False),
    (0.01, 0.2, False),
    (0.02, 0.2, False),
    (0.05, 0.2, False),
    (0.01, 0.4, False),
    (0.01, 0.6, False),
    (0.05, 0.6, False),
    (0.0, 0.0, True),
    (0.01, 0.0, True),
    (0.01, 0.2, True),
    (0.02, 0.4, True),
]


def draw(rng, count, noise, outliers, half):
    shape = se.Superquadric(3 ** rng.uniform(size=3), rng.uniform(0.1, 2, 2))
    size = np.prod(shape.radii) ** (1 / 3)
    rotation = Rotation.random(random_state=rng).as_matrix()
    center = 3 * rng.normal(size=3)
    inliers = round(count * (1 - outliers))
    own, normals = shape.sample_surface(4 * count, int(rng.integers(2**31)))
    if half:
        own = own[normals @ rng.normal(size=3) > 0]
    points = own[:inliers] @ rotation.T + center
    points += noise * size * rng.normal(size=points.shape)
    reach = 1.2 * np.linalg.norm(shape.radii)
    stray = center + rng.uniform(-reach, reach, (count - inliers, 3))
    points = rng.permutation(np.vstack([points, stray]))
    return (shape, rotation, center), size, points


def distance(first, second):
    """The distances from one surface to another."""
    (shape, rotation, center), (other, turn, middle) = first, second
    points = shape.sample_surface(300, 5)[0] @ rotation.T + center
    return np.abs(other.signed_distance((points - middle) @ turn, tolerance=1e-4, threads=1))


def with_superegg(points, outliers):
    found = se.fit(points)
    return found.shape, found.rotation, found.center


def ems(folder):
    # What the code imports for its pictures only, and a name that numpy no longer has.
    for name in ("mayavi", "mayavi.mlab", "plyfile"):
        sys.modules[name] = types.ModuleType(name)
    sys.modules["mayavi"].mlab = sys.modules["mayavi.mlab"]
    np.int = int
    sys.path.insert(0, folder)
    from EMS.EMS_recovery import EMS_recovery

    def fit(points, outliers):
        found, _ = EMS_recovery(points, OutlierRatio=outliers)
        return se.Superquadric(found.scale, found.shape, convention="ems"), found.RotM, found.translation

    return fit


def with_sage(points, outliers):
    from sage_superquadrics.superquadric import fit_superquadric

    found, _ = fit_superquadric(points)
    shape = se.Superquadric([found[k] for k in ("a1", "a2", "a3")], [found[k] for k in ("eps1", "eps2")], convention="sage")
    turn = Rotation.from_euler("zyx", [found[k] for k in ("yaw", "pitch", "roll")]).as_matrix()
    return shape, turn, np.array([found[k] for k in ("cx", "cy", "cz")])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--ems", metavar="FOLDER", help="the folder that holds EMS/EMS_recovery.py; without it EMS is left out")
    parser.add_argument("--trials", type=int, default=100)
    parser.add_argument("--points", type=int, default=2000)
    parser.add_argument("--seed", type=int, default=2026)
    parser.add_argument("--view", choices=["all", "half"], help="only the rows of this view")
    parser.add_argument("--only-superegg", action="store_true")
    args = parser.parse_args()
    methods = {"superegg": with_superegg}
    if args.ems:
        methods["EMS"] = ems(args.ems)
    if not args.only_superegg:
        methods["sage"] = with_sage
    np.seterr(all="ignore")
    for fit in methods.values():
        # Compilers and caches are warm before the clock starts.
        fit(draw(np.random.default_rng(1), 300, 0.01, 0.1, False)[2], 0.1)
    heads = [f"{name}: good % | median error % | ms" for name in methods]
    print(f"| noise % | outliers % | view | {' | '.join(heads)} |")
    print("|" + "---|" * (3 + 3 * len(methods)))
    for noise, outliers, half in ROWS:
        view = "half" if half else "all"
        if args.view not in (None, view):
            continue
        rng = np.random.default_rng(args.seed)
        errors = {name: [] for name in methods}
        seconds = dict.fromkeys(methods, 0.0)
        for _ in range(args.trials):
            truth, size, points = draw(rng, args.points, noise, outliers, half)
            for name, fit in methods.items():
                start = time.process_time()
                try:
                    found = fit(points.copy(), outliers)
                except Exception:  # noqa: BLE001
                    found = None
                seconds[name] += time.process_time() - start
                try:
                    error = 0.5 * (distance(truth, found).mean() + distance(found, truth).mean()) / size
                except (TypeError, ValueError):
                    error = np.inf
                errors[name].append(error if np.isfinite(error) else np.inf)
        cells = []
        for name in methods:
            good = np.mean(np.array(errors[name]) < 0.01)
            median = np.median(errors[name])
            cells.append(f"{100 * good:.1f} | {100 * median:.3f} | {1e3 * seconds[name] / args.trials:.1f}")
        print(f"| {100 * noise:g} | {100 * outliers:g} | {view} | {' | '.join(cells)} |", flush=True)


if __name__ == "__main__":
    main()
