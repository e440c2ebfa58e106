#![doc = include_str!("../README.md")]

mod batch;
#[cfg(feature = "simd")]
#[doc(hidden)]
pub mod kernels;
mod math;
mod measure;
mod mesh;
mod norm;
mod shape;
mod solve;
mod superquadric;

pub use batch::{BatchError, BatchHit, HitBatch, HitColumns, RayBatch};
pub use glam;
pub use math::aabb::{Aabb, RayReciprocal};
pub use math::eigen::symmetric_eigen;
pub use math::numeric::{scale_to_unit, unit_vector};
pub use math::random::SplitMix;
pub use math::ray::{Ray, RayStart};
pub use math::transform::{
    Transform, TransformBound, TransformError, TransformStep, error_through, inverse_of,
};
pub use measure::{
    ClosestPoint, ImageSampler, InteriorSampler, SearchLimits, SurfaceArea, SurfacePoint, SurfaceSampler,
};
pub use mesh::{Mesh, MeshError};
pub use norm::{BOUND_SHAPES, NormForm};
pub use shape::{Exponents, ShapeError, ShapeHit};
#[cfg(feature = "baseline")]
pub use solve::textbook;
pub use superquadric::{Convex, Superquadric};
