//! Crossings that f32 has found, settled in f64 by Newton's method, eight at a time.
//!
//! Plain loops over arrays, which the compiler turns into lanes where they are inlined for a machine that has them.

use glam::DVec3;
use pulp::{Arch, Simd, WithSimd};

use crate::shape::ShapeHit;
use crate::superquadric::Superquadric;

/// Rays that are settled together.
const WIDTH: usize = 8;
/// From a good guess so many steps suffice, but for grazing rays.
const MOST_STEPS: usize = 7;
/// N is known to this in f64, with room.
const CLOSE: f64 = 8e-15;
/// A coordinate is at least this: its derivative is divided by it.
const LEAST: f64 = 1e-90;
/// Larger powers cannot be told from it.
const MOST_POWER: f64 = 1e15;

type Eight = [f64; WIDTH];

/// Rays with guesses, in the spaces of their convex unit shapes.
#[derive(Clone, Debug, Default)]
pub struct SettleBatch {
    rays: Vec<[Eight; 6]>,
    guesses: Vec<[Eight; 3]>,
    count: usize,
    answers: Vec<Answer>,
}

/// A ray to be settled.
#[derive(Clone, Copy, Debug)]
pub struct SettleRay {
    /// In the space of the unit shape: outside of its box, and not more than some thousand radii away.
    pub origin: DVec3,
    /// In the same space.
    pub direction: DVec3,
    /// Where the crossing was found.
    pub t: f64,
    /// The shape's, by [`settle_powers`].
    pub powers: [f64; 2],
}

/// The powers of a convex shape.
pub fn settle_powers(shape: &Superquadric) -> [f64; 2] {
    let norm = shape.norm();
    [norm.xy.p.min(MOST_POWER), norm.rz.p.min(MOST_POWER)]
}

/// A crossing with the gradient of N there.
pub type Settled = (ShapeHit, DVec3);

#[derive(Clone, Copy, Debug)]
struct Answer {
    /// From the guess on.
    step: Eight,
    gradient: [Eight; 3],
    /// 1 where it is settled.
    done: Eight,
}

impl SettleBatch {
    /// Forgets all, and keeps the memory.
    pub fn clear(&mut self) {
        self.rays.clear();
        self.guesses.clear();
        self.answers.clear();
        self.count = 0;
    }

    /// Adds a ray that was found to cross a shape near `t`. Returns its place.
    #[inline]
    pub fn push(&mut self, ray: &SettleRay) -> usize {
        let lane = self.count % WIDTH;
        if lane == 0 {
            self.rays.push([[1.0; WIDTH]; 6]);
            self.guesses.push([[1.0; WIDTH]; 3]);
        }
        if let (Some(rays), Some(guesses)) = (self.rays.last_mut(), self.guesses.last_mut()) {
            // From a place so near N can be told to the last digits.
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

    /// Settles all.
    pub fn run(&mut self) {
        let empty = Answer { step: [0.0; WIDTH], gradient: [[0.0; WIDTH]; 3], done: [0.0; WIDTH] };
        self.answers.resize(self.rays.len(), empty);
        Arch::new().dispatch(Kernel(self));
    }

    /// The answer for a place; `None` where it could not be proven that the crossing is there and is the first, which
    /// [`Superquadric::intersect`] then knows.
    #[inline]
    pub fn get(&self, place: usize) -> Option<Settled> {
        let (row, lane) = (place / WIDTH, place % WIDTH);
        let (answer, ray) = (self.answers.get(row)?, &self.rays[row]);
        let step = answer.step[lane];
        let vector = |columns: &[Eight]| DVec3::new(columns[0][lane], columns[1][lane], columns[2][lane]);
        let point = vector(&ray[..3]) + step * vector(&ray[3..]);
        let t = self.guesses[row][0][lane] + step;
        let is_settled = answer.done[lane] == 1.0 && t >= 0.0 && point.is_finite();
        is_settled.then(|| (ShapeHit { t, point, leaving: false }, vector(&answer.gradient)))
    }
}

struct Kernel<'a>(&'a mut SettleBatch);

impl WithSimd for Kernel<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let SettleBatch { rays, guesses, answers, .. } = self.0;
        for ((ray, guess), answer) in rays.iter().zip(guesses).zip(answers) {
            *answer = if S::IS_SCALAR { settle::<false>(ray, guess) } else { settle::<true>(ray, guess) };
        }
    }
}

