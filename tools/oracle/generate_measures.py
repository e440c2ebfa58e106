#!/usr/bin/env python3
"""Ground truth for volume, second moments, surface area and closest points, in high precision.

Needs mpmath. Usage:

    generate_measures.py --measures measures.csv --closest closest.csv

measures.csv: e, n, semi-axes, volume, second moments, area. Volume and moments are integrals of
sections by quadrature over z, not the Gamma functions that the library uses. The area is that of
the surface as a graph: a superellipse is cut where X = Y, and each half is a function of the smaller
coordinate. The product of tanh-sinh rules is refined until 16 digits
agree, of which each level has twice as many.

closest.csv: e, n, semi-axes, point, distance, closest point. The smallest value on a fine grid of
the octant is the start of Newton's method with 40 digits for the stationary point; a row is
written only if that is no farther than the grid's best point.

The f64 numbers of a row are taken as exact.
"""

import argparse
import csv
import math
import random

from mpmath import mp, mpf

mp.dps = 40


def nodes(level):
    """The tanh-sinh rule on (0, 1): (x, 1 - x, weight), each to full relative precision."""
    step = mpf(1) / 2**level
    rule = []
    k = 0
    while True:
        t = k * step
        u = mp.pi / 2 * mp.sinh(t)
        small = 1 / (1 + mp.exp(2 * u))
        weight = step * mp.pi / 2 * mp.cosh(t) / (2 * mp.cosh(u) ** 2)
        if small < mpf(10) ** -600 or weight < mpf(10) ** -60:
            return rule
        rule.append((1 - small, small, weight))
        if k:
            rule.append((small, 1 - small, weight))
        k += 1


def half_arcs(exponent, level):
    """(X, Y, dX, dY, weight) over both halves of the arc X^p + Y^p = 1."""
    p = 2 / mpf(exponent)
    top = mpf(2) ** (-1 / p)
    points = []
    # Of a cusp the smaller coordinate is a power of the parameter, so that it is smooth there.
    power = max(mpf(1), 1 / p)
    for x, _, weight in nodes(level):
        small = top * x**power
        large = mp.exp(mp.log1p(-(small**p)) / p)
        speed = top * power * x ** (power - 1)
        slope = -((small / large) ** (p - 1)) * speed
        points.append((small, large, speed, slope, weight))
        points.append((large, small, slope, speed, weight))
    return points


def area_at(e, n, radii, level):
    a, b, c = map(mpf, radii)
    around = []
    for x, y, dx, dy, weight in half_arcs(e, level):
        around.append(((b * dy) ** 2 + (a * dx) ** 2, (a * b * (x * dy - y * dx)) ** 2, weight))
    total = mpf(0)
    for rho, zeta, drho, dzeta, weight in half_arcs(n, level):
        wall, cap = (c * dzeta) ** 2, drho**2
        total += weight * rho * mp.fsum(w * mp.sqrt(wall * s + cap * m) for s, m, w in around)
    return 8 * total


def area(e, n, radii):
    mp.dps = 30
    last = area_at(e, n, radii, 3)
    for level in range(4, 8):
        fine = area_at(e, n, radii, level)
        if abs(fine / last - 1) < mpf(10) ** -16:
            # The rule doubles its digits with each level.
            mp.dps = 40
            return fine, abs(fine / last - 1)
        last = fine
    raise ValueError(f"the area of {e} {n} {radii} does not converge")


def section(e, power):
    """The integral of |x|^power over |x|^p + |y|^p <= 1."""
    p = 2 / mpf(e)
    top = mpf(2) ** (-1 / p)
    # Cut where x = y: over x below top the height is a function of x, and so is the width over y.
    graph = lambda x: mp.exp(mp.log1p(-(x**p)) / p)
    low = mp.quad(lambda x: x**power * (graph(x) - top), [0, top])
    high = mp.quad(lambda y: (graph(y) ** (power + 1) - top ** (power + 1)) / (power + 1), [0, top])
    square = top ** (power + 2) / (power + 1)
    return 4 * (low + high + square)


def along_z(n, power, radial):
    """The integral over -1..1 of |z|^power rho^radial."""
    q = 2 / mpf(n)
    top = mpf(2) ** (-1 / q)
    graph = lambda z: mp.exp(mp.log1p(-(z**q)) / q)
    low = mp.quad(lambda z: z**power * graph(z) ** radial, [0, top])
    # The part from z = top on, as an integral over rho.
    high = mp.quad(
        lambda r: (graph(r) ** (power + 1) - top ** (power + 1)) / (power + 1) * radial * r ** (radial - 1), [0, top]
    )
    return 2 * (low + high)


def measures(e, n, radii):
    a, b, c = map(mpf, radii)
    volume = a * b * c * section(e, 0) * along_z(n, 0, 2)
    across = section(e, 2) * along_z(n, 0, 4)
    up = section(e, 0) * along_z(n, 2, 2)
    moments = [a**3 * b * c * across, a * b**3 * c * across, a * b * c**3 * up]
    value, off = area(e, n, radii)
    print(f"{e} {n} {radii}: area agrees to {mp.nstr(off, 2)}")
    return [volume, *moments, value]


