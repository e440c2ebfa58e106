//! N for any two powers, in logarithms: three of coordinates, two of sums, and one power of two at the end.

use pulp::Simd;

use super::kernel::{Evaluate, Triple};
use super::vector::Lanes;

/// A coordinate is at least this: its derivative is divided by it.
const LEAST: f32 = 1e-12;

/// The two powers with their reciprocals.
#[derive(Clone, Copy)]
pub(super) struct LogNorm<S: Simd> {
    p: Lanes<S>,
    q: Lanes<S>,
    inverse_p: Lanes<S>,
    inverse_q: Lanes<S>,
}

impl<S: Simd> LogNorm<S> {
    #[inline(always)]
    pub(super) fn new(p: Lanes<S>, q: Lanes<S>) -> Self {
        let one = p.all(1.0);
        Self { p, q, inverse_p: one / p, inverse_q: one / q }
    }
}

impl<S: Simd> Evaluate<S> for LogNorm<S> {
    /// With a = p log|x| and b = p log|y|: log R = (max(a, b) + log(1 + w)) / p, w = 2^-|a - b|; the same again with q for R and z. The derivative of
    /// log N is that of each logarithm times the shares 1 / (1 + w) and w / (1 + w).
    #[inline(always)]
    fn evaluate(self, point: Triple<S>, direction: Triple<S>) -> (Lanes<S>, Lanes<S>) {
        let least = self.p.all(LEAST);
        let (x, y, z) = (point.x.abs().max(least), point.y.abs().max(least), point.z.abs().max(least));
        let (a, b) = (self.p * x.log2_quick(), self.p * y.log2_quick());
        let (w, sum) = two_to_minus_difference(a, b);
        let log_r = (a.max(b) + w.log2_of_one_plus()) * self.inverse_p;
        let (c, d) = (self.q * log_r, self.q * z.log2_quick());
        let (v, sum_z) = two_to_minus_difference(c, d);
        let norm = ((c.max(d) + v.log2_of_one_plus()) * self.inverse_q).exp2();

        // All five reciprocals by two divisions.
        let one = self.p.all(1.0);
        let both = one / (sum * sum_z);
        let (larger_xy, larger_rz) = (both * sum_z, both * sum);
        let (smaller_xy, smaller_rz) = (larger_xy * w, larger_rz * v);
        let x_is_larger = b.le(a);
        let (share_x, share_y) =
            (x_is_larger.select(larger_xy, smaller_xy), x_is_larger.select(smaller_xy, larger_xy));
        let r_is_larger = d.le(c);
        let (share_r, share_z) =
            (r_is_larger.select(larger_rz, smaller_rz), r_is_larger.select(smaller_rz, larger_rz));
        let (yz, xz, xy) = (y * z, x * z, x * y);
        let inverse = one / (x * yz);
        let of_x = share_x * yz * direction.x.times_sign_of(point.x);
        let of_y = share_y * xz * direction.y.times_sign_of(point.y);
        let of_z = share_z * xy * direction.z.times_sign_of(point.z);
        let slope = share_r.mul_add(of_x + of_y, of_z) * inverse * norm;
        (norm, slope)
    }
}

/// `w = 2^-|a - b|`, and 1 + w.
#[inline(always)]
fn two_to_minus_difference<S: Simd>(a: Lanes<S>, b: Lanes<S>) -> (Lanes<S>, Lanes<S>) {
    let w = (-(a - b).abs()).exp2();
    (w, w + w.all(1.0))
}
