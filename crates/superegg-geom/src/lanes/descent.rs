//! Searches along rays that go through the box of a convex shape, several registers at a time: the steps of one depend on each other, those of
//! another fill the time between.

use pulp::Simd;

use super::PowerKind;
use super::kernel::{CLOSE, Curve, Descent, Evaluate, Pair, Square, Sum, TINY, Triple};
use super::log_norm::{AnyPower, LogNorm, Round};
use super::vector::{Lanes, Mask};

/// So many registers keep the machine busy.
pub(super) const SIDE_BY_SIDE: usize = 2;
/// Steps before what is left goes to f64: grazing rays.
const MOST_STEPS: usize = 10;
/// From where N is off the level by no more than this the last step is taken unseen.
pub(super) const NEAR: f32 = 1e-3;
/// Tangents from inside are followed back this much farther: the crossing is not before what is said of it.
const BACK: f32 = 1.0 + 1.0 / 2048.0;
/// From deeper inside they say nothing.
const DEEPEST: f32 = -0.5;
/// Where N bends so little before its crossing the last step is as good as its second order.
const STRAIGHT: f32 = 7.0 / 8.0;
/// The last step is off by less than this part of itself, or f64 will find that it is not.
const LAST_STEP: f32 = 1.0 / 512.0;

/// Work that needs to know the norm of a shape, for one register and for [`SIDE_BY_SIDE`] of them.
pub(super) trait WithNorm<S: Simd> {
    type Output;
    fn run(self, one: impl Evaluate<S>, many: impl Evaluate<S, SIDE_BY_SIDE>) -> Self::Output;
}

/// Does work for the norm of two powers, by what is quickest for them.
#[inline(always)]
pub(super) fn with_norm<S: Simd, W: WithNorm<S>>(
    simd: S,
    xy: PowerKind,
    rz: PowerKind,
    work: W,
) -> W::Output {
    let (p, q) = (xy.power(), rz.power());
    match (xy, rz) {
        (PowerKind::Two, PowerKind::Two) => work.run(Pair(Square, Square), Pair(Square, Square)),
        (PowerKind::One, PowerKind::One) => work.run(Pair(Sum, Sum), Pair(Sum, Sum)),
        (PowerKind::Two, PowerKind::One) => work.run(Pair(Square, Sum), Pair(Square, Sum)),
        (PowerKind::One, PowerKind::Two) => work.run(Pair(Sum, Square), Pair(Sum, Square)),
        (PowerKind::Two, _) => work.run(round(simd, q), round(simd, q)),
        _ => work.run(general(simd, p, q), general(simd, p, q)),
    }
}

#[inline(always)]
fn round<S: Simd, const K: usize>(simd: S, q: f32) -> LogNorm<S, Round, K> {
    LogNorm::new(Round, Lanes::splat(simd, q))
}

#[inline(always)]
fn general<S: Simd, const K: usize>(simd: S, p: f32, q: f32) -> LogNorm<S, AnyPower<S, K>, K> {
    LogNorm::new(AnyPower::new(Lanes::splat(simd, p)), Lanes::splat(simd, q))
}

/// A part of each ray.
#[derive(Clone, Copy)]
pub(super) struct Passage<S: Simd, const K: usize = 1> {
    pub(super) start: Triple<S, K>,
    pub(super) direction: Triple<S, K>,
    /// In lengths of the direction.
    pub(super) length: Lanes<S, K>,
    /// Lanes that have a ray.
    pub(super) active: Mask<S, K>,
}

/// The first crossing of each ray with the shape, of those that come to the level 1 + tolerance.
#[derive(Clone, Copy)]
pub(super) struct Crossing<S: Simd, const K: usize = 1> {
    /// The way to the level 1, by the last step, which is unseen.
    pub(super) s: Lanes<S, K>,
    pub(super) found: Mask<S, K>,
    /// By how much `s` is off, in doubt or not; it is never farther beyond the crossing: the parabola passes that by no more than it passes the tangent. Where
    /// N has an edge on the last step the crossing may be farther on, which f64 tells.
    pub(super) error: Lanes<S, K>,
    /// Where the search has not come to its end.
    pub(super) doubt: Mask<S, K>,
}

