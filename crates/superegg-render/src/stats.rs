//! Counters of the rays that a render traces.

use std::ops::AddAssign;

/// How many rays of each kind were traced.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RayCounts {
    /// From the camera.
    pub camera: u64,
    /// From surfaces to lights.
    pub shadow: u64,
    /// From surfaces to all sides, for ambient occlusion.
    pub ambient: u64,
    /// Mirrored, total internal reflection included.
    pub reflection: u64,
    /// Transmitted.
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

/// What tracing took.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct TraceStats {
    /// The rays.
    pub rays: RayCounts,
    /// How many of them ended at a group that was too small to be opened, and saw its average ([`crate::LEAST_FOOTPRINT`]).
    pub proxy_hits: u64,
}

impl AddAssign for TraceStats {
    fn add_assign(&mut self, other: Self) {
        self.rays += other.rays;
        self.proxy_hits += other.proxy_hits;
    }
}
