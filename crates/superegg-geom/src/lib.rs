//! The geometry of superquadrics, without input or output.
//!
//! A superquadric (Barr 1981) with semi-axes `radii` and exponents `e` (longitude, the xy plane) and `n` (latitude,
//! towards z) is the set of points where the inside-outside function
//!
//! ```text
//! io(x, y, z) = ((x^2)^(1/e) + (y^2)^(1/e))^(e/n) + (z^2)^(1/n) - 1
//! ```
//!
//! vanishes, in coordinates divided by the radii. The solvers here work on its norm form `N` ([`NormForm`]), which
//! has the same zero set and neither overflows nor goes flat where `io` does.
//!
//! - [`Superquadric`]: the shape; value, gradient, normal, point at (u, v), bounds, and its meeting with a [`Ray`].
//! - [`Transform`]: an affine map kept with its inverse, built from an ordered list of [`TransformStep`]s.
//! - `textbook`, with the feature `baseline`: the course text's method, kept as a baseline for
//!   benchmarks and teaching. It is wrong where its module says so.

mod batch;
#[cfg(feature = "simd")]
#[doc(hidden)]
pub mod kernels;
mod math;
mod measure;
mod norm;
mod shape;
mod solve;
mod superquadric;

pub use batch::{BatchError, BatchHit, HitBatch, RayBatch};
pub use glam;
pub use math::aabb::{Aabb, RayReciprocal};
pub use math::numeric::{scale_to_unit, unit_vector};
pub use math::ray::{Ray, RayStart};
pub use math::transform::{Transform, TransformError, TransformStep, error_through, inverse_of};
pub use measure::{ClosestPoint, SearchLimits, SurfaceArea, SurfacePoint, SurfaceSampler};
pub use norm::NormForm;
pub use shape::{Exponents, ShapeError, ShapeHit};
#[cfg(feature = "baseline")]
pub use solve::textbook;
pub use superquadric::{Convex, Superquadric};
