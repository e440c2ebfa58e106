//! N for any two powers, in logarithms: three of coordinates, two of sums, a power of two at the end, and one reciprocal.

use pulp::Simd;

use super::kernel::{Curve, Descent, Evaluate, Rise, Triple};
use super::vector::Lanes;

/// A coordinate is at least this: its derivative is divided by it.
const LEAST: f32 = 1e-12;
/// The derivative of a norm's logarithm is `(of_a da + of_b db) / sum`, and the second derivative of the norm is the norm times
/// `bend ((a db - b da) / sum)^2`.
pub(super) struct Parts<S: Simd, const K: usize> {
    of_a: Lanes<S, K>,
    of_b: Lanes<S, K>,
    sum: Lanes<S, K>,
    bend: Lanes<S, K>,
}

/// The norm in x and y, by logarithms.
pub(super) trait LogRadius<S: Simd, const K: usize>: Copy {
    /// The logarithm of R, and what its derivatives are made of. For x, y > 0.
    fn evaluate(self, x: Lanes<S, K>, y: Lanes<S, K>) -> (Lanes<S, K>, Parts<S, K>);
}

/// Any p >= 1, one for each lane.
#[derive(Clone, Copy)]
pub(super) struct AnyPower<S: Simd, const K: usize> {
    p: Lanes<S, K>,
    inverse: Lanes<S, K>,
}

impl<S: Simd, const K: usize> AnyPower<S, K> {
    #[inline(always)]
    pub(super) fn new(p: Lanes<S, K>) -> Self {
        Self { p, inverse: p.all(1.0) / p }
    }

    /// `log (a^p + b^p)^(1/p)` from the logarithms of a and b, by (max + log(1 + w)) / p with w = 2^-|p log a - p log b|; and the parts of its
    /// derivatives by those logarithms.
    #[inline(always)]
    fn log_sum(self, log_a: Lanes<S, K>, log_b: Lanes<S, K>) -> (Lanes<S, K>, Parts<S, K>) {
        let one = self.p.all(1.0);
        let (a, b) = (self.p * log_a, self.p * log_b);
        // What is nothing beside 1 stays large enough that products of it are no subnormal numbers, which take many times as long.
        let w = (-(a - b).abs()).max(one.all(-60.0)).exp2_quick();
        let log = (a.max(b) + w.log2_of_one_plus()) * self.inverse;
        let a_is_larger = b.le(a);
        let (of_a, of_b) = (a_is_larger.select(one, w), a_is_larger.select(w, one));
        (log, Parts { of_a, of_b, sum: w + one, bend: (self.p - one) * w })
    }
}

impl<S: Simd, const K: usize> LogRadius<S, K> for AnyPower<S, K> {
    #[inline(always)]
    fn evaluate(self, x: Lanes<S, K>, y: Lanes<S, K>) -> (Lanes<S, K>, Parts<S, K>) {
        let (log, Parts { of_a, of_b, sum, bend }) = self.log_sum(x.log2_quick(), y.log2_quick());
        (log, Parts { of_a: of_a * y, of_b: of_b * x, sum: sum * (x * y), bend })
    }
}

/// p = 2.
#[derive(Clone, Copy)]
pub(super) struct Round;

impl<S: Simd, const K: usize> LogRadius<S, K> for Round {
    #[inline(always)]
    fn evaluate(self, x: Lanes<S, K>, y: Lanes<S, K>) -> (Lanes<S, K>, Parts<S, K>) {
        let square = x.mul_add(x, y * y);
        (square.log2_quick() * x.all(0.5), Parts { of_a: x, of_b: y, sum: square, bend: x.all(1.0) })
    }
}

/// N with a norm in x and y within any other.
#[derive(Clone, Copy)]
pub(super) struct LogNorm<S: Simd, X, const K: usize> {
    xy: X,
    rz: AnyPower<S, K>,
}

