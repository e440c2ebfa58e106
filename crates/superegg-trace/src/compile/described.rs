//! The primitives that a scene describes, as columns.

use superegg_geom::Exponents;
use superegg_geom::glam::DVec3;
use superegg_scene::{Material, Pattern, Scene};

use super::index::{Container, Index};
use super::signature::Materials;
use crate::scene::group::{NameList, Names};
use crate::scene::primitive::{CompiledPrimitive, Primitives};

/// The primitives of a scene, with their names and materials.
pub(super) struct Described {
    pub(super) primitives: Primitives,
    /// The semi-axes of each primitive. Only compiling needs those of all.
    pub(super) radii: Vec<DVec3>,
    pub(super) names: Names,
    /// The first primitive and the name of each table. Its shapes follow in their order.
    pub(super) tables: Vec<(u32, Box<str>)>,
    pub(super) materials: Materials,
}

impl Described {
    pub(super) fn of(scene: &Scene) -> (Index<'_>, Self) {
        // The capacities are upper bounds. Memory that is not written is not resident.
        let count = scene.entities().len();
        let mut names = NameList::with_capacity(count);
        let mut described = Self {
            primitives: Primitives::with_capacity(count),
            radii: Vec::with_capacity(count),
            names: Names::default(),
            tables: Vec::new(),
            materials: Materials::default(),
        };
        let index = Index::of(scene, |name, primitive| {
            names.push(name);
            let (shape, material) = (&primitive.shape, &primitive.material);
            let index = described.materials.index_of(material);
            described.push(
                shape.radii(),
                shape.exponents(),
                index,
                is_mapped(material) || primitive.textures.is_some(),
            );
        });
        described.names = names.finish();
        for (container, name) in index.containers.iter().zip(&index.container_names) {
            let Container::Table(table) = container else { continue };
            described.tables.push((described.primitives.len() as u32, Box::from(*name)));
            let of_table: Vec<(u32, bool)> = table
                .materials()
                .iter()
                .map(|material| (described.materials.index_of(material), is_mapped(material)))
                .collect();
            for shape in table.shapes() {
                let (material, is_mapped) = of_table[shape.material as usize];
                described.push(shape.radii, shape.exponents, material, is_mapped);
            }
        }
        described.primitives.shrink_to_fit();
        (index, described)
    }

    fn push(&mut self, radii: DVec3, exponents: Exponents, material: u32, is_mapped: bool) {
        let primitive = CompiledPrimitive { exponents, material, radii: is_mapped.then_some(radii) };
        self.primitives.push(primitive);
        self.radii.push(radii);
    }

    /// The semi-axes and exponents of a primitive.
    pub(super) fn shape(&self, primitive: u32) -> (DVec3, Exponents) {
        (self.radii[primitive as usize], self.primitives.exponents(primitive))
    }
}

/// Whether the colour depends on the place on the surface.
fn is_mapped(material: &Material) -> bool {
    material.pattern != Pattern::None
}
