//! Searches for the level N = 1 along rays that cross the box of a convex shape.
//!
//! N is convex along a ray, so each tangent bounds it from below. [`first_crossings`] finds the first crossing from
//! outside, [`entries`] any point inside. Both work on several registers at once (see [`super::norm::SIDE_BY_SIDE`]).

use superegg_simd::{Lanes, Mask, Simd, Triple};

use super::norm::{CLOSE, Curve, EvaluateNorm, Slope, TINY};

/// Steps before a lane is left unresolved: those are grazing rays.
const MAX_STEPS: usize = 10;
/// Within this distance of the level (in N) the final step is not re-evaluated.
pub(super) const NEAR: f32 = 1e-3;
/// A tangent from inside is followed back this much farther, so that the crossing is not before the bound it gives.
const BACK: f32 = 1.0 + 1.0 / 2048.0;
/// Tangents from points deeper inside than this give no bound.
const DEEPEST: f32 = -0.5;
/// Where `slope^2 - 2 excess bend` is at least this part of `slope^2`, the curvature is small enough for the final step to
/// have second-order accuracy.
const STRAIGHT: f32 = 7.0 / 8.0;
/// Relative error of the final step. A larger error is detected by the refinement in f64.
const LAST_STEP: f32 = 1.0 / 512.0;

/// The part of each ray that is searched.
#[derive(Clone, Copy)]
pub(super) struct Segment<S: Simd, const K: usize = 1> {
    pub(super) start: Triple<S, K>,
    pub(super) direction: Triple<S, K>,
    /// In lengths of the direction.
    pub(super) length: Lanes<S, K>,
    /// The lanes that have a ray.
    pub(super) active: Mask<S, K>,
}

/// The first crossing of each ray with the level 1 + tolerance.
#[derive(Clone, Copy)]
pub(super) struct Crossing<S: Simd, const K: usize = 1> {
    /// The parameter of the level 1, by the final step, which is not re-evaluated.
    pub(super) s: Lanes<S, K>,
    /// Where there is a crossing, or may be one.
    pub(super) found: Mask<S, K>,
    /// Upper bound on the error of `s`. The crossing is at `s - error` or later: the overshoot is at most the difference
    /// between the parabolic and the tangent step. It is later than `s + error` only where N has an edge on the final step,
    /// which the refinement in f64 detects.
    pub(super) error: Lanes<S, K>,
    /// Where the search did not converge, or N hardly falls to the level: f32 does not tell whether there is a crossing.
    pub(super) unresolved: Mask<S, K>,
}

/// The first crossing of each ray, which starts outside of the shape.
///
/// Cauchy's method, of third order: each step goes to where the parabola with N's value, slope and second derivative
/// crosses the level. `first` and `last` bound the crossing by the tangents so far: where a tangent is above the level, N is
/// too. A step never leaves these bounds, and a lane where they exclude each other misses. Within `near` of the level the
/// final step is not re-evaluated.
#[inline(always)]
pub(super) fn first_crossings<S: Simd, const K: usize>(
    norm: impl EvaluateNorm<S, K>,
    segment: &Segment<S, K>,
    tolerance: Lanes<S, K>,
    near: Lanes<S, K>,
) -> Crossing<S, K> {
    let (zero, one) = (tolerance.all(0.0), tolerance.all(1.0));
    let (level, close) = (one + tolerance, tolerance.all(CLOSE));
    let slack = tolerance + tolerance + close + near * one.all(LAST_STEP);
    let Segment { start, direction, length, mut active } = *segment;
    let (mut s, mut error, mut found) = (zero, zero, zero.lt(zero));
    let (mut first, mut last, mut grazes) = (zero, length, found);
    for _ in 0..MAX_STEPS {
        let curve = norm.curve(start.along(s, direction), direction, level);
        let (Curve { excess, scale, slope, bend }, inv_slope) = (curve, curve.inv_slope());
        let falls = slope.lt(zero);
        let steepness = slope.abs().max(one.all(TINY));
        let square = slope * slope;
        let twice = excess + excess;
        let rest = (-twice).mul_add(bend, square);
        let by_parabola = twice * scale * (steepness + rest.root_rough()).recip_rough();
        let reach = (falls & (one.all(STRAIGHT) * square).le(rest)).select(near, close);
        let is_near = falls & (-reach).le(excess);
        let arrived = active & excess.le(reach) & (is_near | s.le(first));
        let overshoot = excess.mul_add(inv_slope, by_parabola).abs();
        error = arrived.select(slack.mul_add(inv_slope.abs(), overshoot), error);
        found = found | arrived;
        // The least value of the parabola is above the level 1 - tolerance.
        let deepest = twice + (tolerance + tolerance) + (tolerance + tolerance);
        grazes = grazes | arrived.and_not(falls & zero.le((-deepest).mul_add(bend, square)));
        let by_tangent = (-excess.min(excess * one.all(BACK))).mul_add(inv_slope, s);
        first = (falls & one.all(DEEPEST).le(excess)).select(first.max(by_tangent), first);
        last = falls.select(last, last.min(by_tangent));
        let next = falls.select((s + by_parabola).min(last), first).max(first);
        // The final step continues from the level 1 + tolerance to the level 1.
        let next = arrived.select((-tolerance).mul_add(inv_slope.min(zero), next), next);
        s = active.select(next, s);
        active = active.and_not(arrived) & first.le(last);
        if !active.any() {
            break;
        }
    }
    // An unresolved crossing is not before the lower bound.
    let s = active.select(first, grazes.select((s - error).max(first), s));
    Crossing { s, found: found | active, error, unresolved: active | grazes }
}

