//! Ray against unit shape: the part of the ray in the unit box, then the first root of the norm form on it.

#[cfg(any(test, feature = "baseline"))]
pub mod textbook;

pub(crate) mod certified;
pub(crate) mod convex;
pub(crate) mod span;
