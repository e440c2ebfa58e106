//! Stream compaction of lanes: the rays that hit a shape's box, of all packets, side by side in registers.
//!
//! 20 to 35 % of the lanes that packets send to a shape miss its box, and the evaluation of N dominates the cost. Lanes are
//! compacted only where the machine has an instruction for it (AVX-512); elsewhere registers stay as they are.

use superegg_simd::{Column, Lanes, Simd, Triple};

use super::super::root::Segment;
use super::rays::{MAX_PACKETS, PACKET};
use super::shape::BoxSpan;

/// The rays of all packets, and one register more: the last one may be written beyond the last ray.
const CAPACITY: usize = (MAX_PACKETS + 1) * PACKET;

type RayColumn = Column<f32, CAPACITY>;

/// Compacted rays against one shape, and the results of their search.
#[derive(Clone, Debug)]
pub struct LaneCompactor {
    count: usize,
    /// The t where each ray enters the box, in the shape's space.
    near: RayColumn,
    /// The length in the box; negative, an empty segment, where a lane has no ray.
    length: RayColumn,
    direction: [RayColumn; 3],
    /// Two numbers for each ray.
    results: [RayColumn; 2],
    sources: Vec<Source>,
}

/// A register of a packet from which rays were taken.
#[derive(Clone, Copy, Debug)]
pub(super) struct Source {
    pub(super) packet: usize,
    pub(super) register: usize,
    /// The lanes that were taken, one bit each.
    pub(super) lanes: u32,
    /// The index of the first one among the compacted rays.
    first: usize,
}

impl Default for LaneCompactor {
    fn default() -> Self {
        let zero = RayColumn::splat(0.0);
        let (near, length, direction, results) = (zero, zero, [zero; 3], [zero; 2]);
        Self { count: 0, near, length, direction, results, sources: Vec::new() }
    }
}

impl LaneCompactor {
    /// Removes all rays.
    #[inline(always)]
    pub(super) fn clear(&mut self) {
        self.count = 0;
        self.sources.clear();
    }

    /// Adds the rays of a register that hit the box.
    #[inline(always)]
    pub(super) fn push<S: Simd>(&mut self, packet: usize, register: usize, span: &BoxSpan<S>) {
        let BoxSpan { near, far, direction, active } = *span;
        let first = self.count;
        near.pack(active, &mut self.near.0[first..]);
        active.select(far - near, near.all(-1.0)).pack(active, &mut self.length.0[first..]);
        let [x, y, z] = &mut self.direction;
        direction.x.pack(active, &mut x.0[first..]);
        direction.y.pack(active, &mut y.0[first..]);
        direction.z.pack(active, &mut z.0[first..]);
        self.sources.push(Source { packet, register, lanes: active.bits(), first });
        self.count += active.packed();
    }

    /// Marks the lanes after the last ray as empty. Returns the number of registers that have rays.
    #[inline(always)]
    pub(super) fn finish<S: Simd>(&mut self) -> usize {
        self.length.0[self.count..self.count + S::F32_LANES].fill(-1.0);
        self.count.div_ceil(S::F32_LANES)
    }

    /// The t where the rays of `K` registers enter the box, and their segments inside.
    #[inline(always)]
    pub(super) fn segment<S: Simd, const K: usize>(
        &self,
        simd: S,
        origin: Triple<S>,
        register: usize,
    ) -> (Lanes<S, K>, Segment<S, K>) {
        let near: Lanes<S, K> = self.near.load(simd, register);
        let length = self.length.load(simd, register);
        let direction = Triple::load(simd, &self.direction, register);
        let start = Triple::join([origin; K]).along(near, direction);
        (near, Segment { start, direction, length, active: near.all(0.0).le(length) })
    }

    /// Stores the results of `K` registers.
    #[inline(always)]
    pub(super) fn put<S: Simd, const K: usize>(&mut self, register: usize, results: [Lanes<S, K>; 2]) {
        self.results[0].store(register, results[0]);
        self.results[1].store(register, results[1]);
    }

    /// The registers from which rays were taken, in order.
    #[inline(always)]
    pub(super) fn source(&self, index: usize) -> Option<Source> {
        self.sources.get(index).copied()
    }

    /// The results of the rays of a source, in the lanes from which they were taken; other lanes are undefined.
    #[inline(always)]
    pub(super) fn results<S: Simd>(&self, simd: S, source: Source) -> [Lanes<S>; 2] {
        let [first, second] = &self.results;
        [
            Lanes::unpack(simd, source.lanes, &first.0[source.first..]),
            Lanes::unpack(simd, source.lanes, &second.0[source.first..]),
        ]
    }
}
