//! The results of tracing the samples of one batch.

use superegg_geom::glam::{DVec3, Vec3};

/// The colour and the first hit of each sample.
#[derive(Clone, Debug, Default)]
pub(crate) struct SampleResults {
    /// Linear colours.
    pub(crate) colors: Vec<DVec3>,
    /// The first hit of each sample, if there is one. Empty unless requested.
    pub(crate) first_hits: Vec<Option<FirstHit>>,
}

/// The first surface on a camera ray.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FirstHit {
    /// The depth along the line of sight, in world units.
    pub(crate) depth: f32,
    /// The unit normal on the side of the camera, in world space.
    pub(crate) normal: Vec3,
    /// The linear colour of the surface.
    pub(crate) albedo: Vec3,
    /// The instance id, never 0.
    pub(crate) id: u32,
}
