//! The values of N that a search along a ray needs at a point, and the trait of its evaluators.

use superegg_simd::{Lanes, Simd, Triple};

/// Closeness of N to the level at which a search stops: a few units of the last place of f32 at 1.
pub(crate) const CLOSE: f32 = 3e-7;
/// Replaces zero in a denominator.
pub(crate) const TINY: f32 = 1e-30;
/// Shortens a step by more than the error of a fast reciprocal.
const SHORT: f32 = 1.0 - 1e-4;

/// N and its slope along a ray, as a step of Newton's method needs them.
#[derive(Clone, Copy)]
pub(crate) struct Slope<S: Simd, const K: usize = 1> {
    /// N - level, absolute or as a part of N: near the level the two agree.
    pub(crate) excess: Lanes<S, K>,
    /// 1 / N', negative where N falls. Newton's step is `-excess * inv_slope`.
    pub(crate) inv_slope: Lanes<S, K>,
}

/// N and its first two derivatives along the ray, scaled so that no division is needed:
/// `slope = N'/N * scale * c`, `bend = N''/N * scale^2 * c`, where the factor c, also in `excess`, is near 1 where N is.
#[derive(Clone, Copy)]
pub(crate) struct Curve<S: Simd, const K: usize = 1> {
    /// As in [`Slope`].
    pub(crate) excess: Lanes<S, K>,
    /// The scale, > 0.
    pub(crate) scale: Lanes<S, K>,
    /// The scaled slope.
    pub(crate) slope: Lanes<S, K>,
    /// The scaled second derivative, >= 0.
    pub(crate) bend: Lanes<S, K>,
}

impl<S: Simd, const K: usize> Curve<S, K> {
    /// As in [`Slope`], shortened so that no step overshoots.
    #[inline(always)]
    pub(crate) fn inv_slope(self) -> Lanes<S, K> {
        let Self { scale, slope, .. } = self;
        let inverse = slope.abs().max(slope.all(TINY)).with_sign_of(slope).recip_rough();
        scale * inverse * slope.all(SHORT)
    }
}

/// N and its gradient at a point.
#[derive(Clone, Copy)]
pub(crate) struct ValueAndGradient<S: Simd, const K: usize = 1> {
    pub(crate) norm: Lanes<S, K>,
    /// The gradient of N, times `scale`.
    pub(crate) gradient: Triple<S, K>,
    /// The scale, > 0.
    pub(crate) scale: Lanes<S, K>,
}

/// An evaluator of N.
pub(crate) trait EvaluateNorm<S: Simd, const K: usize = 1>: Copy {
    /// N and its slope at a point along a direction.
    fn slope(self, point: Triple<S, K>, direction: Triple<S, K>, level: Lanes<S, K>) -> Slope<S, K>;

    /// N and its first two derivatives at a point along a direction.
    fn curve(self, point: Triple<S, K>, direction: Triple<S, K>, level: Lanes<S, K>) -> Curve<S, K>;

    /// N and its gradient at a point.
    fn value_and_gradient(self, point: Triple<S, K>) -> ValueAndGradient<S, K>;
}
