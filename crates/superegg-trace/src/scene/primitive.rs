//! Primitives of a compiled scene.

use superegg_geom::glam::DVec3;
use superegg_geom::{Exponents, Superquadric};

/// A primitive, ready for intersection and shading.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CompiledPrimitive {
    /// The exponents.
    pub exponents: Exponents,
    /// The index of its material in [`CompiledScene::materials`](crate::CompiledScene::materials).
    pub material: u32,
    /// The semi-axes, if it has a pattern or a texture; otherwise they are only in the maps of its instances.
    pub radii: Option<DVec3>,
}

impl CompiledPrimitive {
    /// The shape with semi-axes 1. Intersections are computed in its space.
    pub fn unit_shape(&self) -> Superquadric {
        Superquadric::unit(self.exponents)
    }
}

/// The primitives of a scene as columns: 20 bytes for each, and 32 more for each that has a pattern or a texture.
#[derive(Clone, Debug, Default)]
pub(crate) struct Primitives {
    exponents: Vec<Exponents>,
    /// The index of the material; with [`SIZED`], an index in `sized`.
    material_of: Vec<u32>,
    /// The material and the semi-axes.
    sized: Vec<(u32, DVec3)>,
}

/// Marks an index in [`Primitives::sized`].
const SIZED: u32 = 1 << 31;

impl Primitives {
    pub(crate) fn with_capacity(count: usize) -> Self {
        let (exponents, material_of) = (Vec::with_capacity(count), Vec::with_capacity(count));
        Self { exponents, material_of, sized: Vec::new() }
    }

    pub(crate) fn push(&mut self, primitive: CompiledPrimitive) {
        let CompiledPrimitive { exponents, material, radii } = primitive;
        self.exponents.push(exponents);
        self.material_of.push(match radii {
            None => material,
            Some(radii) => {
                self.sized.push((material, radii));
                SIZED | (self.sized.len() as u32 - 1)
            }
        });
    }

    pub(crate) fn shrink_to_fit(&mut self) {
        self.exponents.shrink_to_fit();
        self.material_of.shrink_to_fit();
        self.sized.shrink_to_fit();
    }

    pub(crate) fn len(&self) -> usize {
        self.exponents.len()
    }

    pub(crate) fn get(&self, index: u32) -> CompiledPrimitive {
        let (exponents, material) = (self.exponents(index), self.material_of[index as usize]);
        if material & SIZED == 0 {
            return CompiledPrimitive { exponents, material, radii: None };
        }
        let (material, radii) = self.sized[(material & !SIZED) as usize];
        CompiledPrimitive { exponents, material, radii: Some(radii) }
    }

    #[inline]
    pub(crate) fn exponents(&self, index: u32) -> Exponents {
        self.exponents[index as usize]
    }

    /// As [`CompiledPrimitive::unit_shape`].
    #[inline]
    pub(crate) fn unit_shape(&self, index: u32) -> Superquadric {
        Superquadric::unit(self.exponents(index))
    }

    /// Their memory in bytes.
    pub(super) fn bytes(&self) -> usize {
        self.exponents.capacity() * size_of::<Exponents>()
            + self.material_of.capacity() * size_of::<u32>()
            + self.sized.capacity() * size_of::<(u32, DVec3)>()
    }
}
