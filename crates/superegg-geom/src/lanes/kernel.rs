//! Newton's method on the norm form in lanes: `convex.rs` for many rays at a time.

use pulp::{Simd, WithSimd};

use super::vector::{Lanes, Mask};
use super::{LaneHits, LaneRays, PowerKind};

/// A ray is done when its step is below this, or N is this near to 1: a few units of the last place of f32 at 1.
pub(super) const CLOSE: f32 = 3e-7;
/// Convexity makes forty reach the last digit from a double root.
const MAX_STEPS: usize = 48;
/// The box is taken this much larger, for the rounding of its crossings.
pub(super) const BOX: f32 = 1.0 + 1e-6;
/// Stands for zero in a denominator.
pub(super) const TINY: f32 = 1e-30;

/// Which exponents the rays of a batch meet.
pub(super) enum Powers<'a> {
    /// The same for all.
    Uniform { xy: PowerKind, rz: PowerKind },
    /// A pair of powers for each ray.
    Each { p: &'a [f32], q: &'a [f32] },
}

/// The work on one batch.
pub(super) struct Kernel<'a> {
    pub(super) powers: Powers<'a>,
    pub(super) rays: &'a LaneRays,
    pub(super) hits: &'a mut LaneHits,
}

impl WithSimd for Kernel<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { powers, rays, hits } = self;
        match powers {
            Powers::Uniform { xy, rz } => match (xy, rz) {
                (PowerKind::Two, PowerKind::Two) => run(simd, rays, hits, |_| (Square, Square)),
                (PowerKind::One, PowerKind::One) => run(simd, rays, hits, |_| (Sum, Sum)),
                (PowerKind::Two, PowerKind::General(q)) => {
                    run(simd, rays, hits, |_| (Square, General::splat(simd, q)));
                }
                (PowerKind::General(p), PowerKind::Two) => {
                    run(simd, rays, hits, |_| (General::splat(simd, p), Square));
                }
                (PowerKind::Two, PowerKind::One) => run(simd, rays, hits, |_| (Square, Sum)),
                (PowerKind::One, PowerKind::Two) => run(simd, rays, hits, |_| (Sum, Square)),
                (xy, rz) => {
                    let general = |kind: PowerKind| General::splat(simd, kind.power());
                    run(simd, rays, hits, |_| (general(xy), general(rz)));
                }
            },
            Powers::Each { p, q } => {
                let (p, q) = (S::as_simd_f32s(p).0, S::as_simd_f32s(q).0);
                run(simd, rays, hits, |i| (General::new(simd, p[i]), General::new(simd, q[i])));
            }
        }
    }
}

/// A two-term norm in lanes.
pub(super) trait Norm2<S: Simd, const K: usize = 1>: Copy {
    /// `|(a, b)|` and its derivatives by a and b, for a, b >= 0.
    fn value_and_gradient(self, a: Lanes<S, K>, b: Lanes<S, K>) -> (Lanes<S, K>, Lanes<S, K>, Lanes<S, K>);
}

/// Such a norm with its second derivative.
pub(super) trait Bent<S: Simd, const K: usize = 1>: Norm2<S, K> {
    /// The second derivative along a line, from the norm there, the place and the direction.
    fn bend(self, value: Lanes<S, K>, place: [Lanes<S, K>; 2], direction: [Lanes<S, K>; 2]) -> Lanes<S, K>;
}

/// p = 2: the root of a sum of squares.
#[derive(Clone, Copy)]
pub(super) struct Square;

impl<S: Simd, const K: usize> Norm2<S, K> for Square {
    #[inline(always)]
    fn value_and_gradient(self, a: Lanes<S, K>, b: Lanes<S, K>) -> (Lanes<S, K>, Lanes<S, K>, Lanes<S, K>) {
        let value = a.mul_add(a, b * b).sqrt();
        let inverse = a.all(1.0) / value.max(a.all(TINY));
        (value, a * inverse, b * inverse)
    }
}

impl<S: Simd, const K: usize> Bent<S, K> for Square {
    #[inline(always)]
    fn bend(
        self,
        value: Lanes<S, K>,
        [a, b]: [Lanes<S, K>; 2],
        [to_a, to_b]: [Lanes<S, K>; 2],
    ) -> Lanes<S, K> {
        let inverse = value.max(value.all(TINY)).recip_rough();
        let turn = a.mul_add(to_b, -(b * to_a)) * inverse;
        turn * turn * inverse
    }
}

/// p = 1: the sum.
#[derive(Clone, Copy)]
pub(super) struct Sum;

