//! The mesh and its limits.

use glam::DVec3;
use thiserror::Error;

use super::build::build;
use super::plan::Arcs;
use crate::superquadric::Superquadric;

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

impl Superquadric {
    /// A closed triangle mesh whose points are all within `tolerance` of the surface, and whose
    /// distance from each point of the surface is at most `tolerance`, in the shape's units, for
    /// every pair of exponents.
    ///
    /// The bound is proved: the surface is a product of two superellipse arcs, and the distance
    /// between an arc and a chord has a closed form. The distance of the mesh is at most the sum of
    /// both, so the chords are as long as their bounds allow, in both directions, and rings near the
    /// poles have fewer vertices. The triangles are those of one octant, mirrored. There are at least
    /// eight, whatever the tolerance.
    ///
    /// # Errors
    /// The tolerance is no finite number above 0, or it needs more than [`Mesh::MOST_TRIANGLES`].
    ///
    /// ```
    /// use superegg_geom::{Exponents, Superquadric};
    /// let star = Superquadric::unit(Exponents::new(3.0, 2.5)?);
    /// let mesh = star.mesh(1e-3).unwrap();
    /// assert!(mesh.positions.iter().all(|&p| (star.norm().value(p) - 1.0).abs() < 1e-12));
    /// assert!((mesh.volume() - star.volume()).abs() < 1e-3 * star.surface_area());
    /// # Ok::<(), superegg_geom::ShapeError>(())
    /// ```
    pub fn mesh(&self, tolerance: f64) -> Result<Mesh, MeshError> {
        if !(tolerance.is_finite() && tolerance > 0.0) {
            return Err(MeshError::Tolerance);
        }
        let unit = self.radii().max_element();
        let arcs = Arcs::of(self);
        let plan = arcs
            .plan(tolerance / unit, Mesh::MOST_TRIANGLES)
            .ok_or_else(|| MeshError::TooFine { tolerance, possible: least_tolerance(&arcs) * unit })?;
        Ok(build(self, &plan))
    }
}

/// A tolerance that is possible, in units of the largest semi-axis.
fn least_tolerance(arcs: &Arcs) -> f64 {
    let is_possible = |tolerance: f64| arcs.first_plan(tolerance, Mesh::MOST_TRIANGLES).is_some();
    let mut possible = 1.0;
    for factor in [0.0625, 0.5] {
        while is_possible(possible * factor) {
            possible *= factor;
        }
    }
    possible
}
