//! Primitives of a compiled scene.

use superegg_geom::glam::DVec3;
use superegg_geom::{Exponents, Superquadric};

/// A primitive, ready for intersection and shading.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CompiledPrimitive {
    /// The semi-axes.
    pub radii: DVec3,
    /// The exponents.
    pub exponents: Exponents,
    /// The index of its material in [`CompiledScene::materials`](crate::CompiledScene::materials).
    pub material: u32,
}

impl CompiledPrimitive {
    /// The shape with semi-axes 1. Intersections are computed in its space.
    pub fn unit_shape(&self) -> Superquadric {
        Superquadric::unit(self.exponents)
    }
}