impl<S: Simd, const K: usize> Norm2<S, K> for Sum {
    #[inline(always)]
    fn value_and_gradient(self, a: Lanes<S, K>, b: Lanes<S, K>) -> (Lanes<S, K>, Lanes<S, K>, Lanes<S, K>) {
        (a + b, a.all(1.0), a.all(1.0))
    }
}

impl<S: Simd, const K: usize> Bent<S, K> for Sum {
    #[inline(always)]
    fn bend(self, value: Lanes<S, K>, _: [Lanes<S, K>; 2], _: [Lanes<S, K>; 2]) -> Lanes<S, K> {
        value.all(0.0)
    }
}

/// Any p >= 1: `m (1 + r^p)^(1/p)` with the larger argument m taken out.
#[derive(Clone, Copy)]
pub(super) struct General<S: Simd> {
    p: Lanes<S>,
    inverse_p: Lanes<S>,
}

impl<S: Simd> General<S> {
    #[inline(always)]
    fn new(simd: S, p: S::f32s) -> Self {
        let p = Lanes::new(simd, p);
        Self { p, inverse_p: p.all(1.0) / p }
    }

    #[inline(always)]
    pub(super) fn splat(simd: S, p: f32) -> Self {
        Self::new(simd, simd.splat_f32s(p))
    }
}

impl<S: Simd> Norm2<S> for General<S> {
    #[inline(always)]
    fn value_and_gradient(self, a: Lanes<S>, b: Lanes<S>) -> (Lanes<S>, Lanes<S>, Lanes<S>) {
        let one = a.all(1.0);
        let larger = a.max(b).max(a.all(TINY));
        let ratio = (a.min(b) / larger).max(a.all(TINY));
        let power = (self.p * ratio.log2()).exp2();
        let sum = one + power;
        let growth = (self.inverse_p * sum.log2()).exp2();
        let by_larger = growth / sum;
        let by_smaller = by_larger * power / ratio;
        let a_is_larger = b.le(a);
        (
            larger * growth,
            a_is_larger.select(by_larger, by_smaller),
            a_is_larger.select(by_smaller, by_larger),
        )
    }
}

/// A point or direction in lanes.
#[derive(Clone, Copy)]
pub(super) struct Triple<S: Simd, const K: usize = 1> {
    pub(super) x: Lanes<S, K>,
    pub(super) y: Lanes<S, K>,
    pub(super) z: Lanes<S, K>,
}

impl<S: Simd> Triple<S> {
    #[inline(always)]
    fn load(simd: S, columns: &[Vec<f32>; 3], i: usize) -> Self {
        let lane = |column: &[f32]| Lanes::new(simd, S::as_simd_f32s(column).0[i]);
        Self { x: lane(&columns[0]), y: lane(&columns[1]), z: lane(&columns[2]) }
    }
}

impl<S: Simd, const K: usize> Triple<S, K> {
    /// Registers side by side.
    #[inline(always)]
    pub(super) fn join(parts: [Triple<S>; K]) -> Self {
        let (mut x, mut y, mut z) = ([parts[0].x; K], [parts[0].y; K], [parts[0].z; K]);
        for k in 1..K {
            (x[k], y[k], z[k]) = (parts[k].x, parts[k].y, parts[k].z);
        }
        Self { x: Lanes::join(x), y: Lanes::join(y), z: Lanes::join(z) }
    }

    /// `self + s direction`.
    #[inline(always)]
    pub(super) fn along(self, s: Lanes<S, K>, direction: Self) -> Self {
        Self {
            x: s.mul_add(direction.x, self.x),
            y: s.mul_add(direction.y, self.y),
            z: s.mul_add(direction.z, self.z),
        }
    }

    #[inline(always)]
    pub(super) fn scaled(self, by: Lanes<S, K>) -> Self {
        Self { x: self.x * by, y: self.y * by, z: self.z * by }
    }

    #[inline(always)]
    pub(super) fn select(mask: Mask<S, K>, a: Self, b: Self) -> Self {
        Self { x: mask.select(a.x, b.x), y: mask.select(a.y, b.y), z: mask.select(a.z, b.z) }
    }
}

/// How N goes on from a place on a ray.
#[derive(Clone, Copy)]
pub(super) struct Descent<S: Simd, const K: usize = 1> {
    /// By how much N is above the level that is looked for, as a part of itself or in all: the two are one near 1.
    pub(super) excess: Lanes<S, K>,
    /// Newton's method goes back by `excess * way` from here: the reciprocal of the slope, negative where N falls.
    pub(super) way: Lanes<S, K>,
}

