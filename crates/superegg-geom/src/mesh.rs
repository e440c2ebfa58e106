//! Triangle meshes of a superquadric, with a proven distance from the exact surface.
//!
//! An octant of the surface is a product of two superellipse arcs (`measure/arc.rs`): with the
//! section (X, Y) and the profile (rho, zeta),
//!
//! ```text
//! P = (a rho X, b rho Y, c zeta)
//! ```
//!
//! The mesh is the product of two polygons with vertices on those arcs ([`polygon`]). Its quads are
//! plane trapezoids, because both rings of a band are multiples of the same polygon. Rings near the
//! poles may skip vertices of the section ([`plan`]). [`build`] makes vertices and triangles of one
//! octant and its seven mirror images.

mod build;
mod plan;
mod polygon;
mod surface;

pub use surface::{Mesh, MeshError};
