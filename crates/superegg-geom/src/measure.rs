//! Measures of the shape: volume, moments, surface area, even samples, closest point and bounds.
//!
//! All of it describes the unit shape as a product of two superellipse arcs ([`arc`]), so that no
//! power of a sine loses digits for exponents near 0 or far above 2.

pub(crate) mod arc;
mod area;
mod bounds;
mod closest;
mod image;
mod inside;
mod moments;
mod sample;

pub use area::SurfaceArea;
pub use closest::{ClosestPoint, SearchLimits};
pub use image::ImageSampler;
pub use inside::InteriorSampler;
pub use sample::{SurfacePoint, SurfaceSampler};
