//! The inside-outside test over a whole scene.

use superegg_geom::Transform;
use superegg_geom::glam::DVec3;

use crate::compile::world_bounds;
use crate::compiled::{CompiledScene, Target};
use crate::path::InstancePath;

/// The answer for one point.
#[derive(Clone, Debug, PartialEq)]
pub struct PointAnswer {
    /// Whether the point is inside any primitive.
    pub inside: bool,
    /// The smallest value of the inside-outside function, each in its primitive's own space, over the primitives whose world box (the
    /// smallest axis-aligned one) holds the point, and whose it is. Of equal values the smaller path's. `None` where no box holds it.
    pub least: Option<(f64, InstancePath)>,
}

impl CompiledScene {
    /// Tests a point of world space.
    pub fn query_point(&self, point: DVec3) -> PointAnswer {
        let mut query = PointQuery { scene: self, point, path: InstancePath::default(), least: None };
        if let Some(root) = self.root {
            query.visit(root, &Transform::IDENTITY, point);
        }
        let inside = query.least.as_ref().is_some_and(|(value, _)| *value < 0.0);
        PointAnswer { inside, least: query.least }
    }
}

struct PointQuery<'a> {
    scene: &'a CompiledScene,
    point: DVec3,
    path: InstancePath,
    least: Option<(f64, InstancePath)>,
}

impl PointQuery<'_> {
    /// Everything in the space that `world_from_here` leads out of; `local` is the point in it.
    fn visit(&mut self, target: Target, world_from_here: &Transform, local: DVec3) {
        match target {
            Target::Primitive(primitive) => {
                let shape = &self.scene.primitives[primitive as usize].shape;
                if !world_bounds(shape, world_from_here).rounded_outward().contains(self.point) {
                    return;
                }
                // A local point beyond the range of f64 is outside.
                let value = shape.inside_outside(local);
                let value = if value.is_nan() { f64::INFINITY } else { value };
                let is_less = self
                    .least
                    .as_ref()
                    .is_none_or(|(least, path)| value < *least || (value == *least && self.path < *path));
                if is_less {
                    self.least = Some((value, self.path.clone()));
                }
            }
            Target::Group(group) => self.visit_group(group, world_from_here, local),
        }
    }

    fn visit_group(&mut self, group: u32, world_from_here: &Transform, local: DVec3) {
        let group = &self.scene.groups[group as usize];
        let mut pending = vec![0u32];
        while let Some(index) = pending.pop() {
            let node = &group.bvh.nodes[index as usize];
            // The box counts in world space: a primitive's world box lies within that of any box around it.
            if !node.bounds.transformed(world_from_here).rounded_outward().contains(self.point) {
                continue;
            }
            if node.count == 0 {
                pending.extend([node.first, node.first + 1]);
                continue;
            }
            for &item in &group.bvh.items[node.first as usize..(node.first + node.count) as usize] {
                let instance = &group.instances[item as usize];
                if let Ok(world_from_child) = world_from_here.after(&instance.parent_from_child) {
                    self.path.push(item);
                    let local = instance.parent_from_child.inverse().transform_point3(local);
                    self.visit(instance.target, &world_from_child, local);
                    self.path.pop();
                }
            }
        }
    }
}
