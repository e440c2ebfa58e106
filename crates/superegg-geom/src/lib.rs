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
//! - [`textbook`]: the course text's method, kept as a baseline. It is wrong where its module says so.

mod aabb;
mod box_span;
mod certified;
mod convex;
pub mod lanes;
mod norm;
mod numeric;
mod ray;
mod superquadric;
pub mod textbook;
mod transform;

pub use aabb::{Aabb, RayReciprocal};
pub use glam;
pub use norm::NormForm;
pub use numeric::{scale_to_unit, unit_vector};
pub use ray::{Ray, RayStart};
pub use superquadric::{Exponents, ShapeError, ShapeHit, Superquadric};
pub use transform::{Transform, TransformError, TransformStep, error_through, inverse_of};
