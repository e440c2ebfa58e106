//! A slow reference for tests: all instances as a list, and every instance tested.
//!
//! It reads the scene's description itself and composes whole transforms, so it shares nothing with the compiled graph but
//! the shape. It suits shallow scenes only, since a fractal has more instances than can be listed.

use superegg_geom::glam::DVec3;
use superegg_geom::{Aabb, Ray, RayStart, SearchLimits, ShapeHit, Superquadric, Transform};
use superegg_scene::{Entity, Scene};

/// An instance of a primitive.
#[derive(Clone, Debug)]
pub struct FlatInstance {
    /// The root's name and the aliases down to the primitive, joined by `/`.
    pub path: String,
    /// The shape.
    pub shape: Superquadric,
    /// World from the primitive's own space.
    pub world_from_local: Transform,
}

/// All instances below `root`, opened `depth` levels deep, in the order of children. `None` if there are more than
/// `limit`, or if `root` is no name of the scene.
pub fn flatten(scene: &Scene, root: &str, depth: u32, limit: usize) -> Option<Vec<FlatInstance>> {
    let mut flattener = Flattener { scene, limit, found: Vec::new() };
    flattener.visit(root, root.to_owned(), &Transform::IDENTITY, depth)?;
    Some(flattener.found)
}

struct Flattener<'a> {
    scene: &'a Scene,
    limit: usize,
    found: Vec<FlatInstance>,
}

impl Flattener<'_> {
    fn visit(&mut self, name: &str, path: String, world_from_here: &Transform, remaining: u32) -> Option<()> {
        match self.scene.get(name)? {
            Entity::Primitive(primitive) => {
                let (shape, world_from_local) = (primitive.shape, *world_from_here);
                self.found.push(FlatInstance { path, shape, world_from_local });
                (self.found.len() <= self.limit).then_some(())
            }
            Entity::Object(_) | Entity::Table(_) if remaining == 0 => Some(()),
            Entity::Table(table) => (0..table.len()).try_for_each(|row| {
                let world_from_local = world_from_here.after(&table.transform(row)).ok()?;
                let (path, shape) = (format!("{path}/{}", table.name(row)), table.superquadric(row));
                self.found.push(FlatInstance { path, shape, world_from_local });
                (self.found.len() <= self.limit).then_some(())
            }),
            Entity::Object(object) => object.visible_children().try_for_each(|(alias, child)| {
                let world_from_child = world_from_here.after(&object.parent_from_child(child).ok()?).ok()?;
                self.visit(child.target(), format!("{path}/{alias}"), &world_from_child, remaining - 1)
            }),
        }
    }
}

/// The closest hit: the index of the instance and the hit on its shape. The first in the list of equal hits.
pub fn intersect(instances: &[FlatInstance], ray: &Ray) -> Option<(usize, ShapeHit)> {
    instances
        .iter()
        .enumerate()
        .filter_map(|(i, flat)| {
            Some((i, flat.shape.intersect(&ray.to_local(&flat.world_from_local), RayStart::Free)?))
        })
        .min_by(|(_, a), (_, b)| a.t.total_cmp(&b.t))
}

/// The least inside-outside value over the instances whose world box holds the point, with the index of the instance.
pub fn least_value(instances: &[FlatInstance], point: DVec3) -> Option<(usize, f64)> {
    instances
        .iter()
        .enumerate()
        .filter(|(_, flat)| {
            world_bounds(&flat.shape, &flat.world_from_local).rounded_outward().contains(point)
        })
        .map(|(i, flat)| {
            (i, flat.shape.inside_outside(flat.world_from_local.inverse().transform_point3(point)))
        })
        .min_by(|(_, a), (_, b)| a.total_cmp(b))
}

/// The least distance from a point outside of all instances to a surface, with the index of the instance.
pub fn nearest(instances: &[FlatInstance], point: DVec3) -> Option<(usize, f64)> {
    let distance = |flat: &FlatInstance| {
        let map = flat.world_from_local.forward();
        Some(flat.shape.closest_point_under(map, point, &SearchLimits::default())?.distance)
    };
    instances
        .iter()
        .enumerate()
        .filter_map(|(i, flat)| Some((i, distance(flat)?)))
        .min_by(|(_, a), (_, b)| a.total_cmp(b))
}

/// The indices of the instances that hold a point.
pub fn holding(instances: &[FlatInstance], point: DVec3) -> Vec<usize> {
    let holds = |flat: &FlatInstance| {
        flat.shape.inside_outside(flat.world_from_local.inverse().transform_point3(point)) < 0.0
    };
    (0..instances.len()).filter(|&i| holds(&instances[i])).collect()
}

/// The smallest axis-aligned box around the image of a shape.
fn world_bounds(shape: &Superquadric, world_from_local: &Transform) -> Aabb {
    let forward = world_from_local.forward();
    Aabb::around(forward.translation, shape.half_extent_under(&forward.matrix3))
}
