//! Data of other programs: readers of particles, fits, tensors and point clouds, and writers of
//! scenes. The crate opens no files; readers take bytes or any seekable stream.
//!
//! - [`read`]: formats are recognized by their content; [`read::open`] lists the frames of a file
//!   and reads one as [`read::Content`]: particles in our conventions, or lines of the modelling
//!   language.
//! - [`coloring`]: particles as a table of instances, coloured by a column.
//! - [`sqb`]: the binary scene file, for tables of instances.
//! - [`mod@write`]: one module for each format; [`povray`] traces superquadrics natively.

pub mod coloring;
pub mod read;
pub mod sqb;
mod srgb;
pub mod write;

pub use write::{points, povray};

/// Compiles the examples of the crate's README.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct ReadmeDoctests;
