//! The mesh and its limits.

use glam::DVec3;
use thiserror::Error;

/// A closed triangle mesh in the shape's own space. Triangles are counter-clockwise as seen from
/// outside.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Mesh {
    /// The vertices: points of the surface, each once.
    pub positions: Vec<DVec3>,
    /// The outward unit normal at each vertex. On edges, creases and poles, where it is not unique,
    /// it is the symmetric choice.
    pub normals: Vec<DVec3>,
    /// The triangles, as indices of vertices.
    pub triangles: Vec<[u32; 3]>,
}

/// Why there is no mesh.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum MeshError {
    /// The tolerance is not a finite number above 0.
    #[error("the tolerance must be a finite number above 0")]
    Tolerance,
    /// The mesh would have more than [`Mesh::MOST_TRIANGLES`] triangles, or f64 does not resolve
    /// the tolerance.
    #[error(
        "a tolerance of {tolerance:e} needs more than {} triangles for one shape; {possible:e} is possible",
        Mesh::MOST_TRIANGLES
    )]
    TooFine {
        /// The tolerance.
        tolerance: f64,
        /// A tolerance that is possible, within a factor of 2 of the least one.
        possible: f64,
    },
}

impl Mesh {
    /// The most triangles of one mesh.
    pub const MOST_TRIANGLES: usize = 4_000_000;

    /// The volume that the triangles enclose.
    pub fn volume(&self) -> f64 {
        let corner = |index: u32| self.positions[index as usize];
        let six_times = |&[a, b, c]: &[u32; 3]| corner(a).dot(corner(b).cross(corner(c)));
        self.triangles.iter().map(six_times).sum::<f64>() / 6.0
    }
}
