//! Refinement in f64 of crossings that f32 found: Newton's method on log N, eight rays at a time.
//!
//! Plain loops over arrays, which the compiler vectorises where they are inlined for the lanes of the machine.

use glam::DVec3;
use superegg_simd::{Arch, Simd, WithSimd};

use crate::shape::ShapeHit;
use crate::superquadric::Superquadric;

/// Rays that are refined together.
const WIDTH: usize = 8;
/// Steps from a good guess; grazing rays need more and stay unrefined.
const MAX_STEPS: usize = 7;
/// The rounding error of N in f64, with a margin.
const CLOSE: f64 = 8e-15;
/// Lower bound of |coordinate|: derivatives are divided by it.
const LEAST: f64 = 1e-90;
/// Shapes of larger powers are equal to that of this one in f64.
const MAX_POWER: f64 = 1e15;

/// Eight numbers, one for each ray of a row.
type Row = [f64; WIDTH];

/// Rays with guesses of t, in the spaces of their convex unit shapes.
#[derive(Clone, Debug, Default)]
pub struct RefineBatch {
    /// The points at the guesses, then the directions.
    rays: Vec<[Row; 6]>,
    /// t, p and q.
    guesses: Vec<[Row; 3]>,
    count: usize,
    answers: Vec<Answer>,
}

/// A ray with a guess of its first crossing.
#[derive(Clone, Copy, Debug)]
pub struct RefineRay {
    /// In the space of the unit shape: outside of its box, at most some thousand radii away.
    pub origin: DVec3,
    /// In the same space, of any length.
    pub direction: DVec3,
    /// The guess, in lengths of the direction.
    pub t: f64,
    /// The powers of the shape, by [`refine_powers`].
    pub powers: [f64; 2],
}

/// The powers p and q of a convex shape.
pub fn refine_powers(shape: &Superquadric) -> [f64; 2] {
    let norm = shape.norm();
    [norm.xy.p.min(MAX_POWER), norm.rz.p.min(MAX_POWER)]
}

/// A refined crossing, and the gradient of N there.
pub type Refined = (ShapeHit, DVec3);

#[derive(Clone, Copy, Debug)]
struct Answer {
    /// The correction of t.
    step: Row,
    gradient: [Row; 3],
    state: [State; WIDTH],
}

/// How far the refinement of a ray is. As wide as f64, so that states are lanes beside the numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u64)]
enum State {
    Active,
    Converged,
    Failed,
}

impl RefineBatch {
    /// Removes all rays and keeps the memory.
    pub fn clear(&mut self) {
        self.rays.clear();
        self.guesses.clear();
        self.answers.clear();
        self.count = 0;
    }

    /// Adds a ray with a guess, and returns its index.
    #[inline]
    pub fn push(&mut self, ray: &RefineRay) -> usize {
        let lane = self.count % WIDTH;
        if lane == 0 {
            self.rays.push([[1.0; WIDTH]; 6]);
            self.guesses.push([[1.0; WIDTH]; 3]);
        }
        if let (Some(rays), Some(guesses)) = (self.rays.last_mut(), self.guesses.last_mut()) {
            // Measured from the guess, N is exact to the last digits.
            let base = ray.origin + ray.t * ray.direction;
            for axis in 0..3 {
                rays[axis][lane] = base[axis];
                rays[axis + 3][lane] = ray.direction[axis];
            }
            (guesses[0][lane], guesses[1][lane], guesses[2][lane]) = (ray.t, ray.powers[0], ray.powers[1]);
        }
        self.count += 1;
        self.count - 1
    }

    /// Refines all rays.
    pub fn run(&mut self) {
        let empty = Answer { step: [0.0; WIDTH], gradient: [[0.0; WIDTH]; 3], state: [State::Failed; WIDTH] };
        self.answers.resize(self.rays.len(), empty);
        Arch::new().dispatch(Kernel(self));
    }

