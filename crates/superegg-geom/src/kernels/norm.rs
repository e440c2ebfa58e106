//! N and its derivatives in lanes. `curve` has the results and the trait that searches use, `terms` the norms with closed
//! forms (p = 1, p = 2), `log` the norms of any power.

mod curve;
mod log;
mod terms;

use superegg_simd::{Lanes, Simd};

pub(super) use curve::{CLOSE, Curve, EvaluateNorm, Slope, TINY, ValueAndGradient};
pub(super) use log::{AnyPower, LogNorm};

use self::log::Round;
use self::terms::{Nested, Square, Sum};
use super::powers::PowerKind;

/// The box [-1, 1]^3 is enlarged by this factor, for the rounding of crossings with its faces.
pub(super) const BOX: f32 = 1.0 + 1e-6;

/// The range of squared lengths of normals whose roots and reciprocals f32 holds.
pub(super) const SQUARES: [f32; 2] = [1e-30, 1e30];

/// How many registers a search works on at once. The steps of one register depend on each other; a second one fills the
/// time that each instruction takes.
pub(super) const SIDE_BY_SIDE: usize = 2;

/// Work that is compiled for each kind of norm, with evaluators for one register and for [`SIDE_BY_SIDE`] registers.
pub(super) trait WithNorm<S: Simd> {
    type Output;
    fn run(self, one: impl EvaluateNorm<S>, many: impl EvaluateNorm<S, SIDE_BY_SIDE>) -> Self::Output;
}

/// Runs work with the fastest evaluator for two powers. On x86-64 one lane stands for processors without AVX2, from before
/// 2013, which have the evaluator of any powers only: the others would be a fifth of the code of the packet kernels.
#[inline(always)]
pub(super) fn with_norm<S: Simd, W: WithNorm<S>>(
    simd: S,
    xy: PowerKind,
    rz: PowerKind,
    work: W,
) -> W::Output {
    let (p, q) = (xy.power(), rz.power());
    if cfg!(target_arch = "x86_64") && S::F32_LANES == 1 {
        return work.run(general(simd, p, q), general(simd, p, q));
    }
    match (xy, rz) {
        (PowerKind::Two, PowerKind::Two) => work.run(Nested(Square, Square), Nested(Square, Square)),
        (PowerKind::One, PowerKind::One) => work.run(Nested(Sum, Sum), Nested(Sum, Sum)),
        (PowerKind::Two, PowerKind::One) => work.run(Nested(Square, Sum), Nested(Square, Sum)),
        (PowerKind::One, PowerKind::Two) => work.run(Nested(Sum, Square), Nested(Sum, Square)),
        (PowerKind::Two, PowerKind::General(_)) => work.run(round(simd, q), round(simd, q)),
        (PowerKind::One, PowerKind::General(_)) | (PowerKind::General(_), _) => {
            work.run(general(simd, p, q), general(simd, p, q))
        }
    }
}

#[inline(always)]
fn round<S: Simd, const K: usize>(simd: S, q: f32) -> LogNorm<S, Round, K> {
    LogNorm::new(Round, Lanes::splat(simd, q))
}

#[inline(always)]
fn general<S: Simd, const K: usize>(simd: S, p: f32, q: f32) -> LogNorm<S, AnyPower<S, K>, K> {
    LogNorm::new(AnyPower::new(Lanes::splat(simd, p)), Lanes::splat(simd, q))
}
