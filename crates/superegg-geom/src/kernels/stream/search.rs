//! Rays against shapes of any exponents, in f32: certain misses, certain entries, and short intervals that hold the first
//! crossing.
//!
//! N rises with |x|, |y| and |z|. Along an interval of a ray each of them has a least value, which is 0 or that at one end,
//! so N of these three is a lower bound of N on the interval: above 1, the ray does not enter the shape there. Intervals are
//! halved until they are discarded so, or a point inside is found. The gap of the bound shrinks with the width of the
//! interval, so the number of steps grows with the reciprocal of the distance from the surface; rays that graze it stay
//! unresolved.
//!
//! Where neither power is above 1, N is concave within an octant: a ray that is outside at both ends of an interval there is
//! outside all over it. Such rays go from one coordinate plane to the next.

use superegg_simd::{Lanes, Mask, Simd, Triple};

use super::super::norm::AnyPower;
use super::solve::{StreamHits, StreamLanes};

/// The most intervals that are examined.
const MOST_STEPS: u32 = 64;
/// Shorter intervals, in unit space, are not halved.
const LEAST_WIDTH: f32 = 1.0 / 1024.0;
/// The widest interval that isolates the first crossing. Longer ones more often bend too much to be verified from their ends.
const ISOLATED: f32 = 1.0 / 64.0;
/// The same where any point inside is an answer: the ends of wider intervals are seldom inside.
const ANY: f32 = 1.0 / 4.0;
/// The first interval, in parts of the ray.
const FIRST_WIDTH: f32 = 1.0 / 4.0;
/// Rays outside of a shape where N is concave pass the coordinate planes in intervals of twice this width.
const AROUND_PLANE: f32 = 2.0 * LEAST_WIDTH;
/// More than the rounding error of a coordinate.
const COORDINATE: f32 = 6e-7;
/// The error of a logarithm to base 2 of a norm is below this times 1 + 1/p + 1/q.
const LOGARITHM: f32 = 6e-6;
/// Smaller powers are left to f64: their norms have too few digits.
const LEAST_POWER: f32 = 1.0 / 32.0;
/// Stands for the logarithm of 0.
const LOG_ZERO: f32 = -1e4;

impl StreamLanes {
    /// [`StreamLanes::enters`] for the registers from `i` on.
    #[inline(always)]
    pub(super) fn enters_at<S: Simd, const K: usize>(&self, simd: S, i: usize, hits: &mut StreamHits) {
        let Found { crossed, unresolved, s, .. } = self.search::<S, K>(simd, i).run(ANY, false);
        hits.s.store(i, crossed.select(s, s.all(f32::INFINITY)));
        hits.found |= crossed.bits_from(i);
        hits.unresolved |= unresolved.bits_from(i);
    }

    /// [`StreamLanes::isolate`] for the registers from `i` on.
    #[inline(always)]
    pub(super) fn isolate_at<S: Simd, const K: usize>(&self, simd: S, i: usize, hits: &mut StreamHits) {
        let Found { crossed, unresolved, s, clear } = self.search::<S, K>(simd, i).run(ISOLATED, true);
        hits.s.store(i, crossed.select(s, s.all(f32::INFINITY)));
        hits.error.store(i, s - clear);
        hits.found |= crossed.bits_from(i);
        hits.unresolved |= unresolved.bits_from(i);
    }

    #[inline(always)]
    fn search<S: Simd, const K: usize>(&self, simd: S, i: usize) -> Search<S, K> {
        let inside = Mask::of_bits_from(simd, self.inward, i);
        let length: Lanes<S, K> = self.length.load(simd, i);
        let start: Triple<S, K> = Triple::load(simd, &self.start, i);
        let direction = Triple::load(simd, &self.direction, i);
        let to_planes =
            Triple { x: -start.x / direction.x, y: -start.y / direction.y, z: -start.z / direction.z };
        Search {
            start,
            direction,
            to_planes,
            length,
            inside,
            side: inside.select(length.all(-1.0), length.all(1.0)),
            norm: NormOfBounds::new(self.p.load(simd, i), self.q.load(simd, i)),
        }
    }
}

