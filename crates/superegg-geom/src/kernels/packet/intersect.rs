//! The closest crossings of packets with one shape.

use superegg_simd::{Lanes, Mask, Simd, Triple, WithSimd, bits};

use super::super::norm::{EvaluateNorm, SIDE_BY_SIDE, WithNorm, with_norm};
use super::super::root::{Crossing, NEAR, first_crossings};
use super::compact::{LaneCompactor, Source};
use super::hits::PacketHits;
use super::rays::{PACKET, PacketVectors, PerPacket};
use super::shape::{PacketShape, PreparedShape};

/// The packets that search their closest crossings, and memory for it.
#[derive(Debug)]
pub struct PacketBatch<'a> {
    /// The directions, in f32.
    pub directions: &'a [PacketVectors],
    /// The closest candidates so far.
    pub hits: &'a mut [PacketHits],
    /// For each packet the largest t that can still be the first crossing of a ray.
    pub ends: &'a mut PerPacket,
    /// Scratch memory.
    pub compactor: &'a mut LaneCompactor,
}

/// [`super::PacketKernels::intersect`].
pub(super) struct IntersectKernel<'a> {
    pub(super) shape: &'a PacketShape,
    pub(super) batch: PacketBatch<'a>,
    pub(super) mask: u32,
    pub(super) id: u32,
}

/// [`IntersectKernel`] with the lanes.
struct Intersect<'a, S: Simd>(S, IntersectKernel<'a>);

impl WithSimd for IntersectKernel<'_> {
    type Output = u32;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> u32 {
        with_norm(simd, self.shape.xy, self.shape.rz, Intersect(simd, self))
    }
}

/// The second result of an unresolved lane, in place of its error. The lanes of a mask would have to be compacted and
/// expanded like numbers; the sign of the error is free.
const UNRESOLVED: f32 = -1.0;

impl<S: Simd> WithNorm<S> for Intersect<'_, S> {
    type Output = u32;

    #[inline(always)]
    fn run(mut self, one: impl EvaluateNorm<S>, many: impl EvaluateNorm<S, SIDE_BY_SIDE>) -> u32 {
        let simd = self.0;
        let prepared = PreparedShape::new(simd, self.1.shape);
        let IntersectKernel { batch: PacketBatch { directions, hits, compactor, .. }, mask, .. } =
            &mut self.1;
        compactor.clear();
        for packet in bits(*mask) {
            for i in 0..PACKET / S::F32_LANES {
                let hits = &hits[packet];
                let end = || {
                    let best: Lanes<S> = hits.t.load(simd, i);
                    (best + hits.error.load(simd, i)) * prepared.inv_t_scale
                };
                let v = Triple::load(simd, &directions[packet], i);
                if let Some(span) = prepared.box_span(v, end) {
                    compactor.push(packet, i, &span);
                }
            }
        }
        let count = compactor.finish::<S>();
        for register in (0..count).step_by(SIDE_BY_SIDE) {
            if register + 1 < count {
                self.search(many, &prepared, register);
            } else {
                self.search(one, &prepared, register);
            }
        }
        let mut closer = 0;
        let mut index = 0;
        while let Some(source) = self.1.batch.compactor.source(index) {
            closer |= u32::from(self.insert(source, &prepared)) << source.packet;
            index += 1;
        }
        closer
    }
}

impl<S: Simd> Intersect<'_, S> {
    /// Searches the rays of `K` registers of the compactor.
    #[inline(always)]
    fn search<const K: usize>(
        &mut self,
        norm: impl EvaluateNorm<S, K>,
        prepared: &PreparedShape<S>,
        register: usize,
    ) {
        let Self(simd, IntersectKernel { shape, batch, .. }) = self;
        let tolerance = Lanes::splat(*simd, shape.tolerance);
        let (near, segment) = batch.compactor.segment(*simd, prepared.origin, register);
        let Crossing { s, found, error, unresolved } =
            first_crossings(norm, &segment, tolerance, near.all(NEAR));
        let t = found.select(near + s, near.all(f32::INFINITY));
        let error = unresolved.select(near.all(UNRESOLVED), error);
        batch.compactor.put(register, [t, error]);
    }

    /// [`PacketHits::insert`] for all lanes of a register. Returns whether any lane has a new closest candidate.
    #[inline(always)]
    fn insert(&mut self, source: Source, prepared: &PreparedShape<S>) -> bool {
        let Self(simd, IntersectKernel { batch, id, .. }) = self;
        let PacketBatch { hits, ends, compactor, .. } = batch;
        let Source { packet, register: i, lanes, .. } = source;
        let hits = &mut hits[packet];
        let (zero, infinity) = (Lanes::splat(*simd, 0.0), Lanes::splat(*simd, f32::INFINITY));
        let [t, error] = compactor.results(*simd, source);
        let t = Mask::of_bits(*simd, lanes).select(t, infinity);
        let found = t.lt(infinity);
        if !found.any() {
            return false;
        }
        let unresolved = error.lt(zero);
        let t = t * prepared.t_scale;
        // The error in the shape's space, and the rounding of t.
        let error = error.max(zero).mul_add(prepared.t_scale, t.all(4e-7) * t);
        let (best, old_error): (Lanes<S>, Lanes<S>) = (hits.t.load(*simd, i), hits.error.load(*simd, i));
        let is_closer = found & t.lt(best);
        let is_near = found & (t - best).abs().le(error + old_error);
        let set = is_near | (is_closer & unresolved);
        let shift = i * S::F32_LANES;
        hits.unresolved = hits.unresolved & !(is_closer.bits() << shift) | set.bits() << shift;
        if !is_closer.any() {
            return false;
        }
        hits.t.store_where(is_closer, i, t);
        hits.error.store_where(is_closer, i, error);
        hits.id.store_where(is_closer, i, *id);
        let mut end: Lanes<S> = zero;
        for i in 0..PACKET / S::F32_LANES {
            end = end.max(hits.t.load(*simd, i) + hits.error.load(*simd, i));
        }
        ends[packet] = end.largest();
        true
    }
}
