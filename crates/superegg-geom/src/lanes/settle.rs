//! Crossings that f32 has found, settled in f64 by Newton's method, eight at a time.
//!
//! Plain loops over arrays, which the compiler turns into lanes where they are inlined for a machine that has them.

use glam::DVec3;
use pulp::{Arch, Simd, WithSimd};

use crate::ray::Ray;
use crate::superquadric::{ShapeHit, Superquadric};

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

    /// Adds a ray in the space of its unit shape, from outside and not more than some thousand radii away, that was found to cross the shape near
    /// `t`. Returns its place.
    pub fn push(&mut self, shape: &Superquadric, ray: &Ray, t: f64) -> usize {
        let lane = self.count % WIDTH;
        if lane == 0 {
            self.rays.push([[1.0; WIDTH]; 6]);
            self.guesses.push([[1.0; WIDTH]; 3]);
        }
        if let (Some(rays), Some(guesses)) = (self.rays.last_mut(), self.guesses.last_mut()) {
            // From a place so near N can be told to the last digits.
            let base = ray.origin + t * ray.direction;
            for axis in 0..3 {
                rays[axis][lane] = base[axis];
                rays[axis + 3][lane] = ray.direction[axis];
            }
            let norm = shape.norm();
            let numbers = [t, norm.xy.p.min(MOST_POWER), norm.rz.p.min(MOST_POWER)];
            for (column, number) in guesses.iter_mut().zip(numbers) {
                column[lane] = number;
            }
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
            *answer = settle(ray, guess);
        }
    }
}

/// Where N is 1 and falls is the first crossing, by convexity. From wherever N falls Newton's method goes to it, at most one step past it.
#[inline(always)]
fn settle(ray: &[Eight; 6], guess: &[Eight; 3]) -> Answer {
    let mut answer = Answer { step: [0.0; WIDTH], gradient: [[0.0; WIDTH]; 3], done: [0.0; WIDTH] };
    // 0: on its way; 1: arrived; 2: given up.
    let mut state = [0.0; WIDTH];
    for _ in 0..MOST_STEPS {
        let mut point = [[0.0; WIDTH]; 3];
        for axis in 0..3 {
            for i in 0..WIDTH {
                point[axis][i] = ray[axis][i] + answer.step[i] * ray[axis + 3][i];
            }
        }
        let (value, gradient) = evaluate(&point, &guess[1], &guess[2]);
        for i in 0..WIDTH {
            let above = value[i] - 1.0;
            let slope = gradient[0][i] * ray[3][i] + gradient[1][i] * ray[4][i] + gradient[2][i] * ray[5][i];
            let next = answer.step[i] - above / slope;
            let arrives = above.abs() <= CLOSE && slope < 0.0;
            let goes_on = slope < 0.0 && next.abs() < f64::INFINITY;
            let old = state[i];
            state[i] = if old != 0.0 {
                old
            } else if arrives {
                1.0
            } else if goes_on {
                0.0
            } else {
                2.0
            };
            let arrives_now = old == 0.0 && arrives;
            for (kept, new) in answer.gradient.iter_mut().zip(&gradient) {
                kept[i] = if arrives_now { new[i] } else { kept[i] };
            }
            // The last step goes on from where N is as good as 1.
            let moves = state[i] == 0.0 || arrives_now;
            answer.step[i] = if moves { next } else { answer.step[i] };
        }
        if state.iter().all(|&state| state != 0.0) {
            break;
        }
    }
    answer.done = state.map(|state| if state == 1.0 { 1.0 } else { 0.0 });
    answer
}

/// N and its gradient, by logarithms as in `log_norm.rs`.
#[inline(always)]
fn evaluate(point: &[Eight; 3], p: &Eight, q: &Eight) -> (Eight, [Eight; 3]) {
    let mut value = [0.0; WIDTH];
    let mut gradient = [[0.0; WIDTH]; 3];
    for i in 0..WIDTH {
        let at = |axis: usize| {
            let x = point[axis][i].abs();
            if x > LEAST { x } else { LEAST }
        };
        let (x, y, z) = (at(0), at(1), at(2));
        let (log_r, share_x, share_y) = log_sum(log2(x), log2(y), p[i]);
        let (log_n, share_r, share_z) = log_sum(log_r, log2(z), q[i]);
        let norm = exp2(log_n);
        value[i] = norm;
        gradient[0][i] = (norm * share_r * share_x / x).copysign(point[0][i]);
        gradient[1][i] = (norm * share_r * share_y / y).copysign(point[1][i]);
        gradient[2][i] = (norm * share_z / z).copysign(point[2][i]);
    }
    (value, gradient)
}

