//! The candidates that the rays of a packet hit.

use superegg_simd::{Lanes, Simd, WithSimd};

use super::hits::PacketHits;
use super::rays::PACKET;

/// The candidates of a packet, by lanes.
#[derive(Clone, Copy, Debug)]
pub struct PacketCandidates {
    /// The lanes that f32 does not resolve, one bit each.
    pub unresolved: u32,
    /// The lanes whose error is below the width of their ray.
    pub near: u32,
    /// The number of candidates in the other lanes.
    pub count: usize,
    /// The candidates.
    pub ids: [u32; PACKET],
    /// The lanes of each candidate.
    pub lanes: [u32; PACKET],
}

/// The width of a ray cone: `width + spread * t`.
#[derive(Clone, Copy, Debug)]
pub struct ConeWidth {
    /// At t = 0.
    pub width: f32,
    /// The increase for each unit of t.
    pub spread: f32,
}

/// [`super::PacketKernels::candidates`].
pub(super) struct CandidateKernel<'a> {
    pub(super) hits: &'a PacketHits,
    pub(super) active: u32,
    pub(super) width: ConeWidth,
}

/// The smallest and largest t whose squares f32 holds.
pub const RANGE: [f32; 2] = [1e-12, 1e12];

impl WithSimd for CandidateKernel<'_> {
    type Output = PacketCandidates;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> PacketCandidates {
        let Self { hits, active, width } = self;
        let splat = |x: f32| Lanes::<S>::splat(simd, x);
        let unresolved = hits.unresolved & active;
        let mut answer =
            PacketCandidates { unresolved, near: 0, count: 0, ids: [0; PACKET], lanes: [0; PACKET] };
        let mut missing = 0;
        for i in 0..PACKET / S::F32_LANES {
            let (t, error): (Lanes<S>, Lanes<S>) = (hits.t.load(simd, i), hits.error.load(simd, i));
            let has_none = hits.id.equals(simd, i, PacketHits::NO_CANDIDATE);
            let near = splat(RANGE[0]).le(t)
                & t.lt(splat(RANGE[1]))
                & error.le(splat(width.spread).mul_add(t, splat(width.width)));
            answer.near |= near.bits_from(i);
            missing |= has_none.bits_from(i);
        }
        let mut left = active & !missing & !unresolved;
        while left != 0 {
            let id = hits.id[left.trailing_zeros() as usize];
            let mut same = 0;
            for i in 0..PACKET / S::F32_LANES {
                same |= hits.id.equals(simd, i, id).bits_from(i);
            }
            answer.ids[answer.count] = id;
            answer.lanes[answer.count] = same & left;
            answer.count += 1;
            left &= !same;
        }
        answer
    }
}
