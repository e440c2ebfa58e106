//! 32 rays against shapes of their own, in f32.

use superegg_simd::{Arch, Column, Lanes, Mask, Simd, Triple, WithSimd};

use super::super::LanePowers;
use super::super::norm::{AnyPower, EvaluateNorm, LogNorm, SIDE_BY_SIDE, Slope};
use super::super::root::{Crossing, NEAR, Segment, entries, first_crossings};
use super::entry::ShapeEntry;

/// Bound on the error of N for rays prepared in f64: the rounding of points in the box to f32.
pub const TOLERANCE: f32 = 1.5e-6;
/// A start where |N - 1| is below this may be on the surface.
const SURFACE: f32 = 1e-4;
/// As [`NEAR`], for exits. An edge that hides before the exit would make the final step end too late, behind another
/// shape; so it is short.
const NEAR_EXIT: f32 = 1e-5;
/// Rounding error of a parameter, added to the error of each crossing.
const ROUNDING: f32 = 1e-6;

/// Rays that are searched together.
pub const STREAM_LANES: usize = 32;

type StreamColumn = Column<f32, STREAM_LANES>;

/// Rays in the spaces of their convex shapes.
#[derive(Clone, Debug)]
pub struct StreamLanes {
    pub(super) start: [StreamColumn; 3],
    pub(super) direction: [StreamColumn; 3],
    /// The length of the segment from the start, in unit space; negative, an empty segment, where a lane has no ray.
    pub(super) length: StreamColumn,
    pub(super) p: StreamColumn,
    pub(super) q: StreamColumn,
    /// The rays that are known to start on the surface and to go in, one bit each.
    pub(super) inward: u32,
    arch: Arch,
}

/// The answers, by lanes.
#[derive(Clone, Debug)]
pub struct StreamHits {
    /// The distance of the crossing from the start of the segment, in unit space; infinite where there is none.
    pub s: StreamColumn,
    /// Upper bound on the error of `s`.
    pub error: StreamColumn,
    /// The rays that have a crossing or may have one: `s` is finite. One bit each, as in the masks below.
    pub found: u32,
    /// The rays that f32 does not resolve.
    pub unresolved: u32,
    /// The rays that leave their shape at the crossing.
    pub leaving: u32,
}

impl Default for StreamHits {
    fn default() -> Self {
        Self {
            s: Column::splat(f32::INFINITY),
            error: Column::splat(0.0),
            found: 0,
            unresolved: 0,
            leaving: 0,
        }
    }
}

impl Default for StreamLanes {
    fn default() -> Self {
        Self::new(Arch::new())
    }
}

/// The query about the rays.
#[derive(Clone, Copy)]
enum LaneSearch {
    Closest,
    FromInside,
    Occluded,
    Enters,
    Isolate,
}

/// A search, compiled for each instruction set once: callers of all kinds share the code.
struct StreamKernel<'a> {
    lanes: &'a StreamLanes,
    search: LaneSearch,
    count: usize,
    hits: &'a mut StreamHits,
}

impl WithSimd for StreamKernel<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { lanes, search, count, hits } = self;
        (hits.found, hits.unresolved, hits.leaving) = (0, 0, 0);
        let registers = count.div_ceil(S::F32_LANES);
        for i in (0..registers).step_by(SIDE_BY_SIDE) {
            // Shadow rays to one shape are often few.
            let is_single = registers - i < SIDE_BY_SIDE;
            match search {
                LaneSearch::Closest => lanes.intersect_at(simd, i, hits),
                LaneSearch::FromInside => lanes.intersect_from_inside_at(simd, i, hits),
                LaneSearch::Occluded if is_single => lanes.occluded_at::<S, 1>(simd, i, hits),
                LaneSearch::Occluded => lanes.occluded_at::<S, SIDE_BY_SIDE>(simd, i, hits),
                LaneSearch::Enters if is_single => lanes.enters_at::<S, 1>(simd, i, hits),
                LaneSearch::Enters => lanes.enters_at::<S, SIDE_BY_SIDE>(simd, i, hits),
                LaneSearch::Isolate if is_single => lanes.isolate_at::<S, 1>(simd, i, hits),
                LaneSearch::Isolate => lanes.isolate_at::<S, SIDE_BY_SIDE>(simd, i, hits),
            }
        }
    }
}

impl StreamLanes {
    /// Empty lanes, for the instruction set that is given.
    pub(in super::super) fn new(arch: Arch) -> Self {
        let one = Column::splat(1.0);
        Self {
            start: [one; 3],
            direction: [one; 3],
            length: Column::splat(-1.0),
            p: one,
            q: one,
            inward: 0,
            arch,
        }
    }

    /// Sets the ray of a lane and the powers of its shape. `is_inward` states that it starts on the surface and goes in.
    #[inline(always)]
    pub fn set(&mut self, lane: usize, powers: LanePowers, entry: &ShapeEntry, is_inward: bool) {
        for axis in 0..3 {
            self.start[axis][lane] = entry.start[axis];
            self.direction[axis][lane] = entry.direction[axis];
        }
        self.length[lane] = entry.length;
        self.p[lane] = powers.p();
        self.q[lane] = powers.q();
        self.inward = self.inward & !(1 << lane) | u32::from(is_inward) << lane;
    }

    /// Empties the lanes from `lane` on.
    #[inline(always)]
    pub fn clear_from(&mut self, lane: usize) {
        for length in &mut self.length.0[lane..STREAM_LANES] {
            *length = -1.0;
        }
    }

    /// The first crossing of each ray in the first `count` lanes, from outside. A ray that starts inside gets the crossing at
    /// its start.
    pub fn intersect(&self, count: usize, hits: &mut StreamHits) {
        self.run(LaneSearch::Closest, count, hits);
    }