/// The logarithm of `(a^p + b^p)^(1/p)` from those of a and b, and the shares that each has in its derivative.
#[inline(always)]
fn log_sum(log_a: f64, log_b: f64, p: f64) -> (f64, f64, f64) {
    let (larger, smaller) = if log_a >= log_b { (log_a, log_b) } else { (log_b, log_a) };
    let w = exp2(p * (smaller - larger));
    let sum = 1.0 + w;
    let share = 1.0 / sum;
    let (of_a, of_b) = if log_a >= log_b { (share, w * share) } else { (w * share, share) };
    (larger + log2(sum) / p, of_a, of_b)
}

/// The base-2 logarithm of a normal x > 0, to a few units of the last place of the result or of 1e-16.
#[inline(always)]
fn log2(x: f64) -> f64 {
    const TO_ROOT: u64 = 0x3ff0_0000_0000_0000 - 0x3fe6_a09e_667f_3bcd;
    let shifted = x.to_bits().wrapping_add(TO_ROOT);
    let k = shifted >> 52;
    let m = f64::from_bits(x.to_bits().wrapping_sub(k << 52).wrapping_add(0x3ff0_0000_0000_0000));
    // k as a number: the bits of 2^52 + k.
    let k = f64::from_bits(k | 0x4330_0000_0000_0000) - (4_503_599_627_370_496.0 + 1023.0);
    // log2 m = (2 / ln 2) artanh s, |s| < 0.172.
    let s = (m - 1.0) / (m + 1.0);
    let z = s * s;
    let mut series = 1.0 / 23.0;
    for odd in [21.0, 19.0, 17.0, 15.0, 13.0, 11.0, 9.0, 7.0, 5.0, 3.0] {
        series = series * z + 1.0 / odd;
    }
    let tail = s * z * series;
    2.0 * std::f64::consts::LOG2_E * (s + tail) + k
}

/// 2^x for x <= 1000, to a few units of the last place; from -1000 down that of -1000.
#[inline(always)]
fn exp2(x: f64) -> f64 {
    let x = if x > -1000.0 { x } else { -1000.0 };
    // Adding 1.5 * 2^52 leaves the nearest whole number in the low bits.
    let magic = 6_755_399_441_055_744.0;
    let whole = x + magic;
    let f = (x - (whole - magic)) * std::f64::consts::LN_2;
    let mut series = 1.0;
    for n in [14.0, 13.0, 12.0, 11.0, 10.0, 9.0, 8.0, 7.0, 6.0, 5.0, 4.0, 3.0, 2.0] {
        series = series * f * (1.0 / n) + 1.0;
    }
    let series = series * f + 1.0;
    f64::from_bits(series.to_bits().wrapping_add(whole.to_bits() << 52))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn powers_are_those_of_the_library() {
        for i in 1..200_000 {
            let x = f64::from(i) * 1e-5;
            assert!((log2(x) - x.log2()).abs() <= 7e-16 * x.log2().abs().max(0.5), "{x}");
            let y = f64::from(i - 100_000) * 0.009;
            assert!((exp2(y) / y.exp2() - 1.0).abs() < 1e-15, "{y}");
        }
        assert_eq!((log2(1.0), exp2(0.0), exp2(-5e5)), (0.0, 1.0, exp2(-1000.0)));
    }

    #[test]
    fn settles_where_the_scalar_path_does() {
        let mut batch = SettleBatch::default();
        let mut expected = Vec::new();
        for i in 0..4000 {
            let a = f64::from(i);
            let exponents =
                crate::Exponents { e: 0.1 + 0.19 * f64::from(i % 11), n: 0.05 + 0.13 * f64::from(i % 16) };
            let shape = Superquadric::unit(exponents);
            let origin = DVec3::new(a.sin(), (1.7 * a).cos(), (0.3 * a).sin()).normalize() * (2.0 + 0.01 * a);
            let target = 0.6 * DVec3::new((2.1 * a).sin(), (0.9 * a).sin(), (1.3 * a).cos());
            let ray = Ray::new(origin, (target - origin).normalize());
            if let Some(hit) = shape.intersect(&ray, crate::RayStart::Free) {
                batch.push(&shape, &ray, hit.t + 1e-7 * a.cos());
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