impl<S: Simd, const K: usize> Crossing<S, K> {
    #[inline(always)]
    pub(super) fn part(&self, k: usize) -> Crossing<S> {
        let Self { s, found, error, doubt } = *self;
        Crossing { s: s.part(k), found: found.part(k), error: error.part(k), doubt: doubt.part(k) }
    }
}

/// From a place outside. N is convex, so where a tangent is above the level N is too: what tangents leave is where the crossing can be. Each step goes
/// to where the parabola with N's value, slope and bend comes down to the level (Cauchy's method, of third order), but not out of that. From `near` the level on the
/// last step is taken unseen.
#[inline(always)]
pub(super) fn first_crossings<S: Simd, const K: usize>(
    norm: impl Evaluate<S, K>,
    passage: &Passage<S, K>,
    tolerance: Lanes<S, K>,
    near: Lanes<S, K>,
) -> Crossing<S, K> {
    let (zero, one) = (tolerance.all(0.0), tolerance.all(1.0));
    let (level, close) = (one + tolerance, tolerance.all(CLOSE));
    let slack = tolerance + tolerance + close + near * one.all(LAST_STEP);
    let Passage { start, direction, length, mut active } = *passage;
    let (mut s, mut error, mut found) = (zero, zero, zero.lt(zero));
    // By the tangents of N so far the level is not reached before the one, nor beyond the other.
    let (mut first, mut last) = (zero, length);
    for _ in 0..MOST_STEPS {
        let curve = norm.curve(start.along(s, direction), direction, level);
        let (Curve { excess, scale, slope, bend }, way) = (curve, curve.way());
        let falls = slope.lt(zero);
        let steepness = slope.abs().max(one.all(TINY));
        let square = slope * slope;
        let twice = excess + excess;
        let rest = (-twice).mul_add(bend, square);
        let by_parabola = twice * scale * (steepness + rest.root_rough()).recip_rough();
        let reach = (falls & (one.all(STRAIGHT) * square).le(rest)).select(near, close);
        let is_near = falls & (-reach).le(excess);
        let arrived = active & excess.le(reach) & (is_near | s.le(first));
        let unsure = excess.mul_add(way, by_parabola).abs();
        error = arrived.select(slack.mul_add(way.abs(), unsure), error);
        found = found | arrived;
        let by_tangent = (-excess.min(excess * one.all(BACK))).mul_add(way, s);
        first = (falls & one.all(DEEPEST).le(excess)).select(first.max(by_tangent), first);
        last = falls.select(last, last.min(by_tangent));
        let next = falls.select((s + by_parabola).min(last), first).max(first);
        // The last step goes on to the level 1.
        let next = arrived.select((-tolerance).mul_add(way.min(zero), next), next);
        s = active.select(next, s);
        active = active.and_not(arrived) & first.le(last);
        if !active.any() {
            break;
        }
    }
    // What is in doubt is not before this.
    Crossing { s: active.select(first, s), found: found | active, error, doubt: active }
}

/// Whether each ray comes into the shape.
#[derive(Clone, Copy)]
pub(super) struct Entry<S: Simd, const K: usize = 1> {
    /// Where it is inside for certain: this far from the middle of the passage.
    pub(super) s: Lanes<S, K>,
    pub(super) inside: Mask<S, K>,
    /// Where it may be.
    pub(super) touched: Mask<S, K>,
}

/// From the middle of the passage downhill, whichever way that is: a convex function has its least value there. First to the level at which the shape
/// can no longer be missed, then on to the one at which it is met for certain.
#[inline(always)]
pub(super) fn entries<S: Simd, const K: usize>(
    norm: impl Evaluate<S, K>,
    passage: &Passage<S, K>,
    tolerance: Lanes<S, K>,
) -> Entry<S, K> {
    let (zero, one, half) = (tolerance.all(0.0), tolerance.all(1.0), tolerance.all(0.5));
    let close = tolerance.all(CLOSE);
    let (outside, inside) = (one + tolerance, one - tolerance);
    let Passage { start, direction, length, mut active } = *passage;
    let most = half * length;
    let middle = start.along(most, direction);
    let mut downhill = one;
    let nothing = zero.lt(zero);
    let mut entry = Entry { s: zero, inside: nothing, touched: nothing };
    for step in 0..MOST_STEPS {
        // What the excess over one level says of the others.
        let Descent { excess, way } = norm.descent(middle.along(entry.s, direction), direction, outside);
        if step == 0 {
            downhill = (-one).times_sign_of(way);
        }
        let arrived = active & (excess + (outside - inside)).le(zero);
        entry.touched = entry.touched | (active & excess.le(close));
        entry.inside = entry.inside | arrived;
        // The slope still leads downhill.
        active = (active & (way * downhill).lt(zero)).and_not(arrived);
        let excess = entry.touched.select(excess + (outside - inside + close), excess);
        entry.s = active.select(entry.s - excess * way, entry.s);
        active = active & entry.s.abs().le(most);
        if !active.any() {
            break;
        }
    }
    entry.touched = entry.touched | active;
    entry
}

