//! Packets against the boxes of a node: interval culling first, then each ray.

use superegg_simd::{Lanes, Linear, Simd, Triple, WithSimd, bits, register_bits};

use super::super::norm::TINY;
use super::directions::DirectionBoxes;
use super::rays::{MAX_PACKETS, PACKET, PacketVectors, PerPacket};
use super::shape::recip;

/// The boxes of a node, as the rays of a packet see them.
#[derive(Clone, Copy, Debug)]
pub struct NodeBoxes<'a> {
    /// The least x, y and z of each box, then the largest.
    pub bounds: &'a [[f32; 8]; 6],
    /// The number of boxes.
    pub count: usize,
    /// The packet's origin in the tree's space.
    pub origin: [f32; 3],
    /// Boxes are enlarged by this, for the rounding of origin and directions.
    pub pad: [f32; 3],
    /// Converts the packet's t to t in this space.
    pub t_scale: f32,
    /// The boxes that are tested by intervals only, one bit each.
    pub intervals_only: u8,
    /// The reciprocal directions in this space, by [`super::PacketKernels::intervals`]: an interval may be wide, so the
    /// packets that it lets pass are tested ray by ray.
    pub inverses: &'a [PacketVectors],
}

/// Bounds of the reciprocal directions of each packet, in the space of a tree.
#[derive(Clone, Copy, Debug)]
pub struct PacketIntervals {
    pub(super) least: [PerPacket; 3],
    pub(super) largest: [PerPacket; 3],
    /// The shortest and the longest image of a direction, squared.
    pub squares: [f32; 2],
}

impl PacketIntervals {
    /// A lower bound on the t at which any ray of the packets in `mask` enters a box, and an upper bound on the t at which
    /// any leaves it, in the packets' own lengths. It costs more than the test of a whole node for each packet.
    pub fn range(&self, boxes: &NodeBoxes<'_>, child: usize, mask: u32) -> [f32; 2] {
        let faces: [[f32; 2]; 3] = std::array::from_fn(|axis| {
            let [low, high] = [boxes.bounds[axis][child], boxes.bounds[axis + 3][child]];
            let (origin, pad) = (boxes.origin[axis], boxes.pad[axis]);
            [low - origin - pad, high - origin + pad]
        });
        let (mut first, mut last) = (f32::INFINITY, 0.0_f32);
        for packet in bits(mask) {
            let (mut near, mut far) = (0.0_f32, f32::INFINITY);
            for (axis, [low, high]) in faces.into_iter().enumerate() {
                let (least, largest) = (self.least[axis][packet], self.largest[axis][packet]);
                let (a, b, c, d) = (low * least, low * largest, high * least, high * largest);
                near = near.max(a.min(b).min(c.min(d)));
                far = far.min(a.max(b).max(c.max(d)));
            }
            first = first.min(near);
            last = last.max(far);
        }
        [first * (1.0 - BOX_ROUNDING) / boxes.t_scale, last * (1.0 + BOX_ROUNDING) / boxes.t_scale]
    }
}

/// [`super::PacketKernels::intersect_boxes`].
pub(super) struct BoxKernel<'a> {
    pub(super) boxes: &'a NodeBoxes<'a>,
    pub(super) intervals: &'a PacketIntervals,
    pub(super) ends: &'a PerPacket,
    pub(super) mask: u32,
}

