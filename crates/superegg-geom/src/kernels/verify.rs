//! Verification in f64 of facts that f32 has proved about first crossings, eight rays at a time, for shapes of any exponents.
//!
//! The functions are those of `solve/certified.rs`: on a stretch of a ray within one octant, `f = sign (R - C)` is a sum of two
//! terms, each convex or concave, so the derivatives at the ends bound that of f. Every value carries a bound on its rounding
//! error, and nothing is accepted within it. Plain loops over arrays, which the compiler vectorises.

use glam::DVec3;
use superegg_simd::power::{exp2, fma, log2};
use superegg_simd::{Arch, Simd, WithSimd};

use super::refine::{log_sum, log2_of_three};
use crate::math::ray::{Ray, RayStart};
use crate::shape::ShapeHit;
use crate::superquadric::Superquadric;

/// Rays that are verified together.
const WIDTH: usize = 8;
/// f may have a cusp on a coordinate plane: stretches that come closer to one are not verified.
const NEAR_PLANE: f64 = 1e-4;
/// Origins beyond this distance from the centre, along any axis, are not verified.
const FAR: f64 = 1024.0;
/// Powers outside of this range are not verified.
const POWERS: std::ops::RangeInclusive<f64> = 1.0 / 64.0..=1e4;
/// Where the slope of f changes by a larger factor, short steps of Newton's method do not prove that the root is close.
const MOST_BEND: f64 = 16.0;
/// The most steps of Newton's method.
const MOST_POLISH: usize = 6;
/// A step that is shorter, in widths of the interval, is the last one: Newton's method squares the relative error.
const LAST_STEP: f64 = 1e-8;
/// A bound on the relative change of the gradient in the last step, where the gradient is kept.
const SAME_GRADIENT: f64 = 1e-9;
/// Bound on the error of a logarithm of a coordinate, of a power and of a sum of two, relative to the result of the power.
/// Coordinates are in 1e-4..=2, so their logarithms are below 14.
const ROUNDING: f64 = 4e-14;
/// C and its derivative have too few digits where `1 - |z|^q` is smaller.
const LEAST_BELOW: f64 = 1e-9;

/// Eight numbers, one for each ray of a row.
type Row = [f64; WIDTH];

/// Rays with facts about their first crossings.
#[derive(Clone, Debug, Default)]
pub struct VerifyBatch {
    rays: Vec<Rays>,
    answers: Vec<Answers>,
    count: usize,
}

/// Eight rays in the spaces of their unit shapes.
#[derive(Clone, Copy, Debug)]
struct Rays {
    origin: [Row; 3],
    /// The points at the beginning of the intervals.
    base: [Row; 3],
    direction: [Row; 3],
    p: Row,
    q: Row,
    /// -1 for a ray that starts inside, 1 for the others.
    side: Row,
    /// The length of the first stretch, in t; 0 where its facts are not needed.
    first: Row,
    /// The t at the beginning of the interval.
    t: Row,
    /// The width of the interval, in t; 0 without one.
    width: Row,
    /// Bound on the relative error of coordinates.
    error: Row,
}

#[derive(Clone, Copy, Debug)]
struct Answers {
    /// 1 where the facts are verified, else 0.
    verified: Row,
    /// The crossing, from the beginning of the interval.
    step: Row,
    /// Where the gradient changes by no more than [`SAME_GRADIENT`] to the crossing, else 0.
    gradient: [Row; 3],
}

/// Facts about the first crossing of a ray with a shape that were proved in f32.
#[derive(Clone, Copy, Debug)]
pub struct KnownCrossing {
    /// From this t on there is no crossing before `between`. For a free ray it lies before the unit box; for one that starts
    /// on the surface, the stretch before it is not known.
    pub clear_from: f64,
    /// The ray is still on the side of its start at the first t, and on the other side at the second. `None` if it does not
    /// cross the surface after `clear_from`.
    pub between: Option<[f64; 2]>,
}