#[cfg(test)]
mod tests {
    use glam::DVec3;
    use pulp::{Arch, Scalar, WithSimd};

    use super::*;
    use crate::{Exponents, Ray, RayStart, Superquadric};

    const LANES: usize = 16;
    const TOLERANCE: f32 = 1.5e-6;

    /// Rays from outside of a unit shape, by columns: starts, directions, and ways.
    #[derive(Clone)]
    struct Rays {
        start: [[f32; LANES]; 3],
        direction: [[f32; LANES]; 3],
        length: [f32; LANES],
    }

    impl Rays {
        fn ray(&self, lane: usize) -> Ray {
            let vector = |columns: &[[f32; LANES]; 3]| DVec3::from_array(columns.map(|x| f64::from(x[lane])));
            Ray::new(vector(&self.start), vector(&self.direction))
        }
    }

    /// What is asked of N on each ray.
    struct Asked<'a> {
        shape: &'a Superquadric,
        rays: &'a Rays,
    }

    /// At the starts what Newton's step and the parabola are made of; the crossing, by how much it may be off, and whether it is found and in doubt.
    #[derive(Clone, Copy, Default)]
    struct Told {
        newton: [f32; LANES],
        bow: [f32; LANES],
        s: [f32; LANES],
        error: [f32; LANES],
        found: u32,
        doubt: u32,
    }

    impl WithSimd for Asked<'_> {
        type Output = Told;

        #[inline(always)]
        fn with_simd<S: Simd>(self, simd: S) -> Told {
            let norm = self.shape.norm();
            with_norm(simd, PowerKind::of(norm.xy.p), PowerKind::of(norm.rz.p), AskedOf(simd, self.rays))
        }
    }

    struct AskedOf<'a, S: Simd>(S, &'a Rays);

    impl<S: Simd> WithNorm<S> for AskedOf<'_, S> {
        type Output = Told;

        #[inline(always)]
        fn run(self, one: impl Evaluate<S>, _: impl Evaluate<S, SIDE_BY_SIDE>) -> Told {
            let Self(simd, Rays { start, direction, length }) = self;
            let mut told = Told::default();
            for i in 0..LANES / S::F32_LANES {
                let lanes = |column: &[f32; LANES]| Lanes::<S>::new(simd, S::as_simd_f32s(column).0[i]);
                let triple =
                    |v: &[[f32; LANES]; 3]| Triple { x: lanes(&v[0]), y: lanes(&v[1]), z: lanes(&v[2]) };
                let (start, direction, length) = (triple(start), triple(direction), lanes(length));
                let Curve { excess, scale, slope, bend } = one.curve(start, direction, length.all(1.0));
                S::as_mut_simd_f32s(&mut told.newton).0[i] = (excess * scale / slope).register();
                S::as_mut_simd_f32s(&mut told.bow).0[i] = (bend * excess / (slope * slope)).register();
                let active = length.all(0.0).le(length);
                let passage = Passage { start, direction, length, active };
                let Crossing { s, found, error, doubt } =
                    first_crossings(one, &passage, length.all(TOLERANCE), length.all(NEAR));
                S::as_mut_simd_f32s(&mut told.s).0[i] = s.register();
                S::as_mut_simd_f32s(&mut told.error).0[i] = error.register();
                told.found |= found.bits() << (i * S::F32_LANES);
                told.doubt |= doubt.bits() << (i * S::F32_LANES);
            }
            told
        }
    }

    /// Numbers that are the same on every run, in [-1, 1).
    fn numbers() -> impl FnMut() -> f32 {
        let mut state = 7u32;
        move || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) as f32 / (1 << 23) as f32 - 1.0
        }
    }

    /// Shapes with rays that start on their boxes and go in.
    fn cases() -> impl Iterator<Item = (Superquadric, Rays)> {
        let exponents = [0.0001, 0.01, 0.1, 0.4, 1.0, 1.3, 2.0];
        let mut next = numbers();
        (0..49 * 60).map(move |case| {
            let shape =
                Superquadric::unit(Exponents::new(exponents[case % 7], exponents[case / 7 % 7]).unwrap());
            let mut rays =
                Rays { start: [[0.0; LANES]; 3], direction: [[0.0; LANES]; 3], length: [0.0; LANES] };
            for lane in 0..LANES {
                let mut start = [next(), next(), next()];
                let face = (1.5 + 1.5 * next()) as usize % 3;
                start[face] = if next() < 0.0 { -1.0 } else { 1.0 };
                let to = [next(), next(), next()];
                for axis in 0..3 {
                    rays.start[axis][lane] = start[axis];
                    rays.direction[axis][lane] = to[axis] - start[axis];
                }
                let size = (0..3).map(|axis| rays.direction[axis][lane].abs()).fold(1e-3, f32::max);
                rays.length[lane] = 2.0 / size;
            }
            (shape, rays)
        })
    }

    #[test]
    fn the_derivatives_are_those_of_the_norm() {
        let mut told_of = 0;
        for (shape, rays) in
            cases().filter(|(shape, _)| shape.exponents().e().min(shape.exponents().n()) > 0.05)
        {
            for told in [
                Asked { shape: &shape, rays: &rays }.with_simd(Scalar),
                Arch::new().dispatch(Asked { shape: &shape, rays: &rays }),
            ] {
                for lane in 0..LANES {
                    let Ray { origin, direction, .. } = rays.ray(lane);
                    let at = |s: f64| {
                        let (norm, gradient) = shape.norm().value_and_gradient(origin + s * direction);
                        (norm, gradient.dot(direction))
                    };
                    let (norm, slope) = at(0.0);
                    let step = 1e-5;
                    let bend = (at(step).1 - at(-step).1) / (2.0 * step);
                    // Where it is nearly level, or an edge is near, neither is known well.
                    let farther = (at(2.0 * step).1 - at(-2.0 * step).1) / (4.0 * step);
                    let is_clear =
                        norm > 1.001 && slope.abs() > 0.01 && (bend - farther).abs() < 1e-3 * bend.abs();
                    if !is_clear || origin.abs().min_element() < 1e-3 {
                        continue;
                    }
                    told_of += 1;
                    let (newton, bow) = ((norm - 1.0) / slope, bend * (norm - 1.0) / (slope * slope));
                    let off = f64::from(told.newton[lane]) - newton;
                    assert!(
                        off.abs() < 2e-3 * newton.abs(),
                        "{shape:?} {origin} {direction}: {newton} {off}"
                    );
                    let off = f64::from(told.bow[lane]) - bow;
                    assert!(
                        off.abs() < 1e-2 * bow.abs() + 1e-6,
                        "{shape:?} {origin} {direction}: {bow} {off}"
                    );
                }
            }
        }
        assert!(told_of > 10_000, "{told_of}");
    }

    #[test]
    fn no_crossing_is_missed_or_said_too_far_and_few_are_farther_than_is_said() {
        let (mut hits, mut off, mut doubtful) = (0, 0, 0);
        for (shape, rays) in cases() {
            for told in [
                Asked { shape: &shape, rays: &rays }.with_simd(Scalar),
                Arch::new().dispatch(Asked { shape: &shape, rays: &rays }),
            ] {
                for lane in 0..LANES {
                    let ray = rays.ray(lane);
                    let (found, doubt) = (told.found >> lane & 1 == 1, told.doubt >> lane & 1 == 1);
                    let exact = shape.intersect(&ray, RayStart::Free);
                    doubtful += u32::from(doubt);
                    let Some(exact) = exact.filter(|hit| !hit.leaving) else { continue };
                    hits += 1;
                    assert!(found || doubt, "{shape:?} {ray:?} {exact:?}");
                    let (s, error) = (f64::from(told.s[lane]), f64::from(told.error[lane]));
                    assert!(s - error <= exact.t, "{shape:?} {ray:?} {exact:?}: {s} {error}");
                    off += u32::from(s + error < exact.t && !doubt);
                }
            }
        }
        assert!(hits > 50_000 && off < hits / 500 && doubtful < hits / 500, "{hits} {off} {doubtful}");
    }
}