/// The results of a search, by lanes.
struct Found<S: Simd, const K: usize> {
    /// The lanes with a point on the other side.
    crossed: Mask<S, K>,
    /// Those without an answer.
    unresolved: Mask<S, K>,
    /// The distances of the points on the other side.
    s: Lanes<S, K>,
    /// The distances up to which the rays are certainly on the side of their start.
    clear: Lanes<S, K>,
}

struct Search<S: Simd, const K: usize> {
    start: Triple<S, K>,
    direction: Triple<S, K>,
    /// The lengths to the coordinate planes, for rays outside of shapes where N is concave.
    to_planes: Triple<S, K>,
    length: Lanes<S, K>,
    /// The rays that start inside and look for their exit.
    inside: Mask<S, K>,
    /// -1 for these, 1 for all others.
    side: Lanes<S, K>,
    norm: NormOfBounds<S, K>,
}

impl<S: Simd, const K: usize> Search<S, K> {
    /// Looks for an interval at the end of which the rays are on the other side for the first time. Only one bound of N is computed in
    /// a step: whether an interval is clear, or, after a short one that is not, whether its end is across.
    #[inline(always)]
    fn run(&self, most: f32, is_steady: bool) -> Found<S, K> {
        let Self { start, direction, length, norm, inside, side, .. } = self;
        let (zero, half, most) = (length.all(0.0), length.all(0.5), length.all(most));
        let none = zero.lt(zero);
        let mut active = zero.le(*length);
        let mut unresolved = active & norm.beyond_f32;
        active = active.and_not(unresolved);
        let concave = norm.is_concave.and_not(*inside);
        let mut crossed = none;
        let (mut s, mut end, mut reach) = (zero, *length, *length);
        let mut width = concave.select(most, *length * length.all(FIRST_WIDTH)).min(*length);
        // The lanes whose interval is short and not clear; those that are known to be outside at s; those that may be across at
        // `reach`.
        let (mut is_short, mut is_known, mut is_bracketed) = (none, none, none);
        for _ in 0..MOST_STEPS {
            if !active.any() {
                break;
            }
            let far_s = s + width;
            let (near, far) = (start.along(s, *direction), start.along(far_s, *direction));
            let least = least_between(near, far);
            let least_size = least.x.min(least.y).min(least.z);
            // Where N is concave within an octant, it is least at one end.
            let is_concave = concave & is_known & zero.lt(least_size);
            let from = select(is_short | is_concave, far, near);
            let is_greatest = (*inside | is_short).and_not(*inside & is_short);
            let bound = select(is_greatest, greatest_between(from, far), least_between(from, far));
            let log = *side * norm.log_value(bound);
            let is_across = active & is_short & log.le(-norm.tolerance);
            end = is_across.select(far_s, end);
            crossed = crossed | is_across;
            active = active.and_not(is_across);
            let is_clear = active.and_not(is_short) & norm.tolerance.le(log);
            let is_open = active.and_not(is_short | is_clear);
            // The slope of N changes less where no coordinate comes near 0.
            let is_smooth = (half * width).le(least_size) | width.lt(length.all(2.0 * LEAST_WIDTH));
            let is_first = is_open & width.le(most);
            let is_first = if is_steady { is_first & is_smooth } else { is_first };
            let is_halved = active.and_not(is_clear | is_first);
            is_bracketed = is_bracketed | (is_open & is_concave);
            reach = (is_open & is_concave).select(far_s, reach);
            s = is_clear.select(far_s, s);
            is_known = is_known | is_clear;
            let rest = reach - s;
            let is_wide = is_bracketed.and_not(rest.le(most));
            let next = concave.select(is_wide.select(rest * half, rest), (width + width).min(rest));
            width = is_clear.select(next, is_halved.select(width * half, width));
            if (is_clear & concave).any() {
                width = (is_clear & concave).select(width.min(self.to_plane(s)), width);
            }
            let is_over = is_clear & rest.le(zero);
            let is_narrow = is_halved & width.lt(length.all(LEAST_WIDTH));
            active = active.and_not(is_over | is_narrow);
            unresolved = unresolved | is_narrow;
            is_short = is_first;
        }
        Found { crossed, unresolved: unresolved | active, s: end, clear: s }
    }

