#!/usr/bin/env python3
"""Ground truth for a ray against the unit superquadric, in high precision.

The surface is N = 1 with

    R(x, y) = (|x|^p + |y|^p)^(1/p)      p = 2/e
    N       = (R^q + |z|^q)^(1/q)        q = 2/n

and N < 1 is the inside.  The f64 numbers e, n, o and d of a row are taken as
exact; everything derived from them is computed with about ninety digits.

Two methods that share nothing but the definition of R are run for every ray,
and a row is written only if they agree:

* `Ray.first_crossing` works on h(t) = R - (1 - |z|^q)^(1/q), which has the
  sign of N - 1 inside of the box [-1, 1]^3 (outside of the box N > 1).  The
  ray is cut where a coordinate is zero.  Along a piece |x|, |y| and |z| are
  linear, so R is convex (p >= 1) or concave (p <= 1), and so is the second
  term.  Bisection with tangents on one kind of term and chords on the other
  bounds h from below and above, so nothing depends on how densely the ray is
  sampled.

* `Ray.breakpoints` finds every local extremum of N along the ray from the
  sign of dN/dt.  Between two neighbours N is monotone: the crossings are the
  changes of sign.  The margin column comes from here too.

Usage:

    generate_rays.py --rays 4000 --seed 1 --out rays.csv
    generate_rays.py --seconds 1800 --seed 2 --out big.csv --tags big_tags.csv
    generate_rays.py --check rays.csv         compare a file with this program

Columns: e, n, origin, direction, start_inside, hit, t, normal, margin.
`margin` is the smallest N - 1 along the ray for a miss; for a hit it is the
smallest |N - 1| over the origin and all local extrema of N along the ray, at
most 1.  It is rounded down to three digits, and written as 0 below 1e-12: such a
ray touches the surface for all practical purposes, and either answer will do.
"""

import argparse
import collections
import csv
import math
import random
import signal
import sys
import time

from mpmath import mp, mpf

COLUMNS = "e,n,ox,oy,oz,dx,dy,dz,start_inside,hit,t,nx,ny,nz,margin".split(",")

SPECIAL = [0.0001, 0.001, 0.01, 0.1, 0.5, 1.0, 1.5, 1.99, 2.0, 2.01, 2.5, 3.0, 4.0, 6.0, 8.0]

BASE_PRECISION = 288  # bits
ZERO_BITS = 200  # |N - 1| below 2^-ZERO_BITS counts as lying on the surface
WIDTH_BITS = 160  # isolation stops at intervals narrower than this
TOUCH = 1e-12  # a margin below this is written as 0, and the two methods may differ
CROWD = 256  # undecided intervals at which the search for extrema stops to refine
PATIENCE = 50_000  # intervals after which the isolation gives a ray up
PER_RAY = 30  # seconds after which a ray is left out


class Disagreement(Exception):
    """The two methods differ for a ray that is not a touch, or one did not end."""


class OnSurface(Exception):
    """The origin of the ray lies on the surface: in or out is undefined."""


def sign(x):
    """Return -1, 0 or 1."""
    return (x > 0) - (x < 0)


def refine(f, a, fa, b, fb, tolerance):
    """Shrink a bracket (f(a) and f(b) of opposite sign) by Chandrupatla's method.

    Infinite values are allowed at the ends.  `tolerance` maps an abscissa to
    the width at which to stop.  Returns the final bracket as (low, high).
    """
    x1, f1, x2, f2 = b, fb, a, fa
    x3, f3 = x1, f1
    share = mpf(0.5)
    while True:
        x = x1 + share * (x2 - x1)
        if x == x1 or x == x2:
            break
        fx = f(x)
        if sign(fx) == sign(f1):
            x3, f3 = x1, f1
        else:
            x3, f3 = x2, f2
            x2, f2 = x1, f1
        x1, f1 = x, fx
        if fx == 0:
            return x, x
        width = abs(x2 - x1)
        best = x1 if abs(f1) < abs(f2) else x2
        small = tolerance(best)
        if width <= small:
            break
        share = mpf(0.5)
        if mp.isfinite(f1) and mp.isfinite(f2) and mp.isfinite(f3) and f3 != f2:
            xi = (x1 - x2) / (x3 - x2)
            phi = (f1 - f2) / (f3 - f2)
            if phi * phi < xi and (1 - phi) ** 2 < 1 - xi:
                share = f1 / (f2 - f1) * f3 / (f2 - f3)
                share += (x3 - x1) / (x2 - x1) * f1 / (f3 - f1) * f2 / (f3 - f2)
        floor = small / width / 2
        share = min(max(share, floor), 1 - floor)
    return min(x1, x2), max(x1, x2)


