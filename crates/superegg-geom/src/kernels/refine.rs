//! Refinement in f64 of crossings that f32 found: Newton's method on log N, eight rays at a time.
//!
//! Plain loops over arrays, which the compiler vectorises where they are inlined for the lanes of the machine.

use glam::DVec3;
use superegg_simd::power::{exp2, exponent_and_mantissa, fma, log2, log2_of};
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

/// The logarithms to base 2 of three numbers, with one division.
#[inline(always)]
pub(super) fn log2_of_three<const FUSED: bool>(sizes: [f64; 3]) -> [f64; 3] {
    let [(kx, mx), (ky, my), (kz, mz)] = sizes.map(exponent_and_mantissa);
    let (sx, sy, sz) = (mx + 1.0, my + 1.0, mz + 1.0);
    let sxy = sx * sy;
    let inverse = 1.0 / (sxy * sz);
    let (inverse_z, inverse_xy) = (inverse * sxy, inverse * sz);
    [
        log2_of::<FUSED>(kx, (mx - 1.0) * (inverse_xy * sy)),
        log2_of::<FUSED>(ky, (my - 1.0) * (inverse_xy * sx)),
        log2_of::<FUSED>(kz, (mz - 1.0) * inverse_z),
    ]
}

/// The formulas of [`super::norm`]'s logarithmic evaluator, in f64. The powers come with their reciprocals.
#[inline(always)]
fn evaluate<const FUSED: bool>(x: f64, y: f64, z: f64, p: (f64, f64), q: (f64, f64)) -> LogNorm {
    let sizes = [x.abs(), y.abs(), z.abs()].map(|x| if x > LEAST { x } else { LEAST });
    let [ax, ay, az] = sizes;
    let [log_x, log_y, log_z] = log2_of_three::<FUSED>(sizes);
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
pub(super) fn log_sum<const FUSED: bool>(
    log_a: f64,
    log_b: f64,
    (p, inverse_p): (f64, f64),
) -> (f64, f64, f64, f64) {
    let (larger, smaller) = if log_a >= log_b { (log_a, log_b) } else { (log_b, log_a) };
    let w = exp2::<FUSED>(p * (smaller - larger));
    let (of_a, of_b) = if log_a >= log_b { (1.0, w) } else { (w, 1.0) };
    let sum = 1.0 + w;
    (fma::<FUSED>(log2::<FUSED>(sum), inverse_p, larger), of_a, of_b, sum)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Ray;

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
