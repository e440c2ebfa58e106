//! N for any two powers, by logarithms. One evaluation takes three logarithms of coordinates, two of sums, two powers of
//! two and one reciprocal.

use superegg_simd::{Lanes, Simd, Triple};

use super::curve::{Curve, EvaluateNorm, Slope, ValueAndGradient};

/// Lower bound of |coordinate|: derivatives are divided by it.
const LEAST: f32 = 1e-12;

/// The derivatives of a norm M of two numbers a and b, scaled to avoid divisions:
/// `(log M)' = (of_a da + of_b db) / sum` and `M'' = M bend ((a db - b da) / sum)^2`.
pub(crate) struct Derivatives<S: Simd, const K: usize> {
    of_a: Lanes<S, K>,
    of_b: Lanes<S, K>,
    sum: Lanes<S, K>,
    bend: Lanes<S, K>,
}

/// The norm R of x and y, by its logarithm.
pub(crate) trait LogRadius<S: Simd, const K: usize>: Copy {
    /// log2 R and its derivatives, for x, y > 0.
    fn evaluate(self, x: Lanes<S, K>, y: Lanes<S, K>) -> (Lanes<S, K>, Derivatives<S, K>);
}

/// A power p >= 1 for each lane.
#[derive(Clone, Copy)]
pub(crate) struct AnyPower<S: Simd, const K: usize> {
    p: Lanes<S, K>,
    inv_p: Lanes<S, K>,
}

impl<S: Simd, const K: usize> AnyPower<S, K> {
    #[inline(always)]
    pub(crate) fn new(p: Lanes<S, K>) -> Self {
        Self { p, inv_p: p.all(1.0) / p }
    }

    /// `log (a^p + b^p)^(1/p)` from log a and log b, as `(max + log(1 + w)) / p` with `w = 2^-|p log a - p log b|`. The
    /// derivatives are those by log a and log b.
    #[inline(always)]
    fn log_sum(self, log_a: Lanes<S, K>, log_b: Lanes<S, K>) -> (Lanes<S, K>, Derivatives<S, K>) {
        let one = self.p.all(1.0);
        let (log, w) = self.log_sum_and_ratio(log_a, log_b);
        let a_is_larger = (self.p * log_b).le(self.p * log_a);
        let (of_a, of_b) = (a_is_larger.select(one, w), a_is_larger.select(w, one));
        (log, Derivatives { of_a, of_b, sum: w + one, bend: (self.p - one) * w })
    }

    /// The logarithm of [`AnyPower::log_sum`], for any p > 0, and w.
    #[inline(always)]
    pub(crate) fn log_sum_and_ratio(
        self,
        log_a: Lanes<S, K>,
        log_b: Lanes<S, K>,
    ) -> (Lanes<S, K>, Lanes<S, K>) {
        let (a, b) = (self.p * log_a, self.p * log_b);
        // 2^-60 vanishes beside 1, and its products are not subnormal: those take many times as long.
        let w = (-(a - b).abs()).max(a.all(-60.0)).exp2_quick();
        ((a.max(b) + w.log2_of_one_plus()) * self.inv_p, w)
    }
}

impl<S: Simd, const K: usize> LogRadius<S, K> for AnyPower<S, K> {
    #[inline(always)]
    fn evaluate(self, x: Lanes<S, K>, y: Lanes<S, K>) -> (Lanes<S, K>, Derivatives<S, K>) {
        let (log, Derivatives { of_a, of_b, sum, bend }) = self.log_sum(x.log2_quick(), y.log2_quick());
        (log, Derivatives { of_a: of_a * y, of_b: of_b * x, sum: sum * (x * y), bend })
    }
}

/// p = 2: one logarithm in place of three.
#[derive(Clone, Copy)]
pub(crate) struct Round;

impl<S: Simd, const K: usize> LogRadius<S, K> for Round {
    #[inline(always)]
    fn evaluate(self, x: Lanes<S, K>, y: Lanes<S, K>) -> (Lanes<S, K>, Derivatives<S, K>) {
        let square = x.mul_add(x, y * y);
        (square.log2_quick() * x.all(0.5), Derivatives { of_a: x, of_b: y, sum: square, bend: x.all(1.0) })
    }
}

/// N with any power q outside, and a norm in x and y inside.
#[derive(Clone, Copy)]
pub(crate) struct LogNorm<S: Simd, X, const K: usize> {
    xy: X,
    rz: AnyPower<S, K>,
}

impl<S: Simd, X: LogRadius<S, K>, const K: usize> LogNorm<S, X, K> {
    #[inline(always)]
    pub(crate) fn new(xy: X, q: Lanes<S, K>) -> Self {
        Self { xy, rz: AnyPower::new(q) }
    }
}

/// Two numbers whose quotient is (N - level) / N, from log2 N and a level near 1. The first is t = ln (N / level); the
/// second is `1 + t/2 + t^2/12`: `t / (1 + t/2 + t^2/12)` exceeds 1 - e^-t by less than 2e-4 of its size for |t| <= 1/2.
#[inline(always)]
fn excess<S: Simd, const K: usize>(log_n: Lanes<S, K>, level: Lanes<S, K>) -> (Lanes<S, K>, Lanes<S, K>) {
    let over = level - level.all(1.0);
    let ln_level = over.mul_add(level.all(1.0 / 3.0), level.all(-0.5)).mul_add(over, level.all(1.0)) * over;
    let t = log_n.mul_add(level.all(std::f32::consts::LN_2), -ln_level);
    let divisor = t.mul_add(level.all(1.0 / 12.0), level.all(0.5)).mul_add(t, level.all(1.0));
    (t, divisor)
}

impl<S: Simd, X: LogRadius<S, K>, const K: usize> EvaluateNorm<S, K> for LogNorm<S, X, K> {
    #[inline(always)]
    fn slope(self, point: Triple<S, K>, direction: Triple<S, K>, level: Lanes<S, K>) -> Slope<S, K> {
        let curve = self.curve(point, direction, level);
        Slope { excess: curve.excess, inv_slope: curve.inv_slope() }
    }

    /// Let u and v be the slopes of log R and log z, and a and b = 1 - a their shares in N^q. Then `(log N)' = a u + b v` and
    /// `N''/N = a R''/R + (q - 1) a b (u - v)^2`. All denominators are multiplied together, so that a step needs few
    /// divisions.
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
    fn value_and_gradient(self, point: Triple<S, K>) -> ValueAndGradient<S, K> {
        let least = point.x.all(LEAST);
        let (x, y, z) = (point.x.abs().max(least), point.y.abs().max(least), point.z.abs().max(least));
        let (log_r, Derivatives { of_a: of_x, of_b: of_y, sum: of_xy, .. }) = self.xy.evaluate(x, y);
        let (log_n, Derivatives { of_a: of_r, of_b: of_z, sum, .. }) = self.rz.log_sum(log_r, z.log2_quick());
        let (norm, of_r) = (log_n.exp2(), of_r * z);
        let gradient = Triple {
            x: (of_r * of_x).times_sign_of(point.x),
            y: (of_r * of_y).times_sign_of(point.y),
            z: (of_z * of_xy).times_sign_of(point.z),
        };
        // `gradient / scale` is the gradient of log N, which is that of N where N is 1.
        ValueAndGradient { norm, gradient, scale: sum * z * of_xy }
    }
}
