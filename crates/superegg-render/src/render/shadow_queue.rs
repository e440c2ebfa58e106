//! Shadow rays to one point light, traced as packets whose origin is the light.

use superegg_geom::RayStart;
use superegg_geom::glam::DVec3;
use superegg_geom::kernels::packet::PacketVectors64;
use superegg_trace::packet::{PacketRays, ShadowStart};

/// Shadow rays to one light. Each is stored reversed: from the light to the surface.
#[derive(Default)]
pub(crate) struct ShadowQueue {
    pub(crate) from_light: PacketRays,
    /// The start of each ray on its surface.
    pub(crate) starts: Vec<ShadowStart>,
}

impl ShadowQueue {
    /// Removes all rays and sets the position of the light.
    pub(crate) fn start(&mut self, light: DVec3) {
        self.from_light.start(light);
        self.starts.clear();
    }

    /// The number of rays.
    pub(crate) fn len(&self) -> usize {
        self.starts.len()
    }

    /// Adds one ray, by its direction from the surface to the light.
    pub(crate) fn push(&mut self, to_light: DVec3, start: ShadowStart) {
        self.from_light.push(-to_light);
        self.starts.push(start);
    }

    /// Adds the rays of a mask of lanes, by their directions from the light. All leave one
    /// candidate outwards.
    pub(crate) fn push_lanes(&mut self, from_light: &PacketVectors64, lanes: u32, candidate: u32) {
        self.from_light.extend(from_light, lanes);
        let start = ShadowStart { own: Some(candidate), start: RayStart::SurfaceOutward };
        self.starts.extend(std::iter::repeat_n(start, lanes.count_ones() as usize));
    }
}
