//! A scene in the form that expansion needs: names as numbers, maps composed.

use std::collections::HashMap;

use superegg_geom::Transform;
use superegg_geom::glam::DVec3;
use superegg_scene::{Child, Entity, MAX_DEPTH, Primitive, Scene, object_heights};

use super::data::PreviewShape;

/// An index of a scene for [`SceneIndex::open`]. It does not depend on the view.
#[derive(Debug, Default)]
pub struct SceneIndex {
    pub(super) entities: Vec<IndexedEntity>,
    pub(super) numbers: HashMap<String, u32>,
    pub(super) shapes: Vec<PreviewShape>,
    /// The scene's recursion depth.
    pub(super) depth: u32,
    /// Levels of each entity: 0 for a primitive, [`MAX_DEPTH`] on or above a cycle. More recursion
    /// depth than this adds nothing.
    pub(super) heights: Vec<u32>,
}

/// A primitive or an object.
#[derive(Debug)]
pub(super) enum IndexedEntity {
    /// Index of the shape, and the semi-axes.
    Primitive(u32, DVec3),
    /// The children: map to the object's space, and number of the target.
    Object(Vec<(Transform, u32)>),
}

impl SceneIndex {
    /// Indexes a scene.
    pub fn new(scene: &Scene) -> Self {
        let numbers: HashMap<String, u32> =
            scene.entities().enumerate().map(|(i, (name, _))| (name.to_owned(), i as u32)).collect();
        let mut shapes = Vec::new();
        let mut table_shapes = Vec::new();
        let mut entities = Vec::with_capacity(numbers.len());
        for (_, entity) in scene.entities() {
            entities.push(match entity {
                Entity::Primitive(primitive) => {
                    shapes.push(PreviewShape {
                        exponents: primitive.shape.exponents(),
                        radii: primitive.shape.radii(),
                        patches: primitive.patches,
                        material: primitive.material,
                    });
                    IndexedEntity::Primitive(shapes.len() as u32 - 1, primitive.shape.radii())
                }
                Entity::Object(object) => {
                    let child = |(_, child): (&str, &Child)| {
                        let map = object.parent_from_child(child).ok()?;
                        Some((map, *numbers.get(child.target())?))
                    };
                    IndexedEntity::Object(object.visible_children().filter_map(child).collect())
                }
                Entity::Table(table) => {
                    // The table's shapes follow the entities of the scene.
                    let first = scene.entities().len() + table_shapes.len();
                    for shape in table.shapes() {
                        shapes.push(PreviewShape {
                            exponents: shape.exponents,
                            radii: shape.radii,
                            patches: Primitive::default().patches,
                            material: table.materials()[shape.material as usize],
                        });
                        table_shapes.push(IndexedEntity::Primitive(shapes.len() as u32 - 1, shape.radii));
                    }
                    let row = |row: usize| (table.transform(row), first as u32 + table.shape_index(row));
                    IndexedEntity::Object((0..table.len()).map(row).collect())
                }
            });
        }
        entities.append(&mut table_shapes);
        let heights = heights(&entities);
        Self { entities, numbers, shapes, depth: scene.depth.min(MAX_DEPTH), heights }
    }

    /// Index of a primitive's shape in [`super::Preview::shapes`].
    pub fn shape_of(&self, name: &str) -> Option<u32> {
        match self.entities.get(*self.numbers.get(name)? as usize)? {
            IndexedEntity::Primitive(shape, _) => Some(*shape),
            IndexedEntity::Object(_) => None,
        }
    }
}

fn heights(entities: &[IndexedEntity]) -> Vec<u32> {
    let is_object = |i: u32| matches!(entities[i as usize], IndexedEntity::Object(_));
    let child_objects: Vec<Vec<u32>> = entities
        .iter()
        .map(|entity| match entity {
            IndexedEntity::Primitive(..) => Vec::new(),
            IndexedEntity::Object(children) => {
                children.iter().map(|(_, target)| *target).filter(|i| is_object(*i)).collect()
            }
        })
        .collect();
    let mut heights = object_heights(&child_objects);
    for (height, entity) in heights.iter_mut().zip(entities) {
        if matches!(entity, IndexedEntity::Primitive(..)) {
            *height = 0;
        }
    }
    heights
}