impl WithSimd for BoxKernel<'_> {
    type Output = [u32; 8];

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> [u32; 8] {
        let Self { boxes, intervals, ends, mask } = self;
        let mut hit = [0; 8];
        let mut faces = [[0f32; 8]; 6];
        for axis in 0..3 {
            for i in 0..8 {
                faces[axis][i] = boxes.bounds[axis][i] - boxes.origin[axis] - boxes.pad[axis];
                faces[axis + 3][i] = boxes.bounds[axis + 3][i] - boxes.origin[axis] + boxes.pad[axis];
            }
        }
        let splat = |x: f32| Lanes::<S>::splat(simd, x);
        let zero = splat(0.0);
        let t_scale = splat(boxes.t_scale);
        // One lane for each packet: the slab test in interval arithmetic.
        for i in 0..MAX_PACKETS / S::F32_LANES {
            let active = register_bits::<S>(mask, i);
            if active == 0 {
                continue;
            }
            let [x, y, z] = &intervals.least;
            let least: [Lanes<S>; 3] = [x.load(simd, i), y.load(simd, i), z.load(simd, i)];
            let [x, y, z] = &intervals.largest;
            let largest: [Lanes<S>; 3] = [x.load(simd, i), y.load(simd, i), z.load(simd, i)];
            let end = ends.load(simd, i) * t_scale;
            for (child, hit) in hit.iter_mut().enumerate().take(boxes.count) {
                let (mut near, mut far) = (zero, end);
                for axis in 0..3 {
                    let (low, high) = (splat(faces[axis][child]), splat(faces[axis + 3][child]));
                    let (a, b) = (low * least[axis], low * largest[axis]);
                    let (c, d) = (high * least[axis], high * largest[axis]);
                    near = near.max(a.min(b).min(c.min(d)));
                    far = far.min(a.max(b).max(c.max(d)));
                }
                *hit |= (near.le(far).bits() & active) << (i * S::F32_LANES);
            }
        }
        // One lane for each ray, for the packets that are left.
        for (child, hit) in hit.iter_mut().enumerate().take(boxes.count) {
            if boxes.intervals_only >> child & 1 == 1 {
                continue;
            }
            for packet in bits(*hit) {
                let end = splat(ends[packet] * boxes.t_scale);
                let mut any_hit = false;
                for i in 0..PACKET / S::F32_LANES {
                    let inverse = Triple::load(simd, &boxes.inverses[packet], i);
                    let (mut near, mut far) = (zero, end);
                    for (axis, inverse) in [inverse.x, inverse.y, inverse.z].into_iter().enumerate() {
                        let low = splat(faces[axis][child]) * inverse;
                        let high = splat(faces[axis + 3][child]) * inverse;
                        near = near.max(low.min(high));
                        far = far.min(low.max(high));
                    }
                    any_hit |= near.le(far).any();
                }
                *hit &= !(u32::from(!any_hit) << packet);
            }
        }
        hit
    }
}

/// [`super::PacketKernels::intervals`].
pub(super) struct IntervalKernel<'a> {
    pub(super) columns: &'a [[f32; 3]; 3],
    pub(super) directions: &'a [PacketVectors],
    pub(super) direction_boxes: &'a DirectionBoxes,
    pub(super) mask: u32,
    pub(super) inverses: &'a mut [PacketVectors],
}

/// Relative rounding error of the image of a direction in f32.
const BOX_ROUNDING: f32 = 2e-6;
/// Bound of an interval of reciprocals that contains infinity.
pub(super) const ENDLESS: f32 = 1e30;

impl WithSimd for IntervalKernel<'_> {
    type Output = PacketIntervals;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> PacketIntervals {
        let Self { columns, directions, direction_boxes: boxes, mask, inverses } = self;
        let map = Linear::splat(simd, columns);
        let splat = |x: f32| Lanes::<S>::splat(simd, x);
        let (mut shortest, mut longest) = (splat(f32::INFINITY), splat(0.0));
        for packet in bits(mask) {
            for i in 0..PACKET / S::F32_LANES {
                let v = map.image(Triple::load(simd, &directions[packet], i));
                let square = v.dot(v);
                shortest = shortest.min(square);
                longest = longest.max(square);
                for (axis, v) in [v.x, v.y, v.z].into_iter().enumerate() {
                    inverses[packet][axis].store(i, recip(v));
                }
            }
        }
        let mut intervals = PacketIntervals {
            least: [PerPacket::splat(0.0); 3],
            largest: [PerPacket::splat(0.0); 3],
            squares: [shortest.least(), longest.largest()],
        };
        let size = Linear::splat(simd, &columns.map(|column| column.map(f32::abs)));
        let (one, tiny, endless) = (splat(1.0), splat(TINY), splat(ENDLESS));
        for i in 0..MAX_PACKETS / S::F32_LANES {
            if register_bits::<S>(mask, i) == 0 {
                continue;
            }
            let middle = Triple::<S>::load(simd, &boxes.middle, i);
            let half = Triple::<S>::load(simd, &boxes.half, i);
            // Enlarged for the rounding of the centre and of its image.
            let rounding = splat(BOX_ROUNDING);
            let half = Triple {
                x: rounding.mul_add(middle.x.abs(), half.x),
                y: rounding.mul_add(middle.y.abs(), half.y),
                z: rounding.mul_add(middle.z.abs(), half.z),
            };
            let (middle, half) = (map.image(middle), size.image(half));
            let sides = [(middle.x, half.x), (middle.y, half.y), (middle.z, half.z)];
            for (axis, (middle, half)) in sides.into_iter().enumerate() {
                let (low, high) = (middle - half, middle + half);
                // The reciprocals of an interval around 0 are unbounded.
                let has_sign = tiny.lt(low) | high.lt(-tiny);
                intervals.least[axis].store(i, has_sign.select(one / high, -endless));
                intervals.largest[axis].store(i, has_sign.select(one / low, endless));
            }
        }
        intervals
    }
}