def arc(w, t):
    """The point of an arc at t = 2 ln tan(angle)."""
    h = mpf(w) / 2
    return mp.exp(-h * mp.log1p(mp.exp(t))), mp.exp(-h * mp.log1p(mp.exp(-t)))


def float_arc(w, t):
    soft = lambda s: max(s, 0.0) + math.log1p(math.exp(-abs(s)))
    return math.exp(-0.5 * w * soft(t)), math.exp(-0.5 * w * soft(-t))


def closest(e, n, radii, point):
    count = 240
    spread = lambda w: [math.sinh(i / count * math.asinh(40 / min(1, w / 2))) for i in range(-count, count + 1)]
    arounds = [(t, *float_arc(e, t)) for t in spread(e)]
    profiles = [(t, *float_arc(n, t)) for t in spread(n)]
    (a, b, c), (u, v, w) = radii, point
    best = min(
        ((a * r * x - u) ** 2 + (b * r * y - v) ** 2 + (c * z - w) ** 2, t, s)
        for s, r, z in profiles
        for t, x, y in arounds
    )

    def where(t, s):
        (x, y), (r, z) = arc(e, t), arc(n, s)
        return [a * r * x, b * r * y, c * z]

    def squared(t, s):
        return mp.fsum((g - mpf(h)) ** 2 for g, h in zip(where(t, s), point))

    def gradient(t, s):
        (x, y), (r, z) = arc(e, t), arc(n, s)
        off = [g - mpf(h) for g, h in zip(where(t, s), point)]
        up, down = (lambda q: 1 / (1 + mp.exp(-q))), (lambda q: 1 / (1 + mp.exp(q)))
        by_t = [-a * r * x * up(t), b * r * y * down(t), 0]
        by_s = [-a * r * up(s) * x, -b * r * up(s) * y, c * z * down(s)]
        dot = lambda g, h: mp.fsum(i * j for i, j in zip(g, h))
        return dot(off, by_t), dot(off, by_s)

    try:
        t, s = mp.findroot(gradient, (mpf(best[1]), mpf(best[2])), tol=mpf(10) ** -50)
    except (ValueError, ZeroDivisionError):
        return None
    value = squared(t, s)
    if value > mpf(best[0]) * (1 + mpf(10) ** -12) or abs(t - best[1]) > 1 + abs(best[1]):
        return None
    return [mp.sqrt(value), *where(t, s)]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--measures")
    parser.add_argument("--closest")
    parser.add_argument("--rows", type=int, default=60, help="rows of closest points (default: 60)")
    arguments = parser.parse_args()
    if arguments.measures:
        with open(arguments.measures, "w", newline="") as file:
            rows = csv.writer(file, lineterminator="\n")
            rows.writerow("e n a b c volume xx yy zz area".split())
            cases = [
                (1.0, 1.0, (1.0, 1.0, 1.0)),
                (1.0, 1.0, (1.0, 2.0, 3.0)),
                (2.0, 2.0, (1.0, 2.0, 3.0)),
                (0.5, 0.5, (1.0, 1.0, 1.0)),
                (0.1, 0.1, (1.0, 2.0, 3.0)),
                (0.0001, 0.0001, (1.0, 1.0, 1.0)),
                (1.0, 0.0001, (1.0, 1.0, 2.0)),
                (0.3, 1.7, (2.0, 1.0, 0.5)),
                (2.5, 2.5, (1.0, 1.0, 1.0)),
                (3.0, 0.7, (1.0, 1.5, 2.0)),
                (0.1, 8.0, (1.0, 1.0, 1.0)),
                (8.0, 8.0, (1.0, 2.0, 3.0)),
                (1.0, 1.0, (1.0, 0.001, 1000.0)),
                (0.7, 3.0, (1.0, 0.000001, 1.0)),
            ]
            for e, n, radii in cases:
                values = measures(e, n, radii)
                rows.writerow([e, n, *radii, *(mp.nstr(value, 22) for value in values)])
                file.flush()
    if arguments.closest:
        random.seed(1)
        with open(arguments.closest, "w", newline="") as file:
            rows = csv.writer(file, lineterminator="\n")
            rows.writerow("e n a b c x y z distance px py pz".split())
            written = 0
            while written < arguments.rows:
                e, n = (random.choice([0.0001, 0.1, 0.3, 0.7, 1.0, 1.5, 2.0, 2.5, 4.0, 8.0]) for _ in range(2))
                radii = random.choice([(1.0, 1.0, 1.0), (1.0, 2.0, 3.0), (1.0, 0.01, 1.0), (1.0, 1.0, 50.0)])
                point = [round(random.uniform(0.01, 1.6) * r, 3) for r in radii]
                found = closest(e, n, radii, point)
                if found:
                    rows.writerow([e, n, *radii, *point, *(mp.nstr(value, 25) for value in found)])
                    file.flush()
                    written += 1


if __name__ == "__main__":
    main()
