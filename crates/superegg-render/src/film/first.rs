//! The results of tracing the samples of one batch.

use superegg_geom::glam::{DVec3, Vec3};

/// The colour and the first hit of each sample.
#[derive(Clone, Debug, Default)]
pub(crate) struct SampleResults {
    /// Linear colours.
    pub(crate) colors: Vec<DVec3>,
    /// The parts of the colours that reach the camera by at most one surface. Empty unless requested.
    pub(crate) passes: Vec<FirstLight>,
    /// The first hit of each sample, if there is one. Empty unless requested.
    pub(crate) first_hits: Vec<Option<FirstHit>>,
}

/// The light of a sample that reaches the camera by at most one surface.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct FirstLight {
    /// By none.
    pub(crate) emission: DVec3,
    /// By one.
    pub(crate) direct: DVec3,
}

/// The first surface on a camera ray.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FirstHit {
    /// The depth along the line of sight, in world units.
    pub(crate) depth: f32,
    /// The unit normal of light on the side of the camera, in world space: with bumps.
    pub(crate) normal: Vec3,
    /// The linear colour of the surface.
    pub(crate) albedo: Vec3,
    pub(crate) ids: SurfaceIds,
}

/// The ids of a surface; all 0 for none.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct SurfaceIds {
    /// The hash of the path of the instance.
    pub(crate) id: u32,
    /// The small number of the instance.
    pub(crate) instance: u32,
    /// The small number of the object.
    pub(crate) object: u32,
    /// The Cryptomatte ids of the names of instance and object; 0 unless requested.
    pub(crate) names: [u32; 2],
}
