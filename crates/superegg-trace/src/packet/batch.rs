//! The rays of one trace in f32, and what is known about their hits.

use superegg_geom::glam::DVec3;
use superegg_geom::kernels::packet::{
    ALL_LANES, DirectionBoxes, DirectionRange, PacketHits, PacketKernels, PacketVectors, PacketVectors64,
    PerPacket,
};

use crate::ray::lottery::Lottery;
use superegg_simd::bits;

/// Rays that packets leave to others form a stream if they are so many.
pub(super) const LEAST_STREAM: usize = 64;

/// Up to 32 packets of rays with one origin.
///
/// All directions are scaled by one power of two. A t of the packets times [`TracedPackets::t_scale`] is a t of the rays.
#[derive(Debug)]
pub(super) struct TracedPackets {
    /// The rays' origin in the world.
    pub(super) origin: DVec3,
    pub(super) t_scale: f64,
    pub(super) directions: Vec<PacketVectors>,
    /// The box around the directions of each packet.
    pub(super) direction_boxes: DirectionBoxes,
    /// The box around all directions.
    pub(super) bounds: DirectionRange,
    /// A unit direction in the middle of all.
    pub(super) middle: DVec3,
    pub(super) hits: Vec<PacketHits>,
    /// The largest t of each packet that still counts for some ray; negative once none is active.
    pub(super) ends: PerPacket,
    /// The lanes of each packet whose ray has to be traced in f64.
    pub(super) unresolved: Vec<u32>,
    /// The numbers that each ray draws; `None` for an unused lane. Empty until the first draw.
    pub(super) lotteries: Vec<Option<Lottery>>,
}

impl Default for TracedPackets {
    fn default() -> Self {
        Self {
            origin: DVec3::ZERO,
            t_scale: 1.0,
            directions: Vec::new(),
            direction_boxes: DirectionBoxes::NONE,
            bounds: DirectionRange { scale: 1.0, least: DVec3::ZERO, most: DVec3::ZERO },
            middle: DVec3::ZERO,
            hits: Vec::new(),
            ends: PerPacket::splat(-1.0),
            unresolved: Vec::new(),
            lotteries: Vec::new(),
        }
    }
}

impl TracedPackets {
    /// Loads rays. No hit at `end` or beyond counts. `None` if f32 cannot hold the directions.
    pub(super) fn load(
        &mut self,
        kernels: PacketKernels,
        origin: DVec3,
        directions: &[PacketVectors64],
        end: f64,
    ) -> Option<()> {
        self.origin = origin;
        self.bounds = kernels.scale_directions(directions, &mut self.directions)?;
        self.t_scale = self.bounds.scale;
        let packets = directions.len();
        self.hits.resize(packets, PacketHits::up_to(0.0));
        self.forget_hits(kernels, end);
        self.lotteries.clear();
        self.unresolved.clear();
        self.unresolved.resize(packets, 0);
        let mut middle = DVec3::ZERO;
        for (packet, _) in self.directions.iter().zip(self.ends.0).filter(|(_, end)| *end > 0.0) {
            middle += DVec3::from_array(packet.each_ref().map(|column| f64::from(column.0[0])));
        }
        self.middle = middle.normalize_or_zero();
        Some(())
    }

    /// Makes all rays active again. No hit at `end` or beyond counts.
    pub(super) fn forget_hits(&mut self, kernels: PacketKernels, end: f64) {
        let t_max = (end / self.bounds.scale) as f32;
        self.direction_boxes = kernels.reset(&mut self.directions, &mut self.hits, &mut self.ends, t_max);
    }

    /// The packets of a mask in which some ray is active.
    pub(super) fn active(&self, mask: u32) -> u32 {
        bits(mask).filter(|&packet| self.ends.0[packet] > 0.0).fold(0, |mask, packet| mask | 1 << packet)
    }

    /// Leaves all rays of a mask of packets to f64.
    pub(super) fn leave_to_f64(&mut self, mask: u32) {
        for packet in bits(mask) {
            self.unresolved[packet] = ALL_LANES;
        }
    }

    /// The largest absolute value of each coordinate over all directions.
    pub(super) fn largest(&self) -> DVec3 {
        self.bounds.least.abs().max(self.bounds.most.abs())
    }

    /// A lower bound on `|row . d|` over all directions d.
    pub(super) fn least_along(&self, row: DVec3) -> f64 {
        let DirectionRange { least, most, .. } = self.bounds;
        (row.dot(0.5 * (least + most)).abs() - row.abs().dot(0.5 * (most - least))).max(0.0)
    }
}