    /// The length from s to just before the next coordinate plane; where that is close, to just beyond it.
    #[inline(always)]
    fn to_plane(&self, s: Lanes<S, K>) -> Lanes<S, K> {
        let Triple { x, y, z } = self.to_planes;
        around_plane(x - s).min(around_plane(y - s)).min(around_plane(z - s))
    }
}

/// A length to a plane, to just before it; where it is close, to just beyond it; infinite if it is behind.
#[inline(always)]
fn around_plane<S: Simd, const K: usize>(length: Lanes<S, K>) -> Lanes<S, K> {
    let close = length.all(AROUND_PLANE);
    let is_before = (close + close).lt(length);
    let is_at = (close * length.all(-0.5)).lt(length);
    is_before.select(length - close, is_at.select(length + close, length.all(f32::INFINITY)))
}

/// N of lower and upper bounds of coordinates.
struct NormOfBounds<S: Simd, const K: usize> {
    xy: AnyPower<S, K>,
    rz: AnyPower<S, K>,
    /// A bound on the error of the logarithm.
    tolerance: Lanes<S, K>,
    /// Where the powers are too small for f32.
    beyond_f32: Mask<S, K>,
    /// Where N is concave within each octant: neither power is above 1.
    is_concave: Mask<S, K>,
}

impl<S: Simd, const K: usize> NormOfBounds<S, K> {
    #[inline(always)]
    fn new(p: Lanes<S, K>, q: Lanes<S, K>) -> Self {
        let (one, least) = (p.all(1.0), p.all(LEAST_POWER));
        let tolerance = p.all(LOGARITHM) * (one + one / p + one / q);
        let beyond_f32 = p.lt(least) | q.lt(least);
        let is_concave = p.le(one) & q.le(one);
        Self { xy: AnyPower::new(p), rz: AnyPower::new(q), tolerance, beyond_f32, is_concave }
    }

    /// log2 N of non-negative coordinates.
    #[inline(always)]
    fn log_value(&self, at: Triple<S, K>) -> Lanes<S, K> {
        let (around, _) = self.xy.log_sum_and_ratio(log(at.x), log(at.y));
        self.rz.log_sum_and_ratio(around, log(at.z)).0
    }
}

#[inline(always)]
fn log<S: Simd, const K: usize>(x: Lanes<S, K>) -> Lanes<S, K> {
    let log = x.max(x.all(f32::MIN_POSITIVE)).log2_quick();
    x.all(0.0).lt(x).select(log, x.all(LOG_ZERO))
}

/// Lower bounds of |x|, |y| and |z| between two points of a line.
#[inline(always)]
fn least_between<S: Simd, const K: usize>(a: Triple<S, K>, b: Triple<S, K>) -> Triple<S, K> {
    Triple { x: least_size(a.x, b.x), y: least_size(a.y, b.y), z: least_size(a.z, b.z) }
}

#[inline(always)]
fn least_size<S: Simd, const K: usize>(a: Lanes<S, K>, b: Lanes<S, K>) -> Lanes<S, K> {
    let zero = a.all(0.0);
    let least = (a.abs().min(b.abs()) - a.all(COORDINATE)).max(zero);
    zero.lt(a * b).select(least, zero)
}

/// Upper bounds of |x|, |y| and |z| between two points of a line.
#[inline(always)]
fn greatest_between<S: Simd, const K: usize>(a: Triple<S, K>, b: Triple<S, K>) -> Triple<S, K> {
    let (a, b) = (enlarged(a), enlarged(b));
    Triple { x: a.x.max(b.x), y: a.y.max(b.y), z: a.z.max(b.z) }
}

/// `a` where the mask is true, `b` elsewhere.
#[inline(always)]
fn select<S: Simd, const K: usize>(mask: Mask<S, K>, a: Triple<S, K>, b: Triple<S, K>) -> Triple<S, K> {
    Triple { x: mask.select(a.x, b.x), y: mask.select(a.y, b.y), z: mask.select(a.z, b.z) }
}

