//! What the camera rays of samples find.

use superegg_geom::glam::{DVec3, Vec3};

/// What the camera rays of some samples see.
#[derive(Clone, Debug, Default)]
pub(crate) struct SampleResults {
    /// Linear light.
    pub(crate) colors: Vec<DVec3>,
    /// The surface that each meets first; none unless they are asked for.
    pub(crate) first_hits: Vec<Option<FirstHit>>,
}

/// The surface that a camera ray meets first.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FirstHit {
    /// Its distance from the plane of the camera, along the line of sight, in world units.
    pub(crate) depth: f32,
    /// The unit normal on the camera's side, in world space.
    pub(crate) normal: Vec3,
    /// The colour of the surface itself, linear.
    pub(crate) albedo: Vec3,
    /// A number that differs from instance to instance, never 0.
    pub(crate) id: u32,
}