    /// The crossing of ray `index`, after [`RefineBatch::run`]. `None` where it is not proved that the crossing exists and is
    /// the first one; [`Superquadric::intersect`] decides those.
    #[inline]
    pub fn get(&self, index: usize) -> Option<Refined> {
        let (row, lane) = (index / WIDTH, index % WIDTH);
        let (answer, ray) = (self.answers.get(row)?, &self.rays[row]);
        let step = answer.step[lane];
        let vector = |columns: &[Row]| DVec3::new(columns[0][lane], columns[1][lane], columns[2][lane]);
        let point = vector(&ray[..3]) + step * vector(&ray[3..]);
        let t = self.guesses[row][0][lane] + step;
        let is_refined = answer.state[lane] == State::Converged && t >= 0.0 && point.is_finite();
        is_refined.then(|| (ShapeHit { t, point, leaving: false }, vector(&answer.gradient)))
    }
}

struct Kernel<'a>(&'a mut RefineBatch);

impl WithSimd for Kernel<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let RefineBatch { rays, guesses, answers, .. } = self.0;
        for ((ray, guess), answer) in rays.iter().zip(guesses).zip(answers) {
            *answer = if S::IS_SCALAR { refine::<false>(ray, guess) } else { refine::<true>(ray, guess) };
        }
    }
}

/// Newton's method on log N, which has the zero of N - 1. A point where N is 1 and falls is the first crossing, because N is
/// convex.
#[inline(always)]
fn refine<const FUSED: bool>(ray: &[Row; 6], guess: &[Row; 3]) -> Answer {
    let mut step = [0.0; WIDTH];
    let mut state = [State::Active; WIDTH];
    let mut gradient = [[0.0; WIDTH]; 3];
    let mut scale = [1.0; WIDTH];
    let mut inverse = [[0.0; WIDTH]; 2];
    for i in 0..WIDTH {
        (inverse[0][i], inverse[1][i]) = (1.0 / guess[1][i], 1.0 / guess[2][i]);
    }
    for _ in 0..MAX_STEPS {
        for i in 0..WIDTH {
            let (dx, dy, dz) = (ray[3][i], ray[4][i], ray[5][i]);
            let x = fma::<FUSED>(step[i], dx, ray[0][i]);
            let y = fma::<FUSED>(step[i], dy, ray[1][i]);
            let z = fma::<FUSED>(step[i], dz, ray[2][i]);
            let (p, q) = ((guess[1][i], inverse[0][i]), (guess[2][i], inverse[1][i]));
            let at = evaluate::<FUSED>(x, y, z, p, q);
            let [by_x, by_y, by_z] = at.gradient;
            let slope = by_x * dx + by_y * dy + by_z * dz;
            let next = -at.log * at.scale / slope;
            // The error of N after this step is half of N'' times its length squared. N'' is below p in a norm of power
            // p >= 2, and below 1 / (least coordinate) in one of a smaller power.
            let length = next.abs() * (dx.abs() + dy.abs() + dz.abs());
            let bend = 4.0 * (p.0 + q.0 + 1.0 / at.least);
            let is_close = slope < 0.0 && (bend * length * length <= CLOSE || at.log.abs() <= CLOSE);
            let can_step = slope < 0.0 && next.abs() < f64::INFINITY;
            let is_active = state[i] == State::Active;
            let converges = is_active && is_close;
            let fails = is_active && !is_close && !can_step;
            let steps = is_active && !fails;
            gradient[0][i] = if converges { by_x } else { gradient[0][i] };
            gradient[1][i] = if converges { by_y } else { gradient[1][i] };
            gradient[2][i] = if converges { by_z } else { gradient[2][i] };
            scale[i] = if converges { at.scale } else { scale[i] };
            step[i] = if steps { step[i] + next } else { step[i] };
            state[i] = if converges { State::Converged } else { state[i] };
            state[i] = if fails { State::Failed } else { state[i] };
        }
        if state.iter().all(|&state| state != State::Active) {
            break;
        }
    }
    for i in 0..WIDTH {
        let inverse = 1.0 / scale[i];
        for column in &mut gradient {
            column[i] *= inverse;
        }
    }
    Answer { step, gradient, state }
}

/// `a * b + c`, fused where the machine can.
#[inline(always)]
fn fma<const FUSED: bool>(a: f64, b: f64, c: f64) -> f64 {
    if FUSED { a.mul_add(b, c) } else { a * b + c }
}

/// N at a point.
struct LogNorm {
    /// ln N.
    log: f64,
    /// The gradient of ln N, times `scale`.
    gradient: [f64; 3],
    scale: f64,
    /// The least |coordinate|.
    least: f64,
}