/// A verified crossing, and the gradient of N there if it is known.
pub type Verified = (ShapeHit, Option<DVec3>);

impl VerifyBatch {
    /// Removes all rays and keeps the memory.
    #[inline]
    pub fn clear(&mut self) {
        self.rays.clear();
        self.count = 0;
    }

    /// Adds a ray in the space of a unit shape, with facts about its first crossing. The ray starts on this surface, or it is free
    /// and starts outside. Returns its index.
    #[inline]
    pub fn push(&mut self, shape: &Superquadric, ray: &Ray, start: RayStart, known: &KnownCrossing) -> usize {
        let lane = self.count % WIDTH;
        if lane == 0 {
            self.rays.push(Rays::NONE);
        }
        if let Some(rays) = self.rays.last_mut() {
            let norm = shape.norm();
            let [begin, end] = known.between.unwrap_or([0.0; 2]);
            let begin = begin.max(0.0);
            let base = ray.origin + begin * ray.direction;
            for axis in 0..3 {
                rays.origin[axis][lane] = ray.origin[axis];
                rays.base[axis][lane] = base[axis];
                rays.direction[axis][lane] = ray.direction[axis];
            }
            (rays.p[lane], rays.q[lane]) = (norm.xy.p, norm.rz.p);
            rays.side[lane] = if start == RayStart::SurfaceInward { -1.0 } else { 1.0 };
            rays.first[lane] = if start == RayStart::Free { 0.0 } else { known.clear_from.max(0.0) };
            (rays.t[lane], rays.width[lane]) = (begin, end - begin);
            let size = ray.origin.abs().max_element();
            let is_possible = size <= FAR
                && POWERS.contains(&norm.xy.p)
                && POWERS.contains(&norm.rz.p)
                && (known.between.is_none() || end > begin);
            // Points on the ray lie in the unit box or close to it.
            let error = 4.0 * f64::EPSILON * (size + 2.0) / NEAR_PLANE;
            rays.error[lane] = if is_possible { error } else { f64::INFINITY };
        }
        self.count += 1;
        self.count - 1
    }

    /// Verifies all rays.
    pub fn run(&mut self) {
        self.answers.clear();
        Arch::new().dispatch(Kernel(self));
    }

    /// The crossing of ray `index`, or that there is none, after [`VerifyBatch::run`]. `None` where the facts cannot be verified:
    /// [`Superquadric::intersect`] finds the crossing then.
    #[inline]
    pub fn get(&self, index: usize) -> Option<Option<Verified>> {
        let (row, lane) = (index / WIDTH, index % WIDTH);
        let (answers, rays) = (self.answers.get(row)?, &self.rays[row]);
        if answers.verified[lane] != 1.0 {
            return None;
        }
        if rays.width[lane] <= 0.0 {
            return Some(None);
        }
        let vector = |columns: &[Row; 3]| DVec3::new(columns[0][lane], columns[1][lane], columns[2][lane]);
        let step = answers.step[lane];
        let point = vector(&rays.base) + step * vector(&rays.direction);
        let gradient = vector(&answers.gradient);
        let hit = ShapeHit { t: rays.t[lane] + step, point, leaving: rays.side[lane] < 0.0 };
        Some(Some((hit, (gradient != DVec3::ZERO).then_some(gradient))))
    }
}

impl Rays {
    const NONE: Self = Self {
        origin: [[1.0; WIDTH]; 3],
        base: [[1.0; WIDTH]; 3],
        direction: [[1.0; WIDTH]; 3],
        p: [1.0; WIDTH],
        q: [1.0; WIDTH],
        side: [1.0; WIDTH],
        first: [0.0; WIDTH],
        t: [0.0; WIDTH],
        width: [0.0; WIDTH],
        error: [f64::INFINITY; WIDTH],
    };
}

struct Kernel<'a>(&'a mut VerifyBatch);