class Point:
    """A parameter t with the coordinates, h and (when asked for) the slopes there."""

    __slots__ = ("t", "u", "v", "w", "R", "C", "h", "_slopes")

    def __init__(self, ray, t):
        self.t = t
        self.u, self.v, self.w = ray.coordinates(t)
        self.R = ray.radius(self.u, self.v)
        self.C = ray.profile(self.w)
        self.h = self.R - self.C
        self._slopes = None

    def slopes(self, ray, slope):
        """Return (dR/dt, d(-C)/dt); None stands for an infinite slope."""
        if self._slopes is None:
            self._slopes = (ray.radius_slope(self, slope), ray.profile_slope(self, slope))
        return self._slopes


class Ray:
    """One ray o + t d, t >= 0, against one unit superquadric."""

    def __init__(self, e, n, o, d, extra_bits=0):
        mp.prec = 53
        stiff = max(2 / e, 2 / n, e / 2, n / 2)
        mp.prec = BASE_PRECISION + 2 * int(math.log2(stiff) + 1) + extra_bits
        self.p = 2 / mpf(e)
        self.q = 2 / mpf(n)
        self.o = [mpf(c) for c in o]
        self.d = [mpf(c) for c in d]
        if not any(self.d):
            raise ValueError("direction is zero")
        self.cut = [-a / b if b else None for a, b in zip(self.o, self.d)]
        self.snap = mpf(2) ** (60 - mp.prec)
        self.zero = mpf(2) ** -ZERO_BITS

    # -- the surface ------------------------------------------------------

    def coordinates(self, t):
        """Return |x|, |y|, |z| at t, exactly 0 at a cut and exactly 1 on the box."""
        out = []
        for o, d, cut in zip(self.o, self.d, self.cut):
            value = abs(o) if cut is None else abs(d * (t - cut))
            if abs(value - 1) < self.snap:
                value = mpf(1)
            out.append(value)
        return out

    def radius(self, u, v):
        """R(u, v) for u, v >= 0."""
        if not u or not v:
            return u + v
        return (u**self.p + v**self.p) ** (1 / self.p)

    def profile(self, w):
        """C(w) = (1 - w^q)^(1/q): the radius of the shape at height w, 0 beyond the top."""
        if w >= 1:
            return mpf(0)
        if not w:
            return mpf(1)
        return (1 - w**self.q) ** (1 / self.q)

    def size(self, t):
        """N at t."""
        u, v, w = self.coordinates(t)
        r = self.radius(u, v)
        if not r or not w:
            return r + w
        return (r**self.q + w**self.q) ** (1 / self.q)

    def normal(self, t):
        """Unit gradient of N at t.  A coordinate that is exactly zero contributes nothing."""
        u, v, w = self.coordinates(t)
        logs = [None, None, None]
        r = self.radius(u, v)
        for i, c in enumerate((u, v)):
            if c:
                logs[i] = (self.p - 1) * mp.log(c) + (self.q - self.p) * mp.log(r)
        if w:
            logs[2] = (self.q - 1) * mp.log(w)
        top = max(x for x in logs if x is not None)
        parts = []
        for x, o, d, cut in zip(logs, self.o, self.d, self.cut):
            side = sign(o) if cut is None else sign(d * (t - cut))
            parts.append(side * mp.exp(x - top) if x is not None else mpf(0))
        length = mp.sqrt(sum(c * c for c in parts))
        return [c / length for c in parts]

    # -- pieces -----------------------------------------------------------

    def clip(self, half):
        """Interval of t >= 0 with the ray strictly in the open box of this half-side, or None."""
        low, high = mpf(0), None
        for o, d, cut in zip(self.o, self.d, self.cut):
            if cut is None:
                if abs(o) >= half:
                    return None
                continue
            reach = half / abs(d)
            low = max(low, cut - reach)
            high = cut + reach if high is None else min(high, cut + reach)
        return (low, high) if low < high else None

    def pieces(self, low, high):
        """Cut [low, high] at the coordinate planes; yield (a, b, slopes of |x|, |y|, |z|)."""
        inner = {c for c in self.cut if c is not None and low < c < high}
        stops = [low] + sorted(inner) + [high]
        for a, b in zip(stops, stops[1:]):
            slope = []
            for d, cut in zip(self.d, self.cut):
                if cut is None:
                    slope.append(mpf(0))
                else:
                    slope.append(abs(d) if cut <= a else -abs(d))
            yield a, b, slope

    # -- method A: isolation with convex and concave bounds ---------------

    def radius_slope(self, at, slope):
        """dR/dt at a point, None if it is infinite."""
        su, sv, _ = slope
        p = self.p
        if not su and not sv:
            return mpf(0)
        if p == 1:
            return su + sv
        if not at.R:
            # Both vanish here: R is linear along the piece, and nothing cancels.
            return (sign(su) or sign(sv)) * self.radius(abs(su), abs(sv))
        total = mpf(0)
        for c, s in ((at.u, su), (at.v, sv)):
            if c and s:
                total += s * c ** (p - 1)
            elif s and p < 1:
                return None
        return total * at.R ** (1 - p)

    def profile_slope(self, at, slope):
        """d(-C)/dt at a point, None if it is infinite."""
        sw, q, w = slope[2], self.q, at.w
        if not sw:
            return mpf(0)
        if q == 1:
            return sw
        if w >= 1:
            return None if q > 1 else mpf(0)
        if not w:
            return mpf(0) if q > 1 else None
        return sw * w ** (q - 1) * at.C ** (1 - q)

    def first_crossing(self, start):
        """Isolate the first change of side; `start` is the sign of N - 1 at the origin.

        Returns the bracket (a, b), or None for a miss.
        """
        span = self.clip(mpf(1))
        if span is None:
            return None
        low, high = span
        state = start if low == 0 else 1
        for a, b, slope in self.pieces(low, high):
            found, state = self._piece(Point(self, a), Point(self, b), slope, state, b == high)
            if found:
                return found
        return None

    def _sign(self, point):
        return 0 if abs(point.h) < self.zero else sign(point.h)

    def _piece(self, a, b, slope, state, last):
        """First crossing on one piece; returns (bracket or None, state at its end)."""
        su, sv, sw = slope
        u_moves = bool(su) or bool(a.u)
        v_moves = bool(sv) or bool(a.v)
        r_linear = self.p == 1 or not (u_moves and v_moves) or not (su or sv)
        c_linear = self.q == 1 or not sw
        # For every term of h: is it convex, is it concave along the piece?
        kinds = (
            (r_linear or self.p >= 1, r_linear or self.p <= 1),
            (c_linear or self.q >= 1, c_linear or self.q <= 1),
        )
        convex = kinds[0][0] and kinds[1][0]
        concave = kinds[0][1] and kinds[1][1]
        narrow = mpf(2) ** -WIDTH_BITS * (1 + abs(b.t))
        stack = [(a, b, last)]
        steps = 0
        while stack:
            steps += 1
            if steps > PATIENCE:
                raise Disagreement("isolation does not end")
            a, b, ends = stack.pop()
            side = self._sign(b)
            if side == 0 and ends:
                side = 1  # beyond the box is outside
            width = b.t - a.t
            if side == -state:
                if convex or concave or width < narrow or self._monotone(a, b, slope, kinds, side):
                    return self._bracket(a, b, state), -state
            elif width < narrow:
                continue
            elif side == state and self._sign(a) == state and (
                (concave and state > 0) or (convex and state < 0)
            ):
                continue
            m = Point(self, (a.t + b.t) / 2)
            if side != -state and self._one_sided(a, m, b, slope, kinds, state):
                continue
            stack.append((m, b, ends))
            stack.append((a, m, False))
        return None, state

    def _one_sided(self, a, m, b, slope, kinds, state):
        """True if linear bounds prove that h does not leave the side `state` on [a, b].

        Going beyond the surface by less than `zero` does not count: without this, a piece
        that stays within rounding of the surface could never be decided.
        """
        ends = [mpf(0), mpf(0)]
        at_a, at_m, at_b = (a.R, -a.C), (m.R, -m.C), (b.R, -b.C)
        rise = m.slopes(self, slope)
        for k in (0, 1):
            by_tangent = kinds[k][0] if state > 0 else kinds[k][1]
            if by_tangent:
                if rise[k] is None:
                    return False
                ends[0] += at_m[k] + rise[k] * (a.t - m.t)
                ends[1] += at_m[k] + rise[k] * (b.t - m.t)
            else:
                ends[0] += at_a[k]
                ends[1] += at_b[k]
        return min(state * ends[0], state * ends[1]) > -self.zero

    def _monotone(self, a, b, slope, kinds, side):
        """True if h is proved to go in direction `side` on all of [a, b]."""
        worst = mpf(0)
        for k in (0, 1):
            # The extreme slope against the direction sits at one end of the interval.
            rising = kinds[k][0]
            at = a if rising == (side > 0) else b
            value = at.slopes(self, slope)[k]
            if value is None:
                return False
            worst += value
        return sign(worst) == side

    def _bracket(self, a, b, state):
        """Narrow a bracket with exactly one crossing."""
        if self._sign(a) == state and self._sign(b) == -state:
            return refine(lambda t: Point(self, t).h, a.t, a.h, b.t, b.h, self.resolution)
        low, high = a.t, b.t
        while high - low > self.resolution(high):
            mid = (low + high) / 2
            if not low < mid < high:
                break
            if self._sign(Point(self, mid)) == -state:
                high = mid
            else:
                low = mid
        return low, high

    def resolution(self, t):
        """Width at which a root is known well enough for t and for the normal there."""
        fine = mpf(2) ** (40 - mp.prec) * (1 + abs(t))
        near = min([c for c in self.coordinates(t) if c] + [mpf(1)])
        return max(fine, near * mpf(2) ** -80)

    # -- method B: all extrema of N ---------------------------------------

    def breakpoints(self):
        """Sorted t >= 0 such that N is monotone between neighbours, with N there.

        Covers the part of the ray where N can be at its minimum or at most 2.
        """
        along = sum(a * b for a, b in zip(self.o, self.d))
        nearest = max(mpf(0), -along / sum(c * c for c in self.d))
        half = 2 * max(mpf(1), self.size(nearest), self.size(mpf(0)) if nearest == 0 else 1)
        low, high = self.clip(half)
        stops = {mpf(0), low, high}
        for a, b, slope in self.pieces(low, high):
            stops.update((a, b))
            stops.update(self._extrema(a, b, slope))
        return [(t, self.size(t)) for t in sorted(stops)]

    def _extrema(self, a, b, slope):
        """Candidates for the extrema of N strictly inside of a piece."""
        su, sv, sw = slope
        p, q = self.p, self.q
        flat = set()
        ua, va, wa = self.coordinates(a)
        u_there, v_there = bool(su) or bool(ua), bool(sv) or bool(va)
        stops = [a, b]
        if su * sv < 0 and p != 1:
            # dR/dt = 0 where (u/v)^(p-1) = -sv/su: one linear equation.
            ratio = (-sv / su) ** (1 / (p - 1))
            if ratio <= 1:
                t = a + (ratio * va - ua) / (su - ratio * sv)
            else:
                t = a + (va - ua / ratio) / (su / ratio - sv)
            near = mpf(2) ** (30 - mp.prec) * (1 + abs(b))
            if a - near < t < b + near:
                # A root too close to an end to be told from it counts as lying there.
                t = a if t < a + near else b if t > b - near else t
                flat.add(t)
                stops = sorted({a, t, b})
        level = frozenset(flat)
        if not sw or not (u_there or v_there):
            return flat
        linear = p == 1 or not (u_there and v_there) or not (su or sv)
        for low, high in zip(stops, stops[1:]):
            rise = self._radius_slope_sign((low + high) / 2, slope)
            if rise == 0 or rise == sign(sw):
                continue
            same = linear or q == 1 or (p >= 1) == (q >= 1)
            flat.update(self._balance(low, high, slope, same, level))
        return flat

    def cusps(self):
        """Cuts t > 0 where N has a local minimum because its slope is infinite on both sides.

        The maximum beside such a minimum can be too close to it to be resolved.
        """
        found = set()
        for axis, cut in enumerate(self.cut):
            if cut is None or cut <= 0:
                continue
            u, v, w = self.coordinates(cut)
            if axis == 2:
                sharp = self.q < 1 and (u or v)
            else:
                sharp = (self.p < 1 and (u or v)) or (self.q < 1 and w and not (u or v))
            if sharp:
                found.add(cut)
        return found

    def _radius_slope_sign(self, t, slope):
        u, v, _ = self.coordinates(t)
        total = mpf(0)
        for c, s in ((u, slope[0]), (v, slope[1])):
            if s:
                total += s * c ** (self.p - 1)
        return sign(total)

    def _balance_terms(self, t, slope):
        """The two monotone terms of log(-(dR/dt) R^(q-1) / (dw/dt w^(q-1))).

        Returns log|dR/dt| - log|dw/dt| and (q-1) log(R/w).
        """
        p, q = self.p, self.q
        u, v, w = self.coordinates(t)
        su, sv, sw = slope
        inf = mp.inf
        if (not u and not su) or (not v and not sv):
            r = u + v
            log_r = mp.log(r) if r else -inf
            first = mp.log(abs(su) + abs(sv))
        else:
            total = power = mpf(0)
            infinite = False
            for c, s in ((u, su), (v, sv)):
                if c:
                    part = c ** (p - 1)
                    power += c * part
                    total += s * part
                elif p == 1:
                    total += s
                elif p < 1 and s:
                    infinite = True
            if not power:
                # Both vanish here: R is linear through this point.
                log_r = -inf
                first = mp.log(self.radius(abs(su), abs(sv)))
            else:
                log_r = mp.log(power) / p
                if infinite:
                    first = inf
                else:
                    first = mp.log(abs(total)) + (1 - p) * log_r if total else -inf
        first -= mp.log(abs(sw))
        if q == 1:
            return first, mpf(0)
        if w and mp.isfinite(log_r):
            return first, (q - 1) * (log_r - mp.log(w))
        if not w and log_r == -inf:
            # The ray runs through the origin: R/w is constant along it.
            return first, (q - 1) * mp.log(self.radius(abs(su), abs(sv)) / abs(sw))
        return first, (inf if (not w) == (q > 1) else -inf)

    def _balance(self, low, high, slope, same, level):
        """Points of [low, high] near every root of dN/dt, within 2^-50 of the width or better.

        `level` holds the ends where dR/dt vanishes.
        """
        fine = max((high - low) * mpf(2) ** -50, mpf(2) ** (20 - mp.prec) * (1 + abs(high)))
        one, two = (
            (-mp.inf if t in level else first, second)
            for t in (low, high)
            for first, second in [self._balance_terms(t, slope)]
        )
        if same:
            # Both terms go the same way: at most one root.
            fl, fh = sum(one), sum(two)
            if mp.isnan(fl) or mp.isnan(fh):
                raise ArithmeticError("terms cancel at the end of a piece")
            if sign(fl) * sign(fh) >= 0:
                return []
            finer = fine * mpf(2) ** -60
            return refine(
                lambda t: sum(self._balance_terms(t, slope)), low, fl, high, fh, lambda t: finer
            )
        pending = [(low, one, high, two)]
        while pending:
            if pending[0][2] - pending[0][0] <= fine or len(pending) > CROWD:
                break
            halves = []
            for a, fa, b, fb in pending:
                m = (a + b) / 2
                fm = self._balance_terms(m, slope)
                halves += [(a, fa, m, fm), (m, fm, b, fb)]
            pending = []
            for a, fa, b, fb in halves:
                least = min(fa[0], fb[0]) + min(fa[1], fb[1])
                most = max(fa[0], fb[0]) + max(fa[1], fb[1])
                if least <= 0 <= most:
                    pending.append((a, fa, b, fb))
        return [(a + b) / 2 for a, _, b, _ in pending]

    # -- sensitivity ------------------------------------------------------

    def steady(self, t, rng, tries=3):
        """True if the answer survives an error of one f64 step in the origin.

        `t` is the true answer (None for a miss).  Coordinates the ray does not
        change, and those that start at zero, are left alone: f64 handles them
        without error.
        """
        kept, origin = self.cut, self.o
        try:
            for _ in range(tries):
                self.o = [
                    a * (1 + rng.choice((-1, 1)) * mpf(2) ** -52) if b else a
                    for a, b in zip(origin, self.d)
                ]
                self.cut = [-a / b if b else None for a, b in zip(self.o, self.d)]
                bracket = self.first_crossing(sign(self.size(mpf(0)) - 1))
                if (bracket is None) != (t is None):
                    return False
                if bracket and abs(bracket[0] - t) > mpf(1e-9) * (1 + t):
                    return False
        finally:
            self.cut, self.o = kept, origin
        return True

    # -- both together ----------------------------------------------------

    def solve(self):
        """Return (start_inside, t or None, normal or None, margin), or raise."""
        start_value = self.size(mpf(0)) - 1
        if abs(start_value) < mpf(10) ** -30:
            raise OnSurface
        start = sign(start_value)
        bracket = self.first_crossing(start)

        points = [(t, value - 1) for t, value in self.breakpoints()]
        levels = [g for _, g in points]
        near = [abs(levels[0])]
        cusps = self.cusps()
        for i, (before, here, after) in enumerate(zip(levels, levels[1:], levels[2:]), 1):
            if (here - before) * (after - here) <= 0 or points[i][0] in cusps:
                near.append(abs(here))
        if bracket is None:
            if start < 0:
                raise Disagreement("the ray starts inside and never leaves")
            margin = max(min(levels), mpf(0))
        else:
            margin = min(near + [mpf(1)])
        self._compare(start, bracket, points, min(near))
        if bracket is None:
            return start < 0, None, None, margin
        t = (bracket[0] + bracket[1]) / 2
        return start < 0, t, self.normal(t), margin

    def _compare(self, start, bracket, points, nearest):
        """Raise Disagreement if the extrema tell another story than the isolation."""
        if nearest < TOUCH:
            return
        expected = None
        for (ta, _), (tb, gb) in zip(points, points[1:]):
            if sign(gb) == -start:
                expected = (ta, tb)
                break
        if (expected is None) != (bracket is None):
            raise Disagreement(f"isolation {bracket}, extrema {expected}")
        if bracket:
            slack = self.resolution(bracket[1]) + mpf(10) ** -50 * (1 + bracket[1])
            if bracket[0] < expected[0] - slack or bracket[1] > expected[1] + slack:
                raise Disagreement(f"isolation {bracket}, extrema {expected}")


