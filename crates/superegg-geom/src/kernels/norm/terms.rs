//! Norms of two numbers with closed forms, and N as one such norm of another.

use superegg_simd::{Lanes, Simd, Triple};

use super::curve::{Curve, EvaluateNorm, Slope, TINY, ValueAndGradient};

/// A norm of two numbers.
pub(crate) trait Norm2<S: Simd, const K: usize = 1>: Copy {
    /// `|(a, b)|` and its derivatives by a and b, for a, b >= 0.
    fn value_and_gradient(self, a: Lanes<S, K>, b: Lanes<S, K>) -> (Lanes<S, K>, Lanes<S, K>, Lanes<S, K>);
}

/// A norm of two numbers with its second derivative.
pub(crate) trait BendingNorm2<S: Simd, const K: usize = 1>: Norm2<S, K> {
    /// The second derivative along a direction, at a point where the norm is `value`.
    fn bend(self, value: Lanes<S, K>, point: [Lanes<S, K>; 2], direction: [Lanes<S, K>; 2]) -> Lanes<S, K>;
}

/// p = 2: `sqrt(a^2 + b^2)`.
#[derive(Clone, Copy)]
pub(crate) struct Square;

impl<S: Simd, const K: usize> Norm2<S, K> for Square {
    #[inline(always)]
    fn value_and_gradient(self, a: Lanes<S, K>, b: Lanes<S, K>) -> (Lanes<S, K>, Lanes<S, K>, Lanes<S, K>) {
        let value = a.mul_add(a, b * b).sqrt();
        let inverse = a.all(1.0) / value.max(a.all(TINY));
        (value, a * inverse, b * inverse)
    }
}

impl<S: Simd, const K: usize> BendingNorm2<S, K> for Square {
    /// `(a db - b da)^2 / value^3`.
    #[inline(always)]
    fn bend(
        self,
        value: Lanes<S, K>,
        [a, b]: [Lanes<S, K>; 2],
        [to_a, to_b]: [Lanes<S, K>; 2],
    ) -> Lanes<S, K> {
        let inverse = value.max(value.all(TINY)).recip_rough();
        let turn = a.mul_add(to_b, -(b * to_a)) * inverse;
        turn * turn * inverse
    }
}

/// p = 1: `a + b`.
#[derive(Clone, Copy)]
pub(crate) struct Sum;

impl<S: Simd, const K: usize> Norm2<S, K> for Sum {
    #[inline(always)]
    fn value_and_gradient(self, a: Lanes<S, K>, b: Lanes<S, K>) -> (Lanes<S, K>, Lanes<S, K>, Lanes<S, K>) {
        (a + b, a.all(1.0), a.all(1.0))
    }
}

impl<S: Simd, const K: usize> BendingNorm2<S, K> for Sum {
    #[inline(always)]
    fn bend(self, value: Lanes<S, K>, _: [Lanes<S, K>; 2], _: [Lanes<S, K>; 2]) -> Lanes<S, K> {
        value.all(0.0)
    }
}

/// N as the norm (R, z) of the norm R = (x, y).
#[derive(Clone, Copy)]
pub(crate) struct Nested<X, Z>(pub(crate) X, pub(crate) Z);

impl<S: Simd, X: BendingNorm2<S, K>, Z: BendingNorm2<S, K>, const K: usize> EvaluateNorm<S, K>
    for Nested<X, Z>
{
    #[inline(always)]
    fn slope(self, point: Triple<S, K>, direction: Triple<S, K>, level: Lanes<S, K>) -> Slope<S, K> {
        let (value, slope) = evaluate(self.0, self.1, point, direction);
        Slope { excess: value - level, inv_slope: level.all(1.0) / slope }
    }

    #[inline(always)]
    fn curve(self, point: Triple<S, K>, direction: Triple<S, K>, level: Lanes<S, K>) -> Curve<S, K> {
        let (x, y, z) = (point.x.abs(), point.y.abs(), point.z.abs());
        let to_x = direction.x.times_sign_of(point.x);
        let to_y = direction.y.times_sign_of(point.y);
        let to_z = direction.z.times_sign_of(point.z);
        let (r, by_x, by_y) = self.0.value_and_gradient(x, y);
        let (norm, by_r, by_z) = self.1.value_and_gradient(r, z);
        let to_r = by_x.mul_add(to_x, by_y * to_y);
        let slope = by_r.mul_add(to_r, by_z * to_z);
        let bend =
            by_r.mul_add(self.0.bend(r, [x, y], [to_x, to_y]), self.1.bend(norm, [r, z], [to_r, to_z]));
        Curve { excess: norm - level, scale: level.all(1.0), slope, bend }
    }

    #[inline(always)]
    fn value_and_gradient(self, point: Triple<S, K>) -> ValueAndGradient<S, K> {
        let (r, by_x, by_y) = self.0.value_and_gradient(point.x.abs(), point.y.abs());
        let (norm, by_r, by_z) = self.1.value_and_gradient(r, point.z.abs());
        let gradient = Triple {
            x: (by_r * by_x).times_sign_of(point.x),
            y: (by_r * by_y).times_sign_of(point.y),
            z: by_z.times_sign_of(point.z),
        };
        ValueAndGradient { norm, gradient, scale: norm.all(1.0) }
    }
}

/// N at a point, and its derivative along a direction.
#[inline(always)]
fn evaluate<S: Simd, const K: usize>(
    xy: impl Norm2<S, K>,
    rz: impl Norm2<S, K>,
    point: Triple<S, K>,
    direction: Triple<S, K>,
) -> (Lanes<S, K>, Lanes<S, K>) {
    let (r, by_x, by_y) = xy.value_and_gradient(point.x.abs(), point.y.abs());
    let (norm, by_r, by_z) = rz.value_and_gradient(r, point.z.abs());
    // d|x|/ds = dx sign x.
    let radial =
        (by_x * direction.x).mul_add(point.x.with_unit_sign(), by_y * direction.y * point.y.with_unit_sign());
    (norm, by_r.mul_add(radial, by_z * direction.z * point.z.with_unit_sign()))
}