/// Upper bounds of |x|, |y| and |z|.
#[inline(always)]
fn enlarged<S: Simd, const K: usize>(point: Triple<S, K>) -> Triple<S, K> {
    let more = point.x.all(COORDINATE);
    Triple { x: point.x.abs() + more, y: point.y.abs() + more, z: point.z.abs() + more }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;
    use superegg_simd::Arch;

    use super::super::entry::ShapeEntry;
    use super::super::solve::STREAM_LANES;
    use super::*;
    use crate::kernels::LanePowers;
    use crate::math::random::SplitMix;
    use crate::{Exponents, Ray, RayStart, Superquadric};

    #[test]
    fn answers_are_those_of_the_certified_search() {
        let exponents = [1e-4, 0.3, 1.0, 1.9, 2.0, 2.4, 3.0, 4.0, 7.0, 20.0, 63.0];
        let mut random = SplitMix::new(21);
        let (mut inside, mut clear, mut open) = (0, 0, 0);
        for case in 0..exponents.len() * exponents.len() * 12 {
            let (e, n) =
                (exponents[case % exponents.len()], exponents[case / exponents.len() % exponents.len()]);
            let shape = Superquadric::unit(Exponents::new(e, n).unwrap());
            let mut lanes = [StreamLanes::default(), StreamLanes::new(Arch::Scalar)];
            let mut rays = Vec::new();
            for lane in 0..STREAM_LANES {
                let mut start: [f64; 3] = std::array::from_fn(|_| 2.0 * random.unit() - 1.0);
                start[lane % 3] = if lane % 2 == 0 { 1.0 } else { -1.0 };
                // Many rays pass near an axis, where the shapes have their tips.
                let to = DVec3::from_array(std::array::from_fn(|_| 2.0 * random.unit() - 1.0));
                let to = if lane % 4 == 0 { to * DVec3::AXES[lane / 4 % 3] * 0.999 } else { to };
                let start = DVec3::from_array(start).as_vec3();
                let direction = (to.as_vec3() - start).normalize();
                let exits = (0..3).map(|axis| {
                    let face = f64::from(direction[axis].signum());
                    (face - f64::from(start[axis])) / f64::from(direction[axis])
                });
                let length = exits.filter(|t| t.is_finite()).fold(4.0, f64::min).max(0.0) as f32;
                let entry = ShapeEntry {
                    start: start.to_array(),
                    direction: direction.to_array(),
                    length,
                    t_entry: 0.0,
                    t_per_s: 1.0,
                };
                for lanes in &mut lanes {
                    lanes.set(lane, LanePowers::of_any(&shape), &entry, false);
                }
                rays.push((Ray::new(start.as_dvec3(), direction.as_dvec3()), length));
            }
            for lanes in &lanes {
                let mut answers = StreamHits::default();
                lanes.enters(STREAM_LANES, &mut answers);
                for (lane, (ray, length)) in rays.iter().enumerate() {
                    let (found, unknown) =
                        (answers.found >> lane & 1 == 1, answers.unresolved >> lane & 1 == 1);
                    let exact = shape.intersect_certified(ray, RayStart::Free);
                    if found {
                        inside += 1;
                        let at = ray.point_at(f64::from(answers.s[lane]));
                        assert!(shape.norm().value(at) < 1.0, "{shape:?} {ray:?}");
                        assert!(exact.is_some(), "{shape:?} {ray:?}");
                    } else if unknown {
                        open += 1;
                    } else {
                        clear += 1;
                        assert!(
                            exact.is_none_or(|hit| hit.t > f64::from(*length)),
                            "{shape:?} {ray:?} {exact:?}"
                        );
                    }
                }
            }
        }
        assert!(inside > 10_000 && clear > 10_000 && open * 4 < inside + clear, "{inside} {clear} {open}");
    }

    #[test]
    fn intervals_hold_the_first_crossing() {
        let exponents = [1e-4, 0.3, 1.0, 1.9, 2.0, 2.4, 3.0, 4.0, 7.0, 20.0];
        let mut random = SplitMix::new(22);
        let (mut isolated, mut open) = ([0, 0], 0);
        for case in 0..exponents.len() * exponents.len() * 12 {
            let (e, n) =
                (exponents[case % exponents.len()], exponents[case / exponents.len() % exponents.len()]);
            let shape = Superquadric::unit(Exponents::new(e, n).unwrap());
            let mut vector = || DVec3::from_array(std::array::from_fn(|_| 2.0 * random.unit() - 1.0));
            let is_inward = case % 2 == 1;
            let mut lanes = [StreamLanes::default(), StreamLanes::new(Arch::Scalar)];
            let mut rays = Vec::new();
            for lane in 0..STREAM_LANES {
                let (mut start, mut to) = (vector(), vector());
                if is_inward {
                    start *= 0.98 * random_share(lane) / shape.norm().value(start);
                    to = start + vector();
                } else {
                    start[lane % 3] = 1.0;
                }
                let start = start.as_vec3();
                let direction = (to.as_vec3() - start).normalize();
                let exits = (0..3).map(|axis| {
                    let face = f64::from(direction[axis].signum());
                    (face - f64::from(start[axis])) / f64::from(direction[axis])
                });
                let length = exits.filter(|t| t.is_finite()).fold(4.0, f64::min).max(0.0) as f32;
                let (start_f32, direction_f32) = (start.to_array(), direction.to_array());
                let entry = ShapeEntry {
                    start: start_f32,
                    direction: direction_f32,
                    length,
                    t_entry: 0.0,
                    t_per_s: 1.0,
                };
                for lanes in &mut lanes {
                    lanes.set(lane, LanePowers::of_any(&shape), &entry, is_inward);
                }
                rays.push(Ray::new(start.as_dvec3(), direction.as_dvec3()));
            }
            for lanes in &lanes {
                let mut answers = StreamHits::default();
                lanes.isolate(STREAM_LANES, &mut answers);
                for (lane, ray) in rays.iter().enumerate() {
                    if answers.found >> lane & 1 == 0 {
                        open += answers.unresolved >> lane & 1;
                        continue;
                    }
                    isolated[usize::from(is_inward)] += 1;
                    let exact = shape.intersect_certified(ray, RayStart::Free).unwrap();
                    let (s, error) = (f64::from(answers.s[lane]), f64::from(answers.error[lane]));
                    assert_eq!(exact.leaving, is_inward);
                    assert!((s - error..=s).contains(&exact.t), "{shape:?} {ray:?} {exact:?} {s} {error}");
                    assert!(error <= f64::from(ISOLATED) * 1.001);
                }
            }
        }
        assert!(isolated[0] > 5_000 && isolated[1] > 10_000 && open < 6_000, "{isolated:?} {open}");
    }

    /// From just below the surface to the middle.
    fn random_share(lane: usize) -> f64 {
        1.0 - lane as f64 / STREAM_LANES as f64
    }

    /// The registers that are searched alone have the answers of those that are searched side by side.
    #[test]
    fn few_rays_have_the_answers_of_many() {
        let mut random = SplitMix::new(23);
        for case in 0..400 {
            let exponent = |i: usize| [0.3, 1.0, 2.4, 4.0][i % 4];
            let shape = Superquadric::unit(Exponents::new(exponent(case), exponent(case / 4)).unwrap());
            let mut lanes = StreamLanes::default();
            for lane in 0..STREAM_LANES {
                let mut start = DVec3::from_array(std::array::from_fn(|_| 2.0 * random.unit() - 1.0));
                start[lane % 3] = 1.0;
                let to = DVec3::from_array(std::array::from_fn(|_| 2.0 * random.unit() - 1.0));
                let direction = (to - start).normalize().as_vec3().to_array();
                let start = start.as_vec3().to_array();
                let entry = ShapeEntry { start, direction, length: 1.0, t_entry: 0.0, t_per_s: 1.0 };
                lanes.set(lane, LanePowers::of_any(&shape), &entry, false);
            }
            for search in [StreamLanes::isolate, StreamLanes::enters] {
                let [mut all, mut few] = [StreamHits::default(), StreamHits::default()];
                search(&lanes, STREAM_LANES, &mut all);
                for count in [1, 5, 9, 17] {
                    search(&lanes, count, &mut few);
                    let mask = (1 << count) - 1;
                    assert_eq!(
                        [few.found & mask, few.unresolved & mask],
                        [all.found & mask, all.unresolved & mask]
                    );
                    assert_eq!(few.s.0[..count], all.s.0[..count]);
                }
            }
        }
    }
}