# -- drawing rays ---------------------------------------------------------


def norm_f64(e, n, v):
    """N in f64, good enough to place points near the surface."""

    def two(a, b, p):
        m, s = max(abs(a), abs(b)), min(abs(a), abs(b))
        return m * (1.0 + (s / m) ** p) ** (1.0 / p) if m else 0.0

    return two(two(v[0], v[1], 2.0 / e), v[2], 2.0 / n)


def unit(v):
    """v scaled to length one, or None if it is too short."""
    length = math.sqrt(sum(c * c for c in v))
    return [c / length for c in v] if length > 1e-150 else None


class Painter:
    """Draws random rays, one class of ray at a time."""

    WEIGHTS = {
        "near": 14,
        "far": 10,
        "very_far": 9,
        "inside": 12,
        "axis": 6,
        "plane": 10,
        "silhouette": 14,
        "away": 6,
        "spike": 10,
        "origin": 3,
        "zero_component": 6,
        "edge": 10,
    }

    def __init__(self, seed):
        self.rng = random.Random(seed)

    def exponent(self):
        """Log-uniform in [0.0001, 8], six digits."""
        low, high = math.log(0.0001), math.log(8.0)
        return float(f"{math.exp(self.rng.uniform(low, high)):.6g}")

    def exponents(self):
        """A pair (e, n), special or random, pure or mixed."""
        rng = self.rng
        kind = rng.random()
        if kind < 0.35:
            return rng.choice(SPECIAL), rng.choice(SPECIAL)
        if kind < 0.45:
            both = rng.choice(SPECIAL)
            return both, both
        if kind < 0.60:
            pair = [rng.choice(SPECIAL), self.exponent()]
        elif kind < 0.70:
            small = rng.choice([0.0001, 0.001, 0.01, 10 ** rng.uniform(-4, -1)])
            large = rng.choice([2.5, 3.0, 4.0, 6.0, 8.0, rng.uniform(2, 8)])
            pair = [float(f"{small:.6g}"), float(f"{large:.6g}")]
        else:
            pair = [self.exponent(), self.exponent()]
        rng.shuffle(pair)
        return pair[0], pair[1]

    def direction(self):
        """A uniformly distributed unit vector."""
        while True:
            v = unit([self.rng.gauss(0, 1) for _ in range(3)])
            if v:
                return v

    def on_surface(self, e, n):
        """A point of the surface, in f64."""
        v = self.direction()
        if self.rng.random() < 0.3:
            v[self.rng.randrange(3)] *= 10 ** self.rng.uniform(-6, 0)
        size = norm_f64(e, n, v)
        return [c / size for c in v]

    def target(self, e, n):
        """Somewhere in or around the shape."""
        kind = self.rng.random()
        if kind < 0.4:
            scale = self.rng.uniform(0, 1.1)
            return [scale * c for c in self.on_surface(e, n)]
        if kind < 0.65:
            return [self.rng.uniform(-1.2, 1.2) for _ in range(3)]
        if kind < 0.75:
            return [self.rng.uniform(-0.5, 0.5) for _ in range(3)]
        return self.around(1, 3)

    def around(self, low, high):
        """An origin at a log-uniform distance."""
        scale = math.exp(self.rng.uniform(math.log(low), math.log(high)))
        return [scale * c for c in self.direction()]

    def inner(self, e, n):
        """A point inside of the shape."""
        scale = self.rng.uniform(0, 1) ** 0.5 * 0.9999
        return [scale * c for c in self.on_surface(e, n)]

    def tiny(self, low=-16, high=-1):
        """A signed number of random magnitude."""
        return self.rng.choice((-1, 1)) * 10 ** self.rng.uniform(low, high)

    def start(self, e, n):
        """An origin for the classes that may start anywhere."""
        kind = self.rng.random()
        if kind < 0.2:
            return self.inner(e, n)
        if kind < 0.8:
            return self.around(1.2, 6)
        return self.around(6, 100)

    def between(self, o, target):
        """Unit direction from o to target; None if they coincide."""
        return unit([b - a for a, b in zip(o, target)])

    def draw(self, kind, e, n):
        """Return (o, d) of a class; d may be None if the draw was degenerate."""
        return getattr(self, "_" + kind)(e, n)

    def _near(self, e, n):
        o = self.around(1.2, 6)
        return o, self.between(o, self.target(e, n))

    def _far(self, e, n):
        o = self.around(6, 100)
        return o, self.between(o, self.target(e, n))

    def _very_far(self, e, n):
        o = self.around(100, 1e6)
        return o, self.between(o, self.target(e, n))

    def _inside(self, e, n):
        return self.inner(e, n), self.direction()

    def _axis(self, e, n):
        axis, side = self.rng.randrange(3), self.rng.choice((-1.0, 1.0))
        o = [self.rng.uniform(-1.02, 1.02) for _ in range(3)]
        for i in range(3):
            kind = self.rng.random()
            if kind < 0.15:
                o[i] = 0.0
            elif kind < 0.3:
                o[i] = self.tiny()
        if self.rng.random() < 0.8:
            o[axis] = -3.0 * side
        zero = self.rng.choice((0.0, 0.0, -0.0))
        d = [zero, zero, zero]
        d[axis] = side
        return o, d

    def _plane(self, e, n):
        axis = self.rng.randrange(3)
        o = self.start(e, n)
        aim = self.target(e, n)
        if self.rng.random() < 0.3:
            aim = [c * self.rng.choice((0.0, 1.0)) for c in aim]
        o[axis] = aim[axis] = 0.0
        return o, self.between(o, aim)

    def _silhouette(self, e, n):
        point = self.on_surface(e, n)
        outward = self._gradient(e, n, point)
        if outward is None:
            return point, None
        v = self.direction()
        dot = sum(a * b for a, b in zip(v, outward))
        tangent = unit([a - dot * b for a, b in zip(v, outward)])
        if tangent is None:
            return point, None
        lift = self.tiny(-10, -2)
        back = 10 ** self.rng.uniform(-0.5, 1.7)
        o = [c + lift * g - back * s for c, g, s in zip(point, outward, tangent)]
        return o, self.between(o, [c + lift * g for c, g in zip(point, outward)])

    @staticmethod
    def _gradient(e, n, v):
        """Unit gradient of N in f64, or None."""
        p, q = 2 / e, 2 / n
        size = norm_f64(1.0, 1.0, v)
        radius = norm_f64(e, n, [v[0], v[1], 0.0])
        logs = []
        for c, power, scale in ((v[0], p, q - p), (v[1], p, q - p), (v[2], q, 0)):
            if c == 0 or size == 0 or radius == 0:
                return None
            logs.append((power - 1) * math.log(abs(c)) + scale * math.log(radius))
        top = max(logs)
        return unit([math.copysign(math.exp(x - top), c) for x, c in zip(logs, v)])

    def _away(self, e, n):
        o = self.around(1.8, 50)
        d = self.direction()
        if sum(a * b for a, b in zip(o, d)) < 0:
            d = [-c for c in d]
        return o, d

    def _spike(self, e, n):
        axis, side = self.rng.randrange(3), self.rng.choice((-1.0, 1.0))
        aim = [0.0, 0.0, 0.0]
        aim[axis] = side * self.rng.choice((1.0, 0.5, self.rng.uniform(0.2, 1.05)))
        kind = self.rng.random()
        if kind < 0.7:
            for i in range(3):
                if i != axis and self.rng.random() < 0.8:
                    aim[i] = self.tiny()
        o = self.start(e, n)
        if kind > 0.85:
            # Exactly through the axis: the two other coordinates vanish together.
            o = [0.0, 0.0, 0.0]
            o[axis] = aim[axis]
            d = [self.rng.choice((-1.0, 1.0)) * self.rng.choice((1.0, 0.5, 0.25)) for _ in range(3)]
            if self.rng.random() < 0.7:
                d[axis] = 0.0
            d = unit(d)
            return [c - 4.0 * s for c, s in zip(o, d)], d
        return o, self.between(o, aim)

    def _origin(self, e, n):
        d = self.direction()
        if self.rng.random() < 0.5:
            d[self.rng.randrange(3)] = 0.0
        if self.rng.random() < 0.2:
            d[self.rng.randrange(3)] = self.tiny(-20, -1)
        return [0.0, 0.0, 0.0], unit(d)

    def _zero_component(self, e, n):
        aim, o = self.target(e, n), self.start(e, n)
        axis = self.rng.randrange(3)
        o[axis] = aim[axis]
        if self.rng.random() < 0.25:
            other = (axis + 1) % 3
            o[other] = aim[other]
        return o, self.between(o, aim)

    def _edge(self, e, n):
        v = self.direction()
        kind = self.rng.randrange(4)
        if kind == 0:  # the edges along z: |x| = |y|
            v[1] = math.copysign(v[0], v[1])
        elif kind == 1:  # the rim: R = |z|
            v[2] = math.copysign(norm_f64(e, n, [v[0], v[1], 0.0]), v[2])
        elif kind == 2:  # the crease in a coordinate plane
            v[self.rng.randrange(3)] = 0.0
        else:  # a corner
            v[1] = math.copysign(v[0], v[1])
            v[2] = math.copysign(norm_f64(e, n, [v[0], v[1], 0.0]), v[2])
        size = norm_f64(e, n, v)
        if not size:
            return v, None
        aim = [c / size for c in v]
        if self.rng.random() < 0.6:
            aim[self.rng.randrange(3)] += self.tiny(-14, -2)
        o = self.start(e, n)
        return o, self.between(o, aim)

    def rays(self):
        """Yield (class, e, n, o, d) for ever."""
        names, weights = list(self.WEIGHTS), list(self.WEIGHTS.values())
        while True:
            kind = self.rng.choices(names, weights)[0]
            e, n = self.exponents()
            o, d = self.draw(kind, e, n)
            if d is not None and any(d):
                yield kind, e, n, o, d