/// Whether each ray enters the shape.
#[derive(Clone, Copy)]
pub(super) struct Entry<S: Simd, const K: usize = 1> {
    /// A point inside, where `inside` is true: this far from the middle of the segment.
    pub(super) s: Lanes<S, K>,
    /// Where the ray certainly enters the shape.
    pub(super) inside: Mask<S, K>,
    /// Where it may.
    pub(super) touched: Mask<S, K>,
}

/// A point inside on each ray, if there is one.
///
/// Newton's method from the middle of the segment downhill, in either direction: a convex function has its minimum there.
/// First to the level 1 + tolerance, below which the shape may be entered, then to 1 - tolerance, below which it certainly
/// is.
#[inline(always)]
pub(super) fn entries<S: Simd, const K: usize>(
    norm: impl EvaluateNorm<S, K>,
    segment: &Segment<S, K>,
    tolerance: Lanes<S, K>,
) -> Entry<S, K> {
    let (zero, one, half) = (tolerance.all(0.0), tolerance.all(1.0), tolerance.all(0.5));
    let close = tolerance.all(CLOSE);
    let (outside, inside) = (one + tolerance, one - tolerance);
    let Segment { start, direction, length, mut active } = *segment;
    let half_length = half * length;
    let middle = start.along(half_length, direction);
    let mut downhill = one;
    let nowhere = zero.lt(zero);
    let mut entry = Entry { s: zero, inside: nowhere, touched: nowhere };
    for step in 0..MAX_STEPS {
        // Near the level the excess over one level gives the excess over others by a difference.
        let Slope { excess, inv_slope } = norm.slope(middle.along(entry.s, direction), direction, outside);
        if step == 0 {
            downhill = (-one).times_sign_of(inv_slope);
        }
        let arrived = active & (excess + (outside - inside)).le(zero);
        entry.touched = entry.touched | (active & excess.le(close));
        entry.inside = entry.inside | arrived;
        // Past the minimum the slope changes its sign.
        active = (active & (inv_slope * downhill).lt(zero)).and_not(arrived);
        let excess = entry.touched.select(excess + (outside - inside + close), excess);
        entry.s = active.select(entry.s - excess * inv_slope, entry.s);
        active = active & entry.s.abs().le(half_length);
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
    use superegg_simd::{Arch, Column, Scalar, WithSimd};

    use super::super::norm::{SIDE_BY_SIDE, WithNorm, with_norm};
    use super::super::powers::PowerKind;
    use super::*;
    use crate::{Exponents, Ray, RayStart, Superquadric};

    const LANES: usize = 16;
    const TOLERANCE: f32 = 1.5e-6;

    /// Rays from outside of a unit shape, by columns: starts, directions, and ways.
    #[derive(Clone)]
    struct Rays {
        start: [Column<f32, LANES>; 3],
        direction: [Column<f32, LANES>; 3],
        length: Column<f32, LANES>,
    }

    impl Rays {
        fn ray(&self, lane: usize) -> Ray {
            let vector = |columns: &[Column<f32, LANES>; 3]| {
                DVec3::from_array(columns.each_ref().map(|x| f64::from(x[lane])))
            };
            Ray::new(vector(&self.start), vector(&self.direction))
        }
    }

    /// Searches all rays of a shape.
    struct Search<'a> {
        shape: &'a Superquadric,
        rays: &'a Rays,
    }

    /// Newton's step and the relative curvature at the starts; the crossings with their error bounds; bits of the lanes.
    #[derive(Clone, Copy)]
    struct Answers {
        newton: Column<f32, LANES>,
        bow: Column<f32, LANES>,
        s: Column<f32, LANES>,
        error: Column<f32, LANES>,
        found: u32,
        unresolved: u32,
    }

    impl WithSimd for Search<'_> {
        type Output = Answers;

        #[inline(always)]
        fn with_simd<S: Simd>(self, simd: S) -> Answers {
            let norm = self.shape.norm();
            with_norm(simd, PowerKind::of(norm.xy.p), PowerKind::of(norm.rz.p), SearchWith(simd, self.rays))
        }
    }

    struct SearchWith<'a, S: Simd>(S, &'a Rays);

    impl<S: Simd> WithNorm<S> for SearchWith<'_, S> {
        type Output = Answers;

        #[inline(always)]
        fn run(self, one: impl EvaluateNorm<S>, _: impl EvaluateNorm<S, SIDE_BY_SIDE>) -> Answers {
            let Self(simd, Rays { start, direction, length }) = self;
            let zero = Column::splat(0.0);
            let mut answers =
                Answers { newton: zero, bow: zero, s: zero, error: zero, found: 0, unresolved: 0 };
            for i in 0..LANES / S::F32_LANES {
                let start = Triple::<S>::load(simd, start, i);
                let (direction, length) = (Triple::load(simd, direction, i), length.load(simd, i));
                let Curve { excess, scale, slope, bend } = one.curve(start, direction, length.all(1.0));
                answers.newton.store(i, excess * scale / slope);
                answers.bow.store(i, bend * excess / (slope * slope));
                let active = length.all(0.0).le(length);
                let segment = Segment { start, direction, length, active };
                let Crossing { s, found, error, unresolved } =
                    first_crossings(one, &segment, length.all(TOLERANCE), length.all(NEAR));
                answers.s.store(i, s);
                answers.error.store(i, error);
                answers.found |= found.bits_from(i);
                answers.unresolved |= unresolved.bits_from(i);
            }
            answers
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
        let (mut next, zero) = (numbers(), Column::splat(0.0));
        (0..49 * 60).map(move |case| {
            let shape =
                Superquadric::unit(Exponents::new(exponents[case % 7], exponents[case / 7 % 7]).unwrap());
            let mut rays = Rays { start: [zero; 3], direction: [zero; 3], length: zero };
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
        let mut compared = 0;
        for (shape, rays) in
            cases().filter(|(shape, _)| shape.exponents().e().min(shape.exponents().n()) > 0.05)
        {
            for answers in [
                Search { shape: &shape, rays: &rays }.with_simd(Scalar),
                Arch::new().dispatch(Search { shape: &shape, rays: &rays }),
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
                    compared += 1;
                    let (newton, bow) = ((norm - 1.0) / slope, bend * (norm - 1.0) / (slope * slope));
                    let off = f64::from(answers.newton[lane]) - newton;
                    assert!(
                        off.abs() < 2e-3 * newton.abs(),
                        "{shape:?} {origin} {direction}: {newton} {off}"
                    );
                    let off = f64::from(answers.bow[lane]) - bow;
                    assert!(
                        off.abs() < 1e-2 * bow.abs() + 1e-6,
                        "{shape:?} {origin} {direction}: {bow} {off}"
                    );
                }
            }
        }
        assert!(compared > 10_000, "{compared}");
    }

    #[test]
    fn no_crossing_is_missed_or_before_its_bound_and_few_are_beyond_it() {
        let (mut hits, mut off, mut unresolved) = (0, 0, 0);
        for (shape, rays) in cases() {
            for answers in [
                Search { shape: &shape, rays: &rays }.with_simd(Scalar),
                Arch::new().dispatch(Search { shape: &shape, rays: &rays }),
            ] {
                for lane in 0..LANES {
                    let ray = rays.ray(lane);
                    let is = |lanes: u32| lanes >> lane & 1 == 1;
                    let (found, open) = (is(answers.found), is(answers.unresolved));
                    let exact = shape.intersect(&ray, RayStart::Free);
                    unresolved += u32::from(open);
                    let Some(exact) = exact.filter(|hit| !hit.leaving) else { continue };
                    hits += 1;
                    assert!(found || open, "{shape:?} {ray:?} {exact:?}");
                    let (s, error) = (f64::from(answers.s[lane]), f64::from(answers.error[lane]));
                    assert!(s - error <= exact.t, "{shape:?} {ray:?} {exact:?}: {s} {error}");
                    off += u32::from(s + error < exact.t && !open);
                }
            }
        }
        assert!(hits > 50_000 && off < hits / 500 && unresolved < hits / 500, "{hits} {off} {unresolved}");
    }
}