/// The formulas of [`super::norm`]'s logarithmic evaluator, in f64. The powers come with their reciprocals.
#[inline(always)]
fn evaluate<const FUSED: bool>(x: f64, y: f64, z: f64, p: (f64, f64), q: (f64, f64)) -> LogNorm {
    let sizes = [x.abs(), y.abs(), z.abs()].map(|x| if x > LEAST { x } else { LEAST });
    let [ax, ay, az] = sizes;
    // One division for the three logarithms.
    let [(kx, mx), (ky, my), (kz, mz)] =
        [exponent_and_mantissa(ax), exponent_and_mantissa(ay), exponent_and_mantissa(az)];
    let (sx, sy, sz) = (mx + 1.0, my + 1.0, mz + 1.0);
    let sxy = sx * sy;
    let inverse = 1.0 / (sxy * sz);
    let (inverse_z, inverse_xy) = (inverse * sxy, inverse * sz);
    let log_x = log2_of::<FUSED>(kx, (mx - 1.0) * (inverse_xy * sy));
    let log_y = log2_of::<FUSED>(ky, (my - 1.0) * (inverse_xy * sx));
    let log_z = log2_of::<FUSED>(kz, (mz - 1.0) * inverse_z);
    let (log_r, of_x, of_y, sum) = log_sum::<FUSED>(log_x, log_y, p);
    let (log, of_r, of_z, sum_z) = log_sum::<FUSED>(log_r, log_z, q);
    let xy = ax * ay * sum;
    let rz = of_r * az;
    LogNorm {
        log: log * std::f64::consts::LN_2,
        gradient: [(rz * of_x * ay).copysign(x), (rz * of_y * ax).copysign(y), (of_z * xy).copysign(z)],
        scale: sum_z * az * xy,
        least: if ax < ay {
            if ax < az { ax } else { az }
        } else if ay < az {
            ay
        } else {
            az
        },
    }
}

/// log2 of `(a^p + b^p)^(1/p)` from log2 a and log2 b, the weights of a and b in its derivative, and the sum by which the
/// weights are to be divided.
#[inline(always)]
fn log_sum<const FUSED: bool>(log_a: f64, log_b: f64, (p, inverse_p): (f64, f64)) -> (f64, f64, f64, f64) {
    let (larger, smaller) = if log_a >= log_b { (log_a, log_b) } else { (log_b, log_a) };
    let w = exp2::<FUSED>(p * (smaller - larger));
    let (of_a, of_b) = if log_a >= log_b { (1.0, w) } else { (w, 1.0) };
    let sum = 1.0 + w;
    (fma::<FUSED>(log2::<FUSED>(sum), inverse_p, larger), of_a, of_b, sum)
}

/// k and m of x = 2^k m with m in [sqrt 1/2, sqrt 2), for a normal x.
#[inline(always)]
fn exponent_and_mantissa(x: f64) -> (f64, f64) {
    const TO_ROOT: u64 = 0x3ff0_0000_0000_0000 - 0x3fe6_a09e_667f_3bcd;
    let k = x.to_bits().wrapping_add(TO_ROOT) >> 52;
    let m = f64::from_bits(x.to_bits().wrapping_sub(k << 52).wrapping_add(0x3ff0_0000_0000_0000));
    // Converts k to f64: these are the bits of 2^52 + k.
    (f64::from_bits(k | 0x4330_0000_0000_0000) - (4_503_599_627_370_496.0 + 1023.0), m)
}

/// `k + log2 m` for s = (m - 1) / (m + 1), |s| < 0.172: (2 / ln 2) artanh s.
#[inline(always)]
fn log2_of<const FUSED: bool>(k: f64, s: f64) -> f64 {
    let z = s * s;
    // 1/3 + z/5 + ... + z^10/23, by pairs.
    let pair = |odd: f64| fma::<FUSED>(z, 1.0 / (odd + 2.0), 1.0 / odd);
    let z2 = z * z;
    let z4 = z2 * z2;
    let low = fma::<FUSED>(pair(7.0), z2, pair(3.0));
    let middle = fma::<FUSED>(pair(15.0), z2, pair(11.0));
    let high = fma::<FUSED>(z2, 1.0 / 23.0, pair(19.0));
    let series = fma::<FUSED>(fma::<FUSED>(high, z4, middle), z4, low);
    let tail = s * z * series;
    fma::<FUSED>(2.0 * std::f64::consts::LOG2_E, s + tail, k)
}