/// Where N is 1 and falls is the first crossing, by convexity. Newton's method on log N, whose zero is the same, goes to it from near by.
#[inline(always)]
fn settle<const FUSED: bool>(ray: &[Eight; 6], guess: &[Eight; 3]) -> Answer {
    let mut step = [0.0; WIDTH];
    // 0: on its way; 1: arrived; 2: given up.
    let mut state = [0.0; WIDTH];
    let mut slopes = [[0.0; WIDTH]; 3];
    let mut above = [1.0; WIDTH];
    let mut inverse = [[0.0; WIDTH]; 2];
    for i in 0..WIDTH {
        (inverse[0][i], inverse[1][i]) = (1.0 / guess[1][i], 1.0 / guess[2][i]);
    }
    for _ in 0..MOST_STEPS {
        for i in 0..WIDTH {
            let (dx, dy, dz) = (ray[3][i], ray[4][i], ray[5][i]);
            let x = fma::<FUSED>(step[i], dx, ray[0][i]);
            let y = fma::<FUSED>(step[i], dy, ray[1][i]);
            let z = fma::<FUSED>(step[i], dz, ray[2][i]);
            let (p, q) = ((guess[1][i], inverse[0][i]), (guess[2][i], inverse[1][i]));
            let place = evaluate::<FUSED>(x, y, z, p, q);
            let [of_x, of_y, of_z] = place.slopes;
            let slope = of_x * dx + of_y * dy + of_z * dz;
            let next = -place.log * place.above / slope;
            // What N is off by after this step: half of its second derivative, which is below p in a norm of power p >= 2 and below the reciprocal of
            // the least coordinate in one of a lesser power, times the square of the way.
            let way = next.abs() * (dx.abs() + dy.abs() + dz.abs());
            let bend = 4.0 * (p.0 + q.0 + 1.0 / place.least);
            let arrives = slope < 0.0 && (bend * way * way <= CLOSE || place.log.abs() <= CLOSE);
            let goes_on = slope < 0.0 && next.abs() < f64::INFINITY;
            let is_open = state[i] == 0.0;
            let arrives_now = is_open && arrives;
            let gives_up = is_open && !arrives && !goes_on;
            let moves = is_open && !gives_up;
            slopes[0][i] = if arrives_now { of_x } else { slopes[0][i] };
            slopes[1][i] = if arrives_now { of_y } else { slopes[1][i] };
            slopes[2][i] = if arrives_now { of_z } else { slopes[2][i] };
            above[i] = if arrives_now { place.above } else { above[i] };
            step[i] = if moves { step[i] + next } else { step[i] };
            state[i] = if arrives_now { 1.0 } else { state[i] };
            state[i] = if gives_up { 2.0 } else { state[i] };
        }
        if state.iter().all(|&state| state != 0.0) {
            break;
        }
    }
    let mut answer = Answer { step, gradient: slopes, done: [0.0; WIDTH] };
    for i in 0..WIDTH {
        let inverse = 1.0 / above[i];
        for column in &mut answer.gradient {
            column[i] *= inverse;
        }
        answer.done[i] = if state[i] == 1.0 { 1.0 } else { 0.0 };
    }
    answer
}

/// `a * b + c`, in one step where the machine has it.
#[inline(always)]
fn fma<const FUSED: bool>(a: f64, b: f64, c: f64) -> f64 {
    if FUSED { a.mul_add(b, c) } else { a * b + c }
}