/// N on a ray at a place, with its first two derivatives along the ray: those of N over N, times powers of one positive number, so that none needs a
/// division. All but that number are also times another one, which is near 1 where N is.
#[derive(Clone, Copy)]
pub(super) struct Curve<S: Simd, const K: usize = 1> {
    /// As in [`Descent`].
    pub(super) excess: Lanes<S, K>,
    /// The number.
    pub(super) scale: Lanes<S, K>,
    /// N' / N, times the number.
    pub(super) slope: Lanes<S, K>,
    /// N'' / N, times its square; never negative.
    pub(super) bend: Lanes<S, K>,
}

/// Less than 1 by more than what a quick reciprocal is off.
const SHORT: f32 = 1.0 - 1e-4;

impl<S: Simd, const K: usize> Curve<S, K> {
    /// As in [`Descent`], a little too short, so that no step goes too far.
    #[inline(always)]
    pub(super) fn way(self) -> Lanes<S, K> {
        let Self { scale, slope, .. } = self;
        let inverse = slope.abs().max(slope.all(TINY)).with_sign_of(slope).recip_rough();
        scale * inverse * slope.all(SHORT)
    }
}

/// N and the way it rises at a place.
#[derive(Clone, Copy)]
pub(super) struct Rise<S: Simd, const K: usize = 1> {
    pub(super) norm: Lanes<S, K>,
    /// The gradient of N times `scale`, which is positive.
    pub(super) gradient: Triple<S, K>,
    pub(super) scale: Lanes<S, K>,
}

/// A way to evaluate N.
pub(super) trait Evaluate<S: Simd, const K: usize = 1>: Copy {
    /// How N goes on from a point in a direction.
    fn descent(self, point: Triple<S, K>, direction: Triple<S, K>, level: Lanes<S, K>) -> Descent<S, K>;

    /// The same with how it bends.
    fn curve(self, point: Triple<S, K>, direction: Triple<S, K>, level: Lanes<S, K>) -> Curve<S, K>;

    /// N and its gradient at a point.
    fn rise(self, point: Triple<S, K>) -> Rise<S, K>;
}

/// N as one norm of another.
#[derive(Clone, Copy)]
pub(super) struct Pair<X, Z>(pub(super) X, pub(super) Z);

impl<S: Simd, X: Bent<S, K>, Z: Bent<S, K>, const K: usize> Evaluate<S, K> for Pair<X, Z> {
    #[inline(always)]
    fn descent(self, point: Triple<S, K>, direction: Triple<S, K>, level: Lanes<S, K>) -> Descent<S, K> {
        let (value, slope) = evaluate(self.0, self.1, point, direction);
        Descent { excess: value - level, way: level.all(1.0) / slope }
    }

    #[inline(always)]
    fn curve(self, point: Triple<S, K>, direction: Triple<S, K>, level: Lanes<S, K>) -> Curve<S, K> {
        let (x, y, z) = (point.x.abs(), point.y.abs(), point.z.abs());
        let to_x = direction.x.times_sign_of(point.x);
        let to_y = direction.y.times_sign_of(point.y);
        let to_z = direction.z.times_sign_of(point.z);
        let (r, by_x, by_y) = self.0.value_and_gradient(x, y);
        let (norm, by_r, by_z) = self.1.value_and_gradient(r, z);
        let to_r = by_x.mul_add(to_x, by_y * to_y);
        let slope = by_r.mul_add(to_r, by_z * to_z);
        let bend =
            by_r.mul_add(self.0.bend(r, [x, y], [to_x, to_y]), self.1.bend(norm, [r, z], [to_r, to_z]));
        Curve { excess: norm - level, scale: level.all(1.0), slope, bend }
    }

    #[inline(always)]
    fn rise(self, point: Triple<S, K>) -> Rise<S, K> {
        let (r, by_x, by_y) = self.0.value_and_gradient(point.x.abs(), point.y.abs());
        let (norm, by_r, by_z) = self.1.value_and_gradient(r, point.z.abs());
        let gradient = Triple {
            x: (by_r * by_x).times_sign_of(point.x),
            y: (by_r * by_y).times_sign_of(point.y),
            z: by_z.times_sign_of(point.z),
        };
        Rise { norm, gradient, scale: norm.all(1.0) }
    }
}