impl WithSimd for Kernel<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let VerifyBatch { rays, answers, .. } = self.0;
        for rays in rays.iter() {
            answers.push(if S::IS_SCALAR { verify::<false>(rays) } else { verify::<true>(rays) });
        }
    }
}

/// The two terms of f and their derivatives at one parameter.
struct Samples {
    r: Row,
    c: Row,
    r_slope: Row,
    c_slope: Row,
    /// Bound on the error of f.
    error: Row,
    /// Bound on the error of the slope of f.
    slope_error: Row,
    /// The gradient of R - C.
    gradient: [Row; 3],
    /// A bound on the relative change of the gradient for a change of the parameter by 1.
    turn: Row,
}

#[inline(always)]
fn sample<const FUSED: bool>(rays: &Rays, from: &[Row; 3], at: &Row) -> Samples {
    let none = [0.0; WIDTH];
    let mut samples = Samples {
        r: none,
        c: none,
        r_slope: none,
        c_slope: none,
        error: none,
        slope_error: none,
        gradient: [none; 3],
        turn: none,
    };
    for i in 0..WIDTH {
        let (dx, dy, dz) = (rays.direction[0][i], rays.direction[1][i], rays.direction[2][i]);
        let x = fma::<FUSED>(at[i], dx, from[0][i]);
        let y = fma::<FUSED>(at[i], dy, from[1][i]);
        let z = fma::<FUSED>(at[i], dz, from[2][i]);
        let (ax, ay) = (at_least(x.abs()), at_least(y.abs()));
        let az = at_least(z.abs());
        let az = if az < 1.0 { az } else { 1.0 };
        let (p, q) = (rays.p[i], rays.q[i]);
        let powers = 1.0 / (p * q);
        let (inverse_p, inverse_q) = (powers * q, powers * p);
        let [log_x, log_y, log_z] = log2_of_three::<FUSED>([ax, ay, az]);
        let (log_r, of_x, of_y, sum) = log_sum::<FUSED>(log_x, log_y, (p, inverse_p));
        let r = exp2::<FUSED>(log_r);
        let power_z = exp2::<FUSED>(q * log_z);
        let below = 1.0 - power_z;
        let below = if below > LEAST_BELOW { below } else { LEAST_BELOW };
        let c = exp2::<FUSED>(log2::<FUSED>(below) * inverse_q);
        let (xy, zb) = (ax * ay * sum, az * below);
        let inverse = 1.0 / (xy * zb);
        let by_r = r * (inverse * zb);
        let (by_x, by_y) = (by_r * (of_x * ay), by_r * (of_y * ax));
        let by_z = c * power_z * (inverse * xy);
        let (gx, gy, gz) = (by_x.copysign(x), by_y.copysign(y), by_z.copysign(z));
        let (to_x, to_y, to_z) = (gx * dx, gy * dy, gz * dz);
        let side = rays.side[i];
        samples.r[i] = side * r;
        samples.c[i] = -side * c;
        samples.r_slope[i] = side * (to_x + to_y);
        samples.c_slope[i] = side * to_z;
        // A change of the coordinates by a factor changes R by no larger one. That of 1 - z^q changes by q z^q / (1 - z^q)
        // times as much, and C by the q-th root of that.
        let steep = inverse * xy * az;
        let unit = rays.error[i] + ROUNDING;
        let size = fma::<FUSED>(2.0 * c * steep, 1.0 + inverse_q, r * (1.0 + inverse_p));
        let is_below = power_z < 1.0 - 2.0 * LEAST_BELOW;
        samples.error[i] = if is_below { unit * size } else { f64::INFINITY };
        let slopes = to_x.abs() + to_y.abs() + to_z.abs();
        samples.slope_error[i] =
            8.0 * unit * (1.0 + p + inverse_p) * (1.0 + q + inverse_q) * (1.0 + steep) * slopes;
        (samples.gradient[0][i], samples.gradient[1][i], samples.gradient[2][i]) = (gx, gy, gz);
        let relative = (dx * ay).abs() + (dy * ax).abs();
        let relative = fma::<FUSED>(dz.abs(), inverse * xy * below, relative / (ax * ay));
        samples.turn[i] = relative * (1.0 + p + q) * (1.0 + inverse_p + inverse_q) * (1.0 + steep);
    }
    samples
}