impl<S: Simd, X: LogRadius<S, K>, const K: usize> LogNorm<S, X, K> {
    #[inline(always)]
    pub(super) fn new(xy: X, q: Lanes<S, K>) -> Self {
        Self { xy, rz: AnyPower::new(q) }
    }
}

/// Two numbers whose quotient is (N - level) / N, from N's logarithm and a level near 1. The first is t = ln (N / level): 1 - e^-t is
/// t / (1 + t/2 + t^2/12), or larger in size by less than 2e-4 of itself for t from -1/2 to 1/2.
#[inline(always)]
fn excess<S: Simd, const K: usize>(log_n: Lanes<S, K>, level: Lanes<S, K>) -> (Lanes<S, K>, Lanes<S, K>) {
    let over = level - level.all(1.0);
    let ln_level = over.mul_add(level.all(1.0 / 3.0), level.all(-0.5)).mul_add(over, level.all(1.0)) * over;
    let t = log_n.mul_add(level.all(std::f32::consts::LN_2), -ln_level);
    let divisor = t.mul_add(level.all(1.0 / 12.0), level.all(0.5)).mul_add(t, level.all(1.0));
    (t, divisor)
}

impl<S: Simd, X: LogRadius<S, K>, const K: usize> Evaluate<S, K> for LogNorm<S, X, K> {
    #[inline(always)]
    fn descent(self, point: Triple<S, K>, direction: Triple<S, K>, level: Lanes<S, K>) -> Descent<S, K> {
        let curve = self.curve(point, direction, level);
        Descent { excess: curve.excess, way: curve.way() }
    }

    /// With u and v the slopes of the logarithms of R and z: log N rises by the mean of u and v by their shares, and
    /// N'' / N = share of R * R'' / R + (q - 1) * both shares * (u - v)^2. All denominators are multiplied together, so that a step takes few divisions.
    #[inline(always)]
    fn curve(self, point: Triple<S, K>, direction: Triple<S, K>, level: Lanes<S, K>) -> Curve<S, K> {
        let least = level.all(LEAST);
        let (x, y, z) = (point.x.abs().max(least), point.y.abs().max(least), point.z.abs().max(least));
        let (log_r, xy) = self.xy.evaluate(x, y);
        let (log_n, rz) = self.rz.log_sum(log_r, z.log2_quick());
        let to_x = direction.x.times_sign_of(point.x);
        let to_y = direction.y.times_sign_of(point.y);
        let to_z = direction.z.times_sign_of(point.z);
        let radial = xy.of_a.mul_add(to_x, xy.of_b * to_y);
        let (of_r, sum) = (rz.of_a * z, rz.sum * z);
        let slope = of_r.mul_add(radial, rz.of_b * to_z * xy.sum);
        let turn = to_x.mul_add(y, -(to_y * x));
        let tilt = radial.mul_add(z, -(to_z * xy.sum));
        let bend = (of_r * sum * xy.bend).mul_add(turn * turn, rz.bend * (tilt * tilt));
        let (excess, divisor) = excess(log_n, level);
        Curve { excess, scale: sum * xy.sum, slope: slope * divisor, bend: bend * divisor }
    }

    #[inline(always)]
    fn rise(self, point: Triple<S, K>) -> Rise<S, K> {
        let least = point.x.all(LEAST);
        let (x, y, z) = (point.x.abs().max(least), point.y.abs().max(least), point.z.abs().max(least));
        let (log_r, Parts { of_a: of_x, of_b: of_y, sum: of_xy, .. }) = self.xy.evaluate(x, y);
        let (log_n, Parts { of_a: of_r, of_b: of_z, sum, .. }) = self.rz.log_sum(log_r, z.log2_quick());
        let (norm, of_r) = (log_n.exp2(), of_r * z);
        let gradient = Triple {
            x: (of_r * of_x).times_sign_of(point.x),
            y: (of_r * of_y).times_sign_of(point.y),
            z: (of_z * of_xy).times_sign_of(point.z),
        };
        // The gradient of log N is this by that product, and N times it the one of N, which is about 1.
        Rise { norm, gradient, scale: sum * z * of_xy }
    }
}
