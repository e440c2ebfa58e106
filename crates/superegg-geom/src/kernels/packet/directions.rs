//! The directions of packets: their scale, and the boxes around them.

use glam::DVec3;
use superegg_simd::{Lanes, Simd, Triple, WithSimd};

use super::hits::PacketHits;
use super::rays::{ALL_LANES, PACKET, PacketColumn, PacketVectors, PacketVectors64, PerPacket};
use crate::math::numeric::scale_to_unit;

/// The box around all directions, after scaling.
#[derive(Clone, Copy, Debug)]
pub struct DirectionRange {
    /// The power of two that directions were multiplied by.
    pub scale: f64,
    /// The lower corner.
    pub least: DVec3,
    /// The upper corner.
    pub most: DVec3,
}

/// The box around the directions of each packet, by its centre and half its size.
#[derive(Clone, Copy, Debug)]
pub struct DirectionBoxes {
    pub(super) middle: [PerPacket; 3],
    pub(super) half: [PerPacket; 3],
}

impl DirectionBoxes {
    /// No packets.
    pub const NONE: Self = Self { middle: [PerPacket::splat(0.0); 3], half: [PerPacket::splat(0.0); 3] };
}

/// [`super::PacketKernels::scale_directions`].
pub(super) struct ScaleKernel<'a> {
    pub(super) directions: &'a [PacketVectors64],
    pub(super) scaled: &'a mut Vec<PacketVectors>,
}

impl WithSimd for ScaleKernel<'_> {
    type Output = Option<DirectionRange>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Option<DirectionRange> {
        let mut least = [simd.splat_f64s(f64::INFINITY); 3];
        let mut most = [simd.splat_f64s(f64::NEG_INFINITY); 3];
        for packet in self.directions {
            for axis in 0..3 {
                for &x in packet[axis].registers(simd) {
                    // A comparison with NaN is false.
                    let (low, high) = (least[axis], most[axis]);
                    least[axis] = simd.select_f64s(simd.less_than_f64s(x, low), x, low);
                    most[axis] = simd.select_f64s(simd.less_than_f64s(high, x), x, high);
                }
            }
        }
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for axis in 0..3 {
            low[axis] = simd.reduce_min_f64s(least[axis]);
            high[axis] = simd.reduce_max_f64s(most[axis]);
        }
        let (_, scale) = scale_to_unit(low.abs().max(high.abs()))?;
        self.scaled.resize(self.directions.len(), [PacketColumn::splat(0.0); 3]);
        for (to, from) in self.scaled.iter_mut().zip(self.directions) {
            for axis in 0..3 {
                for lane in 0..PACKET {
                    to[axis].0[lane] = (from[axis].0[lane] * scale) as f32;
                }
            }
        }
        Some(DirectionRange { scale, least: low * scale, most: high * scale })
    }
}

/// [`super::PacketKernels::reset`].
pub(super) struct ResetKernel<'a> {
    pub(super) directions: &'a mut [PacketVectors],
    pub(super) hits: &'a mut [PacketHits],
    pub(super) ends: &'a mut PerPacket,
    pub(super) t_max: f32,
}

impl WithSimd for ResetKernel<'_> {
    type Output = DirectionBoxes;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> DirectionBoxes {
        let Self { directions, hits, ends, t_max } = self;
        let splat = |x: f32| Lanes::<S>::splat(simd, x);
        let zero = splat(0.0);
        *ends = PerPacket::splat(-1.0);
        let mut boxes = DirectionBoxes::NONE;
        for (index, (packet, hits)) in directions.iter_mut().zip(hits).enumerate() {
            let mut valid_lanes = 0;
            for i in 0..PACKET / S::F32_LANES {
                let Triple { x, y, z } = Triple::<S>::load(simd, packet, i);
                let size = x.abs() + y.abs() + z.abs();
                let is_valid = zero.lt(size) & size.lt(splat(f32::INFINITY));
                valid_lanes |= is_valid.bits_from(i);
                hits.t.store(i, is_valid.select(splat(t_max), splat(-1.0)));
                hits.error.store(i, zero);
                hits.id.store(simd, i, PacketHits::NO_CANDIDATE);
            }
            hits.unresolved = 0;
            if valid_lanes == 0 {
                continue;
            }
            ends[index] = t_max;
            for (axis, column) in packet.iter_mut().enumerate() {
                if valid_lanes != ALL_LANES {
                    let valid = column[valid_lanes.trailing_zeros() as usize];
                    for lane in 0..PACKET {
                        column.0[lane] = if valid_lanes >> lane & 1 == 1 { column.0[lane] } else { valid };
                    }
                }
                let (mut least, mut largest) = (splat(f32::INFINITY), splat(f32::NEG_INFINITY));
                for i in 0..PACKET / S::F32_LANES {
                    let x = column.load(simd, i);
                    (least, largest) = (least.min(x), largest.max(x));
                }
                let (low, high) = (least.least(), largest.largest());
                boxes.middle[axis][index] = 0.5 * low + 0.5 * high;
                boxes.half[axis][index] = 0.5 * high - 0.5 * low;
            }
        }
        boxes
    }
}