/// N at a place.
struct Place {
    /// log2 N.
    log: f64,
    /// The gradient of log N, all multiplied by `above` (and log N by ln 2).
    slopes: [f64; 3],
    above: f64,
    /// The least coordinate.
    least: f64,
}

/// As in `log_norm.rs`; the powers with their reciprocals.
#[inline(always)]
fn evaluate<const FUSED: bool>(x: f64, y: f64, z: f64, p: (f64, f64), q: (f64, f64)) -> Place {
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
    Place {
        log: log * std::f64::consts::LN_2,
        slopes: [(rz * of_x * ay).copysign(x), (rz * of_y * ax).copysign(y), (of_z * xy).copysign(z)],
        above: sum_z * az * xy,
        least: if ax < ay {
            if ax < az { ax } else { az }
        } else if ay < az {
            ay
        } else {
            az
        },
    }
}

/// The logarithm of `(a^p + b^p)^(1/p)` from those of a and b, and the parts that each has in its derivative, both to be divided by the last.
#[inline(always)]
fn log_sum<const FUSED: bool>(log_a: f64, log_b: f64, (p, inverse_p): (f64, f64)) -> (f64, f64, f64, f64) {
    let (larger, smaller) = if log_a >= log_b { (log_a, log_b) } else { (log_b, log_a) };
    let w = exp2::<FUSED>(p * (smaller - larger));
    let (of_a, of_b) = if log_a >= log_b { (1.0, w) } else { (w, 1.0) };
    let sum = 1.0 + w;
    (fma::<FUSED>(log2::<FUSED>(sum), inverse_p, larger), of_a, of_b, sum)
}

/// x = 2^k m with m in [sqrt 1/2, sqrt 2), for a normal x: k and m.
#[inline(always)]
fn exponent_and_mantissa(x: f64) -> (f64, f64) {
    const TO_ROOT: u64 = 0x3ff0_0000_0000_0000 - 0x3fe6_a09e_667f_3bcd;
    let k = x.to_bits().wrapping_add(TO_ROOT) >> 52;
    let m = f64::from_bits(x.to_bits().wrapping_sub(k << 52).wrapping_add(0x3ff0_0000_0000_0000));
    // k as a number: the bits of 2^52 + k.
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

/// The base-2 logarithm of a normal x > 0, to a few units of the last place of the result or of 1e-16.
#[inline(always)]
fn log2<const FUSED: bool>(x: f64) -> f64 {
    let (k, m) = exponent_and_mantissa(x);
    log2_of::<FUSED>(k, (m - 1.0) / (m + 1.0))
}

/// 2^x for x <= 1000, to a few units of the last place; from -1000 down that of -1000.
#[inline(always)]
fn exp2<const FUSED: bool>(x: f64) -> f64 {
    let x = if x > -1000.0 { x } else { -1000.0 };
    // Adding 1.5 * 2^52 leaves the nearest whole number in the low bits.
    let magic = 6_755_399_441_055_744.0;
    let whole = x + magic;
    let f = (x - (whole - magic)) * std::f64::consts::LN_2;
    // e^f: 1 / n! for n from 2 on, by pairs.
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
    fn powers_are_those_of_the_library() {
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
    fn settles_where_the_scalar_path_does() {
        let mut batch = SettleBatch::default();
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
                let powers = settle_powers(&shape);
                batch.push(&SettleRay { origin: ray.origin, direction: ray.direction, t, powers });
                expected.push((shape, hit));
            }
        }
        batch.run();
        assert!(expected.len() > 2000);
        let mut unsettled = 0;
        for (i, (shape, hit)) in expected.iter().enumerate() {
            let Some((settled, gradient)) = batch.get(i) else {
                unsettled += 1;
                continue;
            };
            assert!((settled.t - hit.t).abs() < 1e-11 * hit.t, "{settled:?} {hit:?}");
            let normal = shape.normal(hit.point);
            assert!(normal.dot(gradient.normalize()) > 1.0 - 1e-9, "{normal} {gradient}");
        }
        assert!(unsettled < 40, "{unsettled}");
    }
}
