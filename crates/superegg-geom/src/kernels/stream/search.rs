//! Rays against shapes of any exponents, in f32: certain misses, certain entries, and short intervals that hold the first
//! crossing.
//!
//! N rises with |x|, |y| and |z|. Along an interval of a ray each of them has a least value, which is 0 or that at one end,
//! so N of these three is a lower bound of N on the interval: above 1, the ray does not enter the shape there. Intervals are
//! halved until they are discarded so, or a point inside is found. The gap of the bound shrinks with the width of the
//! interval, so the number of steps grows with the reciprocal of the distance from the surface; rays that graze it stay
//! unresolved.

use superegg_simd::{Lanes, Mask, Simd, Triple};

use super::super::norm::{AnyPower, SIDE_BY_SIDE};
use super::solve::{StreamHits, StreamLanes};

/// The most intervals that are examined.
const MOST_STEPS: u32 = 64;
/// Shorter intervals, in unit space, are not halved.
const LEAST_WIDTH: f32 = 1.0 / 1024.0;
/// The widest interval that isolates the first crossing. Longer ones more often bend too much to be verified from their ends.
const ISOLATED: f32 = 1.0 / 64.0;
/// The same where any point inside is an answer: the ends of wider intervals are seldom inside.
const ANY: f32 = 1.0 / 4.0;
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
    pub(super) fn enters_at<S: Simd>(&self, simd: S, i: usize, hits: &mut StreamHits) {
        let Found { crossed, unresolved, s, .. } = self.search(simd, i).run(ANY);
        hits.s.store(i, crossed.select(s, s.all(f32::INFINITY)));
        hits.found |= crossed.bits_from(i);
        hits.unresolved |= unresolved.bits_from(i);
    }

    /// [`StreamLanes::isolate`] for the registers from `i` on.
    #[inline(always)]
    pub(super) fn isolate_at<S: Simd>(&self, simd: S, i: usize, hits: &mut StreamHits) {
        let Found { crossed, unresolved, s, clear } = self.search(simd, i).run(ISOLATED);
        hits.s.store(i, crossed.select(s, s.all(f32::INFINITY)));
        hits.error.store(i, s - clear);
        hits.found |= crossed.bits_from(i);
        hits.unresolved |= unresolved.bits_from(i);
    }

    #[inline(always)]
    fn search<S: Simd>(&self, simd: S, i: usize) -> Search<S, SIDE_BY_SIDE> {
        let inside = Mask::of_bits_from(simd, self.inward, i);
        let length: Lanes<S, SIDE_BY_SIDE> = self.length.load(simd, i);
        Search {
            start: Triple::load(simd, &self.start, i),
            direction: Triple::load(simd, &self.direction, i),
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
    length: Lanes<S, K>,
    /// The rays that start inside and look for their exit.
    inside: Mask<S, K>,
    /// -1 for these, 1 for all others.
    side: Lanes<S, K>,
    norm: NormOfBounds<S, K>,
}

impl<S: Simd, const K: usize> Search<S, K> {
    /// Whether the rays are certainly on the side of their start between two points.
    #[inline(always)]
    fn is_clear(&self, near: Triple<S, K>, far: Triple<S, K>) -> Mask<S, K> {
        let Self { inside, side, norm, .. } = self;
        let closest = select(*inside, greatest_between(near, far), least_between(near, far));
        norm.tolerance.le(*side * norm.log_value(closest))
    }

    /// Whether a point is certainly on the other side.
    #[inline(always)]
    fn is_across(&self, point: Triple<S, K>) -> Mask<S, K> {
        let Self { inside, side, norm, .. } = self;
        let closest = select(*inside, reduced(point), enlarged(point));
        (*side * norm.log_value(closest)).le(-norm.tolerance)
    }

    /// Looks for an interval, no wider than `most`, at the end of which the rays are on the other side for the first time.
    #[inline(always)]
    fn run(&self, most: f32) -> Found<S, K> {
        let Self { start, direction, length, norm, .. } = self;
        let (zero, half) = (length.all(0.0), length.all(0.5));
        let mut active = zero.le(*length);
        let mut unresolved = active & norm.beyond_f32;
        active = active.and_not(unresolved);
        let mut crossed = zero.lt(zero);
        let (mut s, mut width, mut end) = (zero, *length, *length);
        for _ in 0..MOST_STEPS {
            if !active.any() {
                break;
            }
            let far = start.along(s + width, *direction);
            let is_clear = active & self.is_clear(start.along(s, *direction), far);
            let is_short = active.and_not(is_clear) & width.le(length.all(most));
            if is_short.any() {
                let is_across = is_short & self.is_across(far);
                end = is_across.select(s + width, end);
                crossed = crossed | is_across;
                active = active.and_not(is_across);
            }
            s = is_clear.select(s + width, s);
            width = is_clear.select((width + width).min(*length - s), width * half);
            let is_over = is_clear & width.le(zero);
            let is_narrow = active.and_not(is_clear) & width.lt(length.all(LEAST_WIDTH));
            active = active.and_not(is_over | is_narrow);
            unresolved = unresolved | is_narrow;
        }
        Found { crossed, unresolved: unresolved | active, s: end, clear: s }
    }
}

/// N of lower and upper bounds of coordinates.
struct NormOfBounds<S: Simd, const K: usize> {
    xy: AnyPower<S, K>,
    rz: AnyPower<S, K>,
    /// A bound on the error of the logarithm.
    tolerance: Lanes<S, K>,
    /// Where the powers are too small for f32.
    beyond_f32: Mask<S, K>,
}

impl<S: Simd, const K: usize> NormOfBounds<S, K> {
    #[inline(always)]
    fn new(p: Lanes<S, K>, q: Lanes<S, K>) -> Self {
        let (one, least) = (p.all(1.0), p.all(LEAST_POWER));
        let tolerance = p.all(LOGARITHM) * (one + one / p + one / q);
        let beyond_f32 = p.lt(least) | q.lt(least);
        Self { xy: AnyPower::new(p), rz: AnyPower::new(q), tolerance, beyond_f32 }
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

/// Lower bounds of |x|, |y| and |z|.
#[inline(always)]
fn reduced<S: Simd, const K: usize>(point: Triple<S, K>) -> Triple<S, K> {
    least_between(point, point)
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
}
