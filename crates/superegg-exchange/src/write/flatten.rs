//! The instances below a root, as one list.

use std::collections::HashMap;

use superegg_geom::glam::{DAffine3, DMat3, DVec3};
use superegg_geom::{Superquadric, Transform};
use superegg_scene::{Entity, InstanceTable, MAX_DEPTH, Material, Object, Scene};

use super::written::WriteError;

/// The most instances of a list.
pub const MOST_INSTANCES: u64 = 2_000_000;

/// A shape with its material, which instances share.
#[derive(Clone, Debug, PartialEq)]
pub struct Part {
    /// The name of the primitive, or of the table and the number of its shape.
    pub name: String,
    /// The shape.
    pub shape: Superquadric,
    /// The material.
    pub material: Material,
}

/// An instance of a part.
#[derive(Clone, Debug, PartialEq)]
pub struct Instance {
    /// The root's name and the aliases down to the primitive, joined by `/`.
    pub path: String,
    /// The index of its part in [`Instances::parts`].
    pub part: usize,
    /// World from the shape's space. Its determinant is above 0: a mirror image of a superquadric is
    /// the superquadric itself under another rotation, so a mirrored instance has its z axis
    /// reversed.
    pub map: DAffine3,
    /// The row's id, of a table that has ids.
    pub id: Option<i64>,
}

/// The instances below a root.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Instances {
    /// The distinct shapes with materials.
    pub parts: Vec<Part>,
    /// The instances, in the order of children.
    pub list: Vec<Instance>,
}

impl Instances {
    /// The part of an instance.
    pub fn part(&self, instance: &Instance) -> &Part {
        &self.parts[instance.part]
    }
}

/// The instances below `root`, opened `depth` levels deep, at most [`MAX_DEPTH`]. The root object is level 1; an
/// object may contain itself.
///
/// # Errors
/// An unknown or empty root, more than [`MOST_INSTANCES`], or a transform out of range.
pub fn flatten(scene: &Scene, root: &str, depth: u32) -> Result<Instances, WriteError> {
    let depth = depth.min(MAX_DEPTH);
    let Some((name, entity)) = scene.entities().find(|(name, _)| *name == root) else {
        return Err(WriteError::Unknown(root.to_owned()));
    };
    let mut counter = Counter { scene, known: HashMap::new() };
    let count = counter.count(name, entity, depth);
    if count == 0 {
        return Err(WriteError::Empty(root.to_owned()));
    }
    if count > MOST_INSTANCES {
        return Err(WriteError::TooManyInstances { depth, count, most: MOST_INSTANCES });
    }
    let mut walk = Walk {
        counter,
        parts: HashMap::new(),
        path: root.to_owned(),
        instances: Instances { parts: Vec::new(), list: Vec::with_capacity(count as usize) },
    };
    walk.visit(name, entity, depth, &Transform::IDENTITY)?;
    Ok(walk.instances)
}

/// Counts instances without visiting each: a fractal may have more than can be visited.
struct Counter<'a> {
    scene: &'a Scene,
    known: HashMap<(&'a str, u32), u64>,
}

impl<'a> Counter<'a> {
    fn count(&mut self, name: &'a str, entity: &'a Entity, remaining: u32) -> u64 {
        match entity {
            Entity::Primitive(_) => 1,
            Entity::Object(_) | Entity::Table(_) if remaining == 0 => 0,
            Entity::Table(table) => table.len() as u64,
            Entity::Object(object) => {
                if let Some(&count) = self.known.get(&(name, remaining)) {
                    return count;
                }
                let mut count: u64 = 0;
                for (_, child) in object.visible_children() {
                    if let Some(entity) = self.scene.get(child.target()) {
                        count = count.saturating_add(self.count(child.target(), entity, remaining - 1));
                    }
                }
                self.known.insert((name, remaining), count);
                count
            }
        }
    }
}

struct Walk<'a> {
    counter: Counter<'a>,
    /// The first part of each entity; the shapes of a table follow each other.
    parts: HashMap<&'a str, usize>,
    path: String,
    instances: Instances,
}

impl<'a> Walk<'a> {
    fn visit(
        &mut self,
        name: &'a str,
        entity: &'a Entity,
        remaining: u32,
        world: &Transform,
    ) -> Result<(), WriteError> {
        match entity {
            Entity::Primitive(primitive) => {
                let part = *self.parts.entry(name).or_insert_with(|| {
                    let part =
                        Part { name: name.to_owned(), shape: primitive.shape, material: primitive.material };
                    self.instances.parts.push(part);
                    self.instances.parts.len() - 1
                });
                self.push(part, world, None);
                Ok(())
            }
            Entity::Object(_) | Entity::Table(_) if remaining == 0 => Ok(()),
            Entity::Table(table) => self.table(name, table, world),
            Entity::Object(object) => self.object(object, remaining, world),
        }
    }