# -- files ----------------------------------------------------------------


def down(x):
    """x >= 0 rounded down to three digits, as text; 0 below TOUCH."""
    if x < TOUCH:
        return "0.0"
    if x >= 1 and x == int(x):
        return repr(float(x))
    power = int(mp.floor(mp.log10(x)))
    digits = int(mp.floor(x * mpf(10) ** (2 - power)))
    return repr(float(f"{digits}e{power - 2}"))


def row(e, n, o, d):
    """Solve one ray and return its line for the file as a list of text, and the exact t."""
    inside, t, normal, margin = Ray(e, n, o, d).solve()
    line = [repr(c) for c in (e, n, *o, *d)] + [str(int(inside)), str(int(t is not None))]
    if t is None:
        line += [""] * 4
    else:
        line += [repr(float(t))] + [repr(float(c)) for c in normal]
    return line + [down(margin)], t


def give_up(_signal, _frame):
    """Handler of the alarm that ends a ray which takes too long."""
    raise Disagreement(f"no answer within {PER_RAY} s")


def generate(args):
    """Write args.rays rays (or as many as fit into args.seconds) to args.out."""
    counts, hits = collections.Counter(), collections.Counter()
    skipped = collections.Counter()
    begin = time.time()
    signal.signal(signal.SIGALRM, give_up)
    tags = open(args.tags, "w") if args.tags else None
    with open(args.out, "w") as out:
        out.write(",".join(COLUMNS) + "\n")
        if tags:
            tags.write("class,steady\n")
        for kind, e, n, o, d in Painter(args.seed).rays():
            if args.rays is not None and sum(counts.values()) >= args.rays:
                break
            if args.seconds is not None and time.time() - begin > args.seconds:
                break
            try:
                signal.alarm(PER_RAY)
                line, t = row(e, n, o, d)
            except OnSurface:
                skipped["origin on the surface"] += 1
                continue
            except Disagreement as problem:
                skipped["disagreement"] += 1
                print("disagreement:", kind, e, n, o, d, problem, file=sys.stderr)
                continue
            finally:
                signal.alarm(0)
            out.write(",".join(line) + "\n")
            out.flush()
            if tags:
                steady = Ray(e, n, o, d).steady(t, random.Random(args.seed))
                tags.write(f"{kind},{int(steady)}\n")
                tags.flush()
            counts[kind] += 1
            hits[kind] += line[9] == "1"
    for kind in Painter.WEIGHTS:
        print(f"{kind:15} {counts[kind]:7} rays {hits[kind]:7} hits")
    print(f"{'all':15} {sum(counts.values()):7} rays {sum(hits.values()):7} hits")
    print(f"{time.time() - begin:.0f} s; left out: {dict(skipped) or 'none'}")


