//! The answers of packets.

use super::rays::{MAX_PACKETS, PACKET, PacketColumn, PacketVectors};

/// The closest candidate of each ray of a packet.
#[derive(Clone, Copy, Debug)]
pub struct PacketHits {
    /// The t of the closest candidate, in the packet's own lengths; before there is one, the largest t that counts. Negative
    /// where the ray searches no more: the interval [0, t] is empty.
    pub t: PacketColumn<f32>,
    /// Upper bound on the error of `t`.
    pub error: PacketColumn<f32>,
    /// The candidate; [`PacketHits::NO_CANDIDATE`] before there is one. A sentinel, because a column of options would take
    /// twice the memory and no register comparison.
    pub id: PacketColumn<u32>,
    /// The lanes that f32 does not resolve, one bit each: another candidate is as close within the errors, or the search did
    /// not converge.
    pub unresolved: u32,
}

impl PacketHits {
    /// The id of a ray without a candidate.
    pub const NO_CANDIDATE: u32 = u32::MAX;

    /// No candidate yet, and nothing beyond `t_max` counts.
    pub fn up_to(t_max: f32) -> Self {
        Self {
            t: PacketColumn::splat(t_max),
            error: PacketColumn::splat(0.0),
            id: PacketColumn::splat(Self::NO_CANDIDATE),
            unresolved: 0,
        }
    }

    /// The largest t that can still be the first crossing of a ray; negative where no ray searches.
    pub fn end(&self) -> f32 {
        self.t.0.iter().zip(self.error.0).map(|(t, error)| t + error).fold(-1.0, f32::max)
    }

    /// Inserts a candidate at `t` for one ray. It replaces the closest one if it is closer. If the two agree within their
    /// errors the ray is unresolved; if the new one is clearly closer, `unresolved` replaces the old state; if it is clearly
    /// farther, nothing changes.
    #[inline(always)]
    pub fn insert(&mut self, lane: usize, t: f32, error: f32, id: u32, unresolved: bool) {
        let (best, best_error) = (self.t[lane], self.error[lane]);
        let is_closer = t < best;
        let is_near = (t - best).abs() <= error + best_error;
        let was_unresolved = self.unresolved >> lane & 1 == 1;
        let unresolved = is_near || if is_closer { unresolved } else { was_unresolved };
        let unresolved = if t < f32::INFINITY { unresolved } else { was_unresolved };
        self.unresolved = self.unresolved & !(1 << lane) | u32::from(unresolved) << lane;
        self.t[lane] = if is_closer { t } else { best };
        self.error[lane] = if is_closer { error } else { best_error };
        self.id[lane] = if is_closer { id } else { self.id[lane] };
    }
}

/// The surfaces at the hits of a packet, in f32.
#[derive(Clone, Copy, Debug)]
pub struct PacketSurfaces {
    /// The lanes that have a surface here, one bit each; the columns of the others are undefined.
    pub lanes: u32,
    /// The t of the crossing, in the packet's own lengths.
    pub t: PacketColumn<f32>,
    /// Upper bound on the error of `t`.
    pub error: PacketColumn<f32>,
    /// The candidate.
    pub id: PacketColumn<u32>,
    /// The outward unit normal in the packet's space.
    pub normal: PacketVectors,
}

impl PacketSurfaces {
    /// No surface.
    pub const NONE: Self = Self {
        lanes: 0,
        t: PacketColumn::splat(0.0),
        error: PacketColumn::splat(0.0),
        id: PacketColumn::splat(0),
        normal: [PacketColumn::splat(0.0); 3],
    };
}

/// The rays that a shape occludes: a mask of lanes for each packet.
#[derive(Clone, Copy, Debug)]
pub struct Occlusion {
    /// The packets that have any lane in `hit` or `unresolved`.
    pub packets: u32,
    /// The rays that certainly cross the shape.
    pub hit: [u32; MAX_PACKETS],
    /// The rays that f32 does not resolve.
    pub unresolved: [u32; MAX_PACKETS],
}

const _: () = assert!(PACKET <= u32::BITS as usize);
