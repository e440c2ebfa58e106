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

use crate::superquadric::Superquadric;

use build::build;
use plan::Arcs;
pub use surface::{Mesh, MeshError};

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
