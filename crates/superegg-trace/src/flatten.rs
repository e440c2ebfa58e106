//! The slow trusted twin of the compiled scene: every instance listed, every one asked.
//!
//! It walks the description itself and composes whole transforms, so it shares nothing with the graph but the shape. For shallow scenes only:
//! a fractal has more instances than can be listed.

use superegg_geom::glam::DVec3;
use superegg_geom::{Ray, RayStart, ShapeHit, Superquadric, Transform};
use superegg_scene::{Entity, Scene};

use crate::compile::world_bounds;

/// One instance of a primitive.
#[derive(Clone, Debug)]
pub struct FlatInstance {
    /// The root's name and the aliases down to the primitive, joined by `/`.
    pub path: String,
    /// The shape.
    pub shape: Superquadric,
    /// World from the primitive's own space.
    pub world_from_local: Transform,
}

/// Every instance below `root`, opened `depth` levels deep, in the order of the children; `None` for more than `limit` of them.
pub fn flatten(scene: &Scene, root: &str, depth: u32, limit: usize) -> Option<Vec<FlatInstance>> {
    let mut found = Vec::new();
    walk(scene, root, root.to_owned(), &Transform::IDENTITY, depth, limit, &mut found)?;
    Some(found)
}

fn walk(
    scene: &Scene,
    name: &str,
    path: String,
    world_from_here: &Transform,
    remaining: u32,
    limit: usize,
    found: &mut Vec<FlatInstance>,
) -> Option<()> {
    match scene.get(name)? {
        Entity::Primitive(primitive) => {
            found.push(FlatInstance { path, shape: primitive.shape, world_from_local: *world_from_here });
            (found.len() <= limit).then_some(())
        }
        Entity::Object(_) if remaining == 0 => Some(()),
        Entity::Object(object) => object.children().try_for_each(|(alias, child)| {
            let world_from_child = world_from_here.after(&object.parent_from_child(child).ok()?).ok()?;
            walk(
                scene,
                child.target(),
                format!("{path}/{alias}"),
                &world_from_child,
                remaining - 1,
                limit,
                found,
            )
        }),
    }
}

/// The first crossing of any instance: its place in the list, and where. Of equal ones the first in the list.
pub fn intersect(instances: &[FlatInstance], ray: &Ray) -> Option<(usize, ShapeHit)> {
    instances
        .iter()
        .enumerate()
        .filter_map(|(i, flat)| {
            Some((i, flat.shape.intersect(&ray.to_local(&flat.world_from_local), RayStart::Free)?))
        })
        .min_by(|(_, a), (_, b)| a.t.total_cmp(&b.t))
}

/// The least inside-outside value over the instances whose world box holds the point, and its place in the list.
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