    /// As [`StreamLanes::intersect`], for rays that start inside the boxes of their shapes and whose segments reach to the
    /// boxes' ends. A ray that starts inside the shape, or on it and inwards, gets its exit, which is the first crossing from
    /// the other end. Any other start close to the surface is unresolved.
    pub fn intersect_from_inside(&self, count: usize, hits: &mut StreamHits) {
        self.run(LaneSearch::FromInside, count, hits);
    }

    /// Whether each ray in the first `count` lanes enters its shape. Where it certainly does, `found` is set and `s` is a
    /// point inside.
    pub fn occluded(&self, count: usize, hits: &mut StreamHits) {
        self.run(LaneSearch::Occluded, count, hits);
    }

    /// As [`StreamLanes::occluded`], whatever the exponents. Where a ray may enter its shape, `unresolved` is set.
    pub fn enters(&self, count: usize, hits: &mut StreamHits) {
        self.run(LaneSearch::Enters, count, hits);
    }

    /// As [`StreamLanes::enters`], with an interval of the first crossing: the ray is outside up to `s - error`, and inside
    /// at `s`. Where both are equal the ray may start inside. For rays that are set as inward, inside and outside are
    /// swapped: they look for their exit.
    pub fn isolate(&self, count: usize, hits: &mut StreamHits) {
        self.run(LaneSearch::Isolate, count, hits);
    }

    pub(super) fn arch(&self) -> Arch {
        self.arch
    }

    /// Not inlined: the code is large.
    #[inline(never)]
    fn run(&self, search: LaneSearch, count: usize, hits: &mut StreamHits) {
        self.arch.dispatch(StreamKernel { lanes: self, search, count, hits });
    }

    #[inline(always)]
    fn intersect_at<S: Simd>(&self, simd: S, i: usize, hits: &mut StreamHits) {
        let tolerance = Lanes::<S, SIDE_BY_SIDE>::splat(simd, TOLERANCE);
        let infinity = tolerance.all(f32::INFINITY);
        let (norm, segment) = self.load(simd, i);
        let Crossing { s, found, error, unresolved } =
            first_crossings(norm, &segment, tolerance, tolerance.all(NEAR));
        hits.s.store(i, found.select(s, infinity));
        hits.error.store(i, error + error.all(ROUNDING));
        hits.found |= found.bits_from(i);
        hits.unresolved |= unresolved.bits_from(i);
    }

    #[inline(always)]
    fn intersect_from_inside_at<S: Simd>(&self, simd: S, i: usize, hits: &mut StreamHits) {
        let tolerance = Lanes::<S, SIDE_BY_SIDE>::splat(simd, TOLERANCE);
        let (norm, segment) = self.load(simd, i);
        let one = tolerance.all(1.0);
        let zero = tolerance.all(0.0);
        let Slope { excess, .. } = norm.slope(segment.start, segment.direction, one);
        let inward = Mask::of_bits_from(simd, self.inward, i);
        let inside = excess.lt(one.all(-SURFACE)) | inward;
        let outside = one.all(SURFACE).lt(excess).and_not(inward);
        let Segment { start, direction, length, active } = segment;
        let sign = inside.select(-one, one);
        let from = inside.select(length, zero);
        let turned = Segment {
            start: start.along(from, direction),
            direction: direction.scaled(sign),
            length,
            active: active & (inside | outside),
        };
        let crossing =
            first_crossings(norm, &turned, tolerance, inside.select(one.all(NEAR_EXIT), one.all(NEAR)));
        let s = sign.mul_add(crossing.s, from);
        let s = crossing.found.select(s, one.all(f32::INFINITY));
        // A ray from inside cannot miss.
        let mut unresolved = crossing.unresolved
            | active.and_not(inside | outside)
            | (inside & active).and_not(crossing.found);
        if inward.any() {
            // A chord that is nowhere deep runs along the surface, and its end is not reliable.
            let halfway = start.along(s * one.all(0.5), direction);
            let Slope { excess, .. } = norm.slope(halfway, direction, one);
            unresolved = unresolved | (inward & active).and_not(excess.lt(one.all(-SURFACE)));
        }
        hits.s.store(i, s);
        hits.error.store(i, crossing.error + one.all(ROUNDING));
        hits.found |= crossing.found.bits_from(i);
        hits.unresolved |= unresolved.bits_from(i);
        hits.leaving |= inside.bits_from(i);
    }

    #[inline(always)]
    fn occluded_at<S: Simd, const K: usize>(&self, simd: S, i: usize, hits: &mut StreamHits) {
        let tolerance = Lanes::<S, K>::splat(simd, TOLERANCE);
        let infinity = tolerance.all(f32::INFINITY);
        let (norm, segment) = self.load(simd, i);
        let entry = entries(norm, &segment, tolerance);
        let s = entry.s.all(0.5).mul_add(segment.length, entry.s);
        hits.s.store(i, entry.inside.select(s, infinity));
        hits.found |= entry.inside.bits_from(i);
        hits.unresolved |= entry.touched.and_not(entry.inside).bits_from(i);
    }

    #[inline(always)]
    pub(super) fn load<S: Simd, const K: usize>(
        &self,
        simd: S,
        i: usize,
    ) -> (LogNorm<S, AnyPower<S, K>, K>, Segment<S, K>) {
        let norm = LogNorm::new(AnyPower::new(self.p.load(simd, i)), self.q.load(simd, i));
        let length: Lanes<S, K> = self.length.load(simd, i);
        let segment = Segment {
            start: Triple::load(simd, &self.start, i),
            direction: Triple::load(simd, &self.direction, i),
            length,
            active: length.all(0.0).le(length),
        };
        (norm, segment)
    }
}