/// N at a point, and its derivative along a direction.
#[inline(always)]
fn evaluate<S: Simd, const K: usize>(
    xy: impl Norm2<S, K>,
    rz: impl Norm2<S, K>,
    point: Triple<S, K>,
    direction: Triple<S, K>,
) -> (Lanes<S, K>, Lanes<S, K>) {
    let (r, by_x, by_y) = xy.value_and_gradient(point.x.abs(), point.y.abs());
    let (norm, by_r, by_z) = rz.value_and_gradient(r, point.z.abs());
    // d|x|/ds = dx sign x.
    let radial =
        (by_x * direction.x).mul_add(point.x.with_unit_sign(), by_y * direction.y * point.y.with_unit_sign());
    (norm, by_r.mul_add(radial, by_z * direction.z * point.z.with_unit_sign()))
}

/// All registers of a batch.
#[inline(always)]
fn run<S: Simd, X: Norm2<S>, Z: Norm2<S>>(
    simd: S,
    rays: &LaneRays,
    hits: &mut LaneHits,
    norms: impl Fn(usize) -> (X, Z),
) {
    let t_min = S::as_simd_f32s(&rays.t_min).0;
    let out_t = S::as_mut_simd_f32s(&mut hits.t).0;
    let out_leaving = S::as_mut_simd_f32s(&mut hits.leaving).0;
    let out_steps = S::as_mut_simd_f32s(&mut hits.steps).0;
    for i in 0..out_t.len() {
        let (xy, rz) = norms(i);
        let origin = Triple::load(simd, &rays.origin, i);
        let direction = Triple::load(simd, &rays.direction, i);
        let (t, leaving, steps) = intersect(xy, rz, origin, direction, Lanes::new(simd, t_min[i]));
        out_t[i] = t.register();
        out_leaving[i] = leaving.register();
        out_steps[i] = steps.register();
    }
}

/// The first crossing with t >= `t_min` in each lane (infinity for none), 1 where it leads out, and the evaluations of N.
#[inline(always)]
fn intersect<S: Simd>(
    xy: impl Norm2<S>,
    rz: impl Norm2<S>,
    origin: Triple<S>,
    direction: Triple<S>,
    t_min: Lanes<S>,
) -> (Lanes<S>, Lanes<S>, Lanes<S>) {
    let zero = t_min.all(0.0);
    let one = t_min.all(1.0);
    let infinity = t_min.all(f32::INFINITY);

    // The span of the ray in the box, slab by slab. 0 / 0 is kept out by moving a zero component off zero.
    let (mut near, mut far) = (t_min, infinity);
    for (o, d) in [(origin.x, direction.x), (origin.y, direction.y), (origin.z, direction.z)] {
        let inverse = one / d.abs().max(t_min.all(TINY)).with_sign_of(d);
        let middle = -o * inverse;
        let half = inverse.abs() * t_min.all(BOX);
        near = near.max(middle - half);
        far = far.min(middle + half);
    }
    let mut active = near.le(far);
    let mut t_hit = infinity;
    let mut steps = zero;
    if !active.any() {
        return (t_hit, zero, steps);
    }

    // A start within the box may be inside: then the way is from the far side, backwards, to the exit.
    let mut start = origin.along(near, direction);
    let mut forward = direction;
    let mut inside = near.lt(near);
    let starts_here = active & near.le(t_min);
    if starts_here.any() {
        let (norm, _) = evaluate(xy, rz, start, direction);
        steps = steps + starts_here.select(one, zero);
        inside = starts_here & norm.lt(one);
        let back = Triple { x: -direction.x, y: -direction.y, z: -direction.z };
        start = Triple::select(inside, origin.along(far, direction), start);
        forward = Triple::select(inside, back, forward);
    }

    let length = far - near;
    let close = t_min.all(CLOSE);
    let mut s = zero;
    let mut hit = near.lt(near);
    for _ in 0..MAX_STEPS {
        let (norm, slope) = evaluate(xy, rz, start.along(s, forward), forward);
        steps = steps + active.select(one, zero);
        let above = norm - one;
        let falls = slope.lt(zero);
        // On the surface, coming from outside; or past it by rounding.
        let arrived = active & above.le(close) & (falls | zero.lt(s));
        hit = hit | arrived;
        active = (active & falls).and_not(arrived);
        let next = s - above / slope;
        s = active.select(next, s);
        active = active & next.le(length);
        if !active.any() {
            break;
        }
    }
    // Where rounding hides the exit of an inside start, it is the start itself.
    let s = hit.select(s, length);
    let t = inside.select((far - s).max(t_min), near + s);
    t_hit = (hit | inside).select(t, t_hit);
    (t_hit, inside.select(one, zero), steps)
}