/// log2 x of a normal x > 0, to a few units of the last place of the result, or to 1e-16.
#[inline(always)]
fn log2<const FUSED: bool>(x: f64) -> f64 {
    let (k, m) = exponent_and_mantissa(x);
    log2_of::<FUSED>(k, (m - 1.0) / (m + 1.0))
}

/// 2^x for x <= 1000, to a few units of the last place; 2^-1000 for x < -1000.
#[inline(always)]
fn exp2<const FUSED: bool>(x: f64) -> f64 {
    let x = if x > -1000.0 { x } else { -1000.0 };
    // Adding 1.5 * 2^52 leaves the nearest integer in the low bits.
    let magic = 6_755_399_441_055_744.0;
    let whole = x + magic;
    let f = (x - (whole - magic)) * std::f64::consts::LN_2;
    // The series of e^f, by pairs of terms.
    let pair = |a: f64, b: f64| fma::<FUSED>(f, b, a);
    let f2 = f * f;
    let f4 = f2 * f2;
    let low = fma::<FUSED>(pair(1.0 / 24.0, 1.0 / 120.0), f2, pair(0.5, 1.0 / 6.0));
    let middle = fma::<FUSED>(pair(1.0 / 40_320.0, 1.0 / 362_880.0), f2, pair(1.0 / 720.0, 1.0 / 5_040.0));
    let high = fma::<FUSED>(
        pair(1.0 / 479_001_600.0, 1.0 / 6_227_020_800.0),
        f2,
        pair(1.0 / 3_628_800.0, 1.0 / 39_916_800.0),
    );
    let series = fma::<FUSED>(fma::<FUSED>(high, f4, middle), f4, low);
    let series = fma::<FUSED>(series, f2, f) + 1.0;
    f64::from_bits(series.to_bits().wrapping_add(whole.to_bits() << 52))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Ray;

    #[test]
    fn powers_agree_with_the_standard_library() {
        for i in 1..200_000 {
            let x = f64::from(i) * 1e-5;
            assert!((log2::<true>(x) - x.log2()).abs() <= 7e-16 * x.log2().abs().max(0.5), "{x}");
            let y = f64::from(i - 100_000) * 0.009;
            assert!((exp2::<true>(y) / y.exp2() - 1.0).abs() < 1e-15, "{y}");
        }
        assert_eq!((log2::<false>(1.0), exp2::<false>(0.0)), (0.0, 1.0));
        assert_eq!(exp2::<true>(-5e5), exp2::<false>(-1000.0));
    }

    #[test]
    fn refines_to_the_crossings_of_the_scalar_path() {
        let mut batch = RefineBatch::default();
        let mut expected = Vec::new();
        for i in 0..4000 {
            let a = f64::from(i);
            let exponents =
                crate::Exponents::new(0.1 + 0.19 * f64::from(i % 11), 0.05 + 0.13 * f64::from(i % 16))
                    .unwrap();
            let shape = Superquadric::unit(exponents);
            let origin = DVec3::new(a.sin(), (1.7 * a).cos(), (0.3 * a).sin()).normalize() * (2.0 + 0.01 * a);
            let target = 0.6 * DVec3::new((2.1 * a).sin(), (0.9 * a).sin(), (1.3 * a).cos());
            let ray = Ray::new(origin, (target - origin).normalize());
            if let Some(hit) = shape.intersect(&ray, crate::RayStart::Free) {
                let t = hit.t + 1e-7 * a.cos();
                let powers = refine_powers(&shape);
                batch.push(&RefineRay { origin: ray.origin, direction: ray.direction, t, powers });
                expected.push((shape, hit));
            }
        }
        batch.run();
        assert!(expected.len() > 2000);
        let mut unrefined = 0;
        for (i, (shape, hit)) in expected.iter().enumerate() {
            let Some((refined, gradient)) = batch.get(i) else {
                unrefined += 1;
                continue;
            };
            assert!((refined.t - hit.t).abs() < 1e-11 * hit.t, "{refined:?} {hit:?}");
            let normal = shape.normal(hit.point);
            assert!(normal.dot(gradient.normalize()) > 1.0 - 1e-9, "{normal} {gradient}");
        }
        assert!(unrefined < 40, "{unrefined}");
    }
}