/// The size of a coordinate, so far above 0 that divisors and logarithms stay finite.
#[inline(always)]
fn at_least(size: f64) -> f64 {
    const LEAST: f64 = 1e-30;
    if size > LEAST { size } else { LEAST }
}

/// The least and the greatest slope of f between two samples, as far as rounding lets them be known.
#[inline(always)]
fn slopes(rays: &Rays, low: &Samples, high: &Samples) -> (Row, Row) {
    let (mut least, mut greatest) = ([0.0; WIDTH], [0.0; WIDTH]);
    for i in 0..WIDTH {
        // R is convex for p >= 1, and -C for q >= 1; f is their sum, or its negative.
        let inward = rays.side[i] < 0.0;
        let r_is_convex = (rays.p[i] >= 1.0) != inward;
        let c_is_convex = (rays.q[i] >= 1.0) != inward;
        let (r_low, r_high) = (low.r_slope[i], high.r_slope[i]);
        let (c_low, c_high) = (low.c_slope[i], high.c_slope[i]);
        let error = low.slope_error[i] + high.slope_error[i];
        let least_r = if r_is_convex { r_low } else { r_high };
        let least_c = if c_is_convex { c_low } else { c_high };
        least[i] = least_r + least_c - error;
        let greatest_r = if r_is_convex { r_high } else { r_low };
        let greatest_c = if c_is_convex { c_high } else { c_low };
        greatest[i] = greatest_r + greatest_c + error;
    }
    (least, greatest)
}

/// 1 where the stretch from a point on lies within one octant and near no coordinate plane, else 0.
#[inline(always)]
fn within_octant(rays: &Rays, from: &[Row; 3], length: &Row) -> Row {
    let mut is_within = [1.0; WIDTH];
    for (from, direction) in from.iter().zip(&rays.direction) {
        for i in 0..WIDTH {
            let (begin, end) = (from[i], from[i] + length[i] * direction[i]);
            let is_far = begin.abs() >= NEAR_PLANE && end.abs() >= NEAR_PLANE && begin * end > 0.0;
            is_within[i] = if is_far { is_within[i] } else { 0.0 };
        }
    }
    is_within
}

#[inline(always)]
fn verify<const FUSED: bool>(rays: &Rays) -> Answers {
    let zero = [0.0; WIDTH];
    let mut verified = rays.error.map(|error| if error < f64::INFINITY { 1.0 } else { 0.0 });
    if rays.first != zero {
        // f does not fall on the first stretch.
        let (low, high) =
            (sample::<FUSED>(rays, &rays.origin, &zero), sample::<FUSED>(rays, &rays.origin, &rays.first));
        let (least, _) = slopes(rays, &low, &high);
        let is_within = within_octant(rays, &rays.origin, &rays.first);
        for i in 0..WIDTH {
            let is_known = low.error[i] + high.error[i] < f64::INFINITY;
            let is_clear = rays.first[i] <= 0.0 || (is_known && least[i] >= 0.0 && is_within[i] > 0.0);
            verified[i] = if is_clear { verified[i] } else { 0.0 };
        }
    }
    let mut answers = Answers { verified, step: zero, gradient: [zero; 3] };
    if rays.width != zero {
        find::<FUSED>(rays, &mut answers);
    }
    answers
}

