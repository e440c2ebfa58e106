//! Packets of shadow rays against one shape.

use superegg_simd::{Lanes, Simd, Triple, WithSimd, bits};

use super::super::norm::{EvaluateNorm, SIDE_BY_SIDE, WithNorm, with_norm};
use super::super::root::{Entry, entries};
use super::compact::{LaneCompactor, Source};
use super::hits::{Occlusion, PacketHits};
use super::rays::{MAX_PACKETS, PACKET, PacketVectors};
use super::shape::{PacketShape, PreparedShape};

/// [`super::PacketKernels::occluded`].
pub(super) struct OccludeKernel<'a> {
    pub(super) shape: &'a PacketShape,
    pub(super) directions: &'a [PacketVectors],
    pub(super) hits: &'a [PacketHits],
    pub(super) compactor: &'a mut LaneCompactor,
    pub(super) mask: u32,
}

/// [`OccludeKernel`] with the lanes.
struct Occlude<'a, S: Simd>(S, OccludeKernel<'a>);

impl WithSimd for OccludeKernel<'_> {
    type Output = Occlusion;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Occlusion {
        with_norm(simd, self.shape.xy, self.shape.rz, Occlude(simd, self))
    }
}

/// Relative error of the ends of rays.
const END: f32 = 4e-6;
/// The second result of a ray that touches the shape, a negative number, and of one that does not. Numbers, because the lanes
/// of a mask would have to be compacted and expanded like them.
const TOUCHED: f32 = -1.0;
const CLEAR: f32 = 0.0;

impl<S: Simd> WithNorm<S> for Occlude<'_, S> {
    type Output = Occlusion;

    #[inline(always)]
    fn run(mut self, one: impl EvaluateNorm<S>, many: impl EvaluateNorm<S, SIDE_BY_SIDE>) -> Occlusion {
        let simd = self.0;
        let prepared = PreparedShape::new(simd, self.1.shape);
        let OccludeKernel { directions, hits, compactor, mask, .. } = &mut self.1;
        compactor.clear();
        for packet in bits(*mask) {
            for i in 0..PACKET / S::F32_LANES {
                let v = Triple::load(simd, &directions[packet], i);
                let end: Lanes<S> = hits[packet].t.load(simd, i);
                let end = end * prepared.inv_t_scale * end.all(1.0 + END);
                if let Some(span) = prepared.box_span(v, || end) {
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
        let mut answer = Occlusion { packets: 0, hit: [0; MAX_PACKETS], unresolved: [0; MAX_PACKETS] };
        let mut index = 0;
        while let Some(source) = self.1.compactor.source(index) {
            self.add(source, &prepared, &mut answer);
            index += 1;
        }
        answer
    }
}

impl<S: Simd> Occlude<'_, S> {
    /// Searches a point inside on the rays of `K` registers of the compactor.
    #[inline(always)]
    fn search<const K: usize>(
        &mut self,
        norm: impl EvaluateNorm<S, K>,
        prepared: &PreparedShape<S>,
        register: usize,
    ) {
        let Self(simd, OccludeKernel { shape, compactor, .. }) = self;
        let tolerance = Lanes::splat(*simd, shape.tolerance);
        let (near, segment) = compactor.segment(*simd, prepared.origin, register);
        let Entry { s, inside, touched } = entries(norm, &segment, tolerance);
        let t = near.all(0.5).mul_add(segment.length, near + s);
        let t = inside.select(t, near.all(f32::INFINITY));
        let touched = (touched | inside).select(near.all(TOUCHED), near.all(CLEAR));
        compactor.put(register, [t, touched]);
    }

    /// Adds the results of the rays of one source to the answer.
    #[inline(always)]
    fn add(&self, source: Source, prepared: &PreparedShape<S>, answer: &mut Occlusion) {
        let Self(simd, OccludeKernel { hits, compactor, .. }) = self;
        let Source { packet, register: i, lanes, .. } = source;
        let [t, touched] = compactor.results(*simd, source);
        // A point inside that is before the end proves a crossing; one at the end does not.
        let end: Lanes<S> = hits[packet].t.load(*simd, i);
        let end = end * prepared.inv_t_scale * end.all(1.0 - END);
        let hit = t.lt(end).bits() & lanes;
        let unresolved = touched.lt(t.all(CLEAR)).bits() & lanes & !hit;
        answer.packets |= 1 << packet;
        answer.hit[packet] |= hit << (i * S::F32_LANES);
        answer.unresolved[packet] |= unresolved << (i * S::F32_LANES);
    }
}