def check(path, decided):
    """Compare every row of a file with this program; returns the number of bad rows."""
    total = bad = undecided = 0
    worst_t = worst_normal = 0.0
    with open(path, newline="") as lines:
        for number, line in enumerate(csv.DictReader(lines), 2):
            total += 1
            e, n = float(line["e"]), float(line["n"])
            o = [float(line["o" + c]) for c in "xyz"]
            d = [float(line["d" + c]) for c in "xyz"]
            inside, t, normal, margin = Ray(e, n, o, d).solve()
            says = []
            if int(line["start_inside"]) != inside:
                says.append(f"start_inside {int(inside)}")
            if (line["hit"] == "1") != (t is not None):
                if min(float(line["margin"]), margin) > decided:
                    says.append(f"hit {int(t is not None)}")
                else:
                    undecided += 1
            elif t is not None:
                error = float(abs(mpf(float(line["t"])) - t) / (1 + t))
                worst_t = max(worst_t, error)
                if error > 1e-9:
                    says.append(f"t {float(t)!r}, relative error {error:.3g}")
                if 0.02 <= e <= 1.99 and 0.02 <= n <= 1.99:
                    other = [float(line["n" + c]) for c in "xyz"]
                    gap = max(abs(float(a) - b) for a, b in zip(normal, other))
                    worst_normal = max(worst_normal, gap)
                    if gap > 1e-6:
                        says.append(f"normal {[float(c) for c in normal]}")
            if says:
                bad += 1
                print(f"{path}:{number}: e={e} n={n} margin {line['margin']}"
                      f" (here {float(margin):.3g}): {'; '.join(says)}")
    print(f"{total} rows, {bad} bad, {undecided} differ below the margin of {decided:g};"
          f" worst t {worst_t:.2g}, worst normal (e, n in [0.02, 1.99]) {worst_normal:.2g}")
    return bad


def main():
    """Parse the command line and run."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("--rays", type=int, help="number of rows to write")
    parser.add_argument("--seconds", type=float, help="stop after this time")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--out", help="csv file to write")
    parser.add_argument("--tags",
                        help="also write a file with the class of every row and whether its"
                        " answer survives an error of one f64 step in the origin")
    parser.add_argument("--check", metavar="CSV", help="compare a file instead of writing one")
    parser.add_argument("--decided", type=float, default=1e-6,
                        help="with --check: rows below this margin may differ in hit")
    args = parser.parse_args()
    if args.check:
        return 1 if check(args.check, args.decided) else 0
    if not args.out or (args.rays is None and args.seconds is None):
        parser.error("--out and one of --rays and --seconds are needed (or --check)")
    generate(args)
    return 0


if __name__ == "__main__":
    sys.exit(main())