    fn object(&mut self, object: &'a Object, remaining: u32, world: &Transform) -> Result<(), WriteError> {
        for (alias, child) in object.visible_children() {
            let Some(entity) = self.counter.scene.get(child.target()) else { continue };
            if self.counter.count(child.target(), entity, remaining - 1) == 0 {
                continue;
            }
            let length = self.path.len();
            self.path.push('/');
            self.path.push_str(alias);
            let map = object.parent_from_child(child).and_then(|map| world.after(&map));
            let map = map.map_err(|error| WriteError::Transform { path: self.path.clone(), error })?;
            self.visit(child.target(), entity, remaining - 1, &map)?;
            self.path.truncate(length);
        }
        Ok(())
    }

    fn table(&mut self, name: &'a str, table: &InstanceTable, world: &Transform) -> Result<(), WriteError> {
        let first = *self.parts.entry(name).or_insert_with(|| {
            let first = self.instances.parts.len();
            for (number, shape) in table.shapes().enumerate() {
                self.instances.parts.push(Part {
                    name: format!("{name}-{}", number + 1),
                    shape: Superquadric::new(shape.radii, shape.exponents)
                        .unwrap_or_else(|_| Superquadric::unit(shape.exponents)),
                    material: table.materials()[shape.material as usize],
                });
            }
            first
        });
        let length = self.path.len();
        for row in 0..table.len() {
            self.path.push('/');
            self.path.push_str(&table.name(row));
            let map = world.after(&table.transform(row));
            let map = map.map_err(|error| WriteError::Transform { path: self.path.clone(), error })?;
            let id = table.ids().map(|ids| ids[row]);
            self.push(first + table.shape_index(row) as usize, &map, id);
            self.path.truncate(length);
        }
        Ok(())
    }

    fn push(&mut self, part: usize, world: &Transform, id: Option<i64>) {
        let mut map = *world.forward();
        if is_mirrored(&map.matrix3) {
            map.matrix3.z_axis = -map.matrix3.z_axis;
        }
        self.instances.list.push(Instance { path: self.path.clone(), part, map, id });
    }
}

/// Whether a linear map has a determinant below 0, at any scale.
fn is_mirrored(linear: &DMat3) -> bool {
    let unit = |v: DVec3| superegg_geom::unit_vector(v).unwrap_or(DVec3::Z);
    unit(linear.x_axis).cross(unit(linear.y_axis)).dot(unit(linear.z_axis)) < 0.0
}

#[cfg(test)]
mod tests {
    use superegg_geom::TransformStep;

    use super::*;

    #[test]
    fn objects_in_objects_and_in_themselves() {
        let mut scene = Scene::default();
        scene.ensure_primitive("ball").unwrap();
        scene.ensure_object("tree").unwrap();
        scene.add_child("tree", "trunk", "ball").unwrap();
        scene.add_child("tree", "left", "tree").unwrap();
        scene.transform_child("tree", TransformStep::Translate(DVec3::X)).unwrap();
        scene.add_child("tree", "right", "tree").unwrap();
        scene.transform_child("tree", TransformStep::Scale(DVec3::new(-1.0, 1.0, 1.0))).unwrap();
        let instances = flatten(&scene, "tree", 3).unwrap();
        assert_eq!((instances.list.len(), instances.parts.len()), (7, 1));
        let at = |path: &str| instances.list.iter().find(|instance| instance.path == path).unwrap();
        assert_eq!(at("tree/left/left/trunk").map.translation, DVec3::new(2.0, 0.0, 0.0));
        assert!(instances.list.iter().all(|instance| instance.map.matrix3.determinant() > 0.0));
        assert!(matches!(flatten(&scene, "tree", 64), Err(WriteError::TooManyInstances { .. })));
        assert!(matches!(flatten(&scene, "tree", 0), Err(WriteError::Empty(_))));
        assert!(matches!(flatten(&scene, "bush", 3), Err(WriteError::Unknown(_))));
    }

    #[test]
    fn an_endless_object_without_a_primitive_ends() {
        let mut scene = Scene::default();
        scene.ensure_object("void").unwrap();
        scene.add_child("void", "a", "void").unwrap();
        scene.add_child("void", "b", "void").unwrap();
        assert!(matches!(flatten(&scene, "void", 64), Err(WriteError::Empty(_))));
    }
}
