//! Export of scenes to the formats of other programs, one module each.
//!
//! - [`povray`]: POV-Ray, which traces superquadrics natively.

pub mod povray;

/// Compiles the examples of the crate's README.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct ReadmeDoctests;
