//! Scenes in the formats of other programs, one file each.
//!
//! - [`povray`]: POV-Ray, which traces superquadrics as such.

pub mod povray;
