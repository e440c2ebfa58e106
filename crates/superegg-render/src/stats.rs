//! Counters of the rays that a render traces.

use std::ops::AddAssign;

use superegg_trace::Coarsened;

/// The number of traced rays of each kind.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct RayCounts {
    /// From the camera.
    pub camera: u64,
    /// From surfaces to lights.
    pub shadow: u64,
    /// From surfaces to random directions, for ambient occlusion and for light by way of matt surfaces.
    pub ambient: u64,
    /// Reflected, total internal reflection included.
    pub reflection: u64,
    /// Refracted.
    pub refraction: u64,
}

impl AddAssign for RayCounts {
    fn add_assign(&mut self, other: Self) {
        self.camera += other.camera;
        self.shadow += other.shadow;
        self.ambient += other.ambient;
        self.reflection += other.reflection;
        self.refraction += other.refraction;
    }
}

/// Counters of a render.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct TraceStats {
    /// The traced rays.
    pub rays: RayCounts,
    /// The number of hits on proxies, which stand for groups too small to be resolved.
    pub proxy_hits: u64,
    /// The rays whose work was bounded because too many parts overlap.
    pub coarsened: Coarsened,
}

impl AddAssign for TraceStats {
    fn add_assign(&mut self, other: Self) {
        self.rays += other.rays;
        self.proxy_hits += other.proxy_hits;
        self.coarsened.rays += other.coarsened.rays;
    }
}