/// Finds the roots of f in the intervals, if it falls all over them, nowhere much steeper than elsewhere, and changes sign.
#[inline(always)]
fn find<const FUSED: bool>(rays: &Rays, answers: &mut Answers) {
    let zero = [0.0; WIDTH];
    let (low, high) =
        (sample::<FUSED>(rays, &rays.base, &zero), sample::<FUSED>(rays, &rays.base, &rays.width));
    let (steepest, gentlest) = slopes(rays, &low, &high);
    let is_within = within_octant(rays, &rays.base, &rays.width);
    let mut state = [0.0; WIDTH];
    for i in 0..WIDTH {
        let width = rays.width[i];
        let (f_low, f_high) = (low.r[i] + low.c[i], high.r[i] + high.c[i]);
        let is_certain = f_low >= low.error[i]
            && f_high <= -high.error[i]
            && gentlest[i] < 0.0
            && steepest[i] >= MOST_BEND * gentlest[i]
            && is_within[i] > 0.0;
        answers.verified[i] = if is_certain || width <= 0.0 { answers.verified[i] } else { 0.0 };
        // Where s is the cubic of f with the values and the derivatives of both ends.
        let fall = f_low - f_high;
        let u = f_low / fall;
        let v = 1.0 - u;
        let at_low = -fall / (low.r_slope[i] + low.c_slope[i]);
        let at_high = -fall / (high.r_slope[i] + high.c_slope[i]);
        let start = u * u * (1.0 + 2.0 * v) * width + u * v * (v * at_low - u * at_high);
        answers.step[i] = if is_certain { within(start, width) } else { 0.0 };
        // Rays that are not verified need no steps.
        state[i] = if is_certain { 1.0 } else { 0.0 };
    }
    for _ in 0..MOST_POLISH {
        if state == zero {
            break;
        }
        let at = sample::<FUSED>(rays, &rays.base, &answers.step);
        for (i, state) in state.iter_mut().enumerate() {
            let (f, slope) = (at.r[i] + at.c[i], at.r_slope[i] + at.c_slope[i]);
            let step = -f / slope;
            let is_active = *state > 0.0;
            let is_last = step.abs() <= LAST_STEP * rays.width[i];
            let is_same = is_active && is_last && step.abs() * at.turn[i] <= SAME_GRADIENT;
            let next = within(answers.step[i] + step, rays.width[i]);
            for axis in 0..3 {
                let kept = answers.gradient[axis][i];
                answers.gradient[axis][i] = if is_same { at.gradient[axis][i] } else { kept };
            }
            answers.step[i] = if is_active { next } else { answers.step[i] };
            *state = if is_last { 0.0 } else { *state };
        }
    }
    for (verified, state) in answers.verified.iter_mut().zip(state) {
        *verified = if state > 0.0 { 0.0 } else { *verified };
    }
}

/// The part of a number in 0..=width.
#[inline(always)]
fn within(s: f64, width: f64) -> f64 {
    let s = if s > 0.0 { s } else { 0.0 };
    if s < width { s } else { width }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Exponents;
    use crate::math::random::SplitMix;

    const EXPONENTS: [f64; 8] = [0.01, 0.3, 1.0, 1.9, 2.0, 2.4, 4.0, 40.0];

    fn rows(mut value: impl FnMut() -> f64) -> Row {
        std::array::from_fn(|_| value())
    }

    fn rays(random: &mut SplitMix, e: f64, n: f64) -> Rays {
        let mut coordinates = || rows(|| (2.0 * random.unit() - 1.0).powi(3));
        let base = [coordinates(), coordinates(), coordinates()];
        let direction = [coordinates(), coordinates(), coordinates()];
        let (p, q) = ([2.0 / e; WIDTH], [2.0 / n; WIDTH]);
        Rays { origin: base, base, direction, p, q, error: [0.0; WIDTH], ..Rays::NONE }
    }

    /// f and its slope by the standard library, whose functions are right to the last digit.
    fn by_library(point: DVec3, direction: DVec3, p: f64, q: f64) -> (f64, f64) {
        let size = point.abs();
        let sum =
            |smaller: f64, larger: f64| ((p * (smaller / larger).ln()).exp().ln_1p() / p).exp() * larger;
        let r = sum(size.x.min(size.y), size.x.max(size.y));
        let below = -(q * size.z.ln()).exp_m1();
        let c = (below.ln() / q).exp();
        let by = |x: f64, dx: f64| r * (p * (x.abs() / r).ln()).exp() / x * dx;
        let by_z = c / below * (q * size.z.ln()).exp() / point.z * direction.z;
        (r - c, by(point.x, direction.x) + by(point.y, direction.y) + by_z)
    }

    #[test]
    fn errors_of_values_and_slopes_are_within_their_bounds() {
        let mut random = SplitMix::new(5);
        let mut compared = 0;
        for case in 0..64 * 200 {
            let (e, n) = (EXPONENTS[case % 8], EXPONENTS[case / 8 % 8]);
            let rays = rays(&mut random, e, n);
            for samples in [sample::<true>, sample::<false>].map(|of| of(&rays, &rays.base, &[0.0; WIDTH])) {
                for i in 0..WIDTH {
                    let vector = |columns: &[Row; 3]| DVec3::new(columns[0][i], columns[1][i], columns[2][i]);
                    let (point, direction) = (vector(&rays.base), vector(&rays.direction));
                    let is_near = point.abs().min_element() < NEAR_PLANE;
                    if is_near || samples.error[i].is_infinite() {
                        continue;
                    }
                    let (f, slope) = by_library(point, direction, rays.p[i], rays.q[i]);
                    let off = (samples.r[i] + samples.c[i] - f).abs();
                    assert!(off <= samples.error[i], "{e} {n} {point}: {off} {}", samples.error[i]);
                    let off = (samples.r_slope[i] + samples.c_slope[i] - slope).abs();
                    assert!(
                        off <= samples.slope_error[i],
                        "{e} {n} {point}: {off} {}",
                        samples.slope_error[i]
                    );
                    compared += 1;
                }
            }
        }
        assert!(compared > 100_000, "{compared}");
    }

    #[test]
    fn most_crossings_are_verified() {
        let mut random = SplitMix::new(6);
        let mut batch = VerifyBatch::default();
        let mut expected = Vec::new();
        for case in 0..64 * 200 {
            let (e, n) = (EXPONENTS[case % 8], EXPONENTS[case / 8 % 8]);
            let shape = Superquadric::unit(Exponents::new(e, n).unwrap());
            let mut vector = || DVec3::from_array(std::array::from_fn(|_| 2.0 * random.unit() - 1.0));
            let origin = 3.0 * vector().normalize();
            let ray = Ray::new(origin, 0.3 * vector() - origin);
            let Some(hit) = shape.intersect(&ray, RayStart::Free).filter(|hit| !hit.leaving) else {
                continue;
            };
            let between = Some([hit.t - 1e-3 * random.unit(), hit.t + 1e-3 * random.unit()]);
            batch.push(&shape, &ray, RayStart::Free, &KnownCrossing { clear_from: 0.0, between });
            expected.push((shape, ray, hit));
        }
        batch.run();
        let mut verified = 0;
        for (index, (shape, ray, hit)) in expected.iter().enumerate() {
            let Some(found) = batch.get(index) else { continue };
            let (found, gradient) = found.unwrap();
            verified += 1;
            assert!((found.t - hit.t).abs() < 1e-12 && !found.leaving, "{shape:?} {ray:?} {found:?} {hit:?}");
            assert!((found.point - hit.point).length() < 1e-11);
            let off =
                gradient.map_or(0.0, |gradient| (gradient.normalize() - shape.normal(found.point)).length());
            assert!(off < 1e-8, "{shape:?} {ray:?} {off}");
        }
        assert!(expected.len() > 5000 && verified * 10 > expected.len() * 7, "{verified} {}", expected.len());
    }
}
