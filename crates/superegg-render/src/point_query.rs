//! The inside-outside test over a whole scene.

use superegg_geom::glam::DVec3;
use superegg_geom::{Aabb, Transform, inverse_of};

use crate::bvh::Slot;
use crate::compiled::{CompiledScene, Group, Leaf};
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
        if let Some(root) = self.root.as_deref() {
            query.visit_group(root, &Transform::IDENTITY, point);
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
    /// Everything in the space that `world_from_group` leads out of; `local` is the point in it.
    fn visit_group(&mut self, group: &Group, world_from_group: &Transform, local: DVec3) {
        let mut pending = vec![0u32];
        while let Some(node) = pending.pop() {
            let node = &group.nodes[node as usize];
            for (place, slot) in node.slots().enumerate() {
                // The box counts in world space: a primitive's world box lies within that of any box around it.
                let bounds = group.space.group_box(&node.child_box(place));
                if !bounds.transformed(world_from_group).rounded_outward().contains(self.point) {
                    continue;
                }
                match slot {
                    Slot::Node(child) => pending.push(child),
                    Slot::Leaf(leaf) => {
                        self.path.push(leaf);
                        self.visit_leaf(&group.leaves[leaf as usize], world_from_group, local);
                        self.path.pop();
                    }
                    Slot::Instance(place) => {
                        let map = group.instances[place as usize].map();
                        if let Ok(world_from_child) = world_from_group.after(map) {
                            self.path.push(place);
                            let local = map.inverse().transform_point3(local);
                            self.visit_group(
                                &group.instances[place as usize].group,
                                &world_from_child,
                                local,
                            );
                            self.path.pop();
                        }
                    }
                }
            }
        }
    }

    fn visit_leaf(&mut self, leaf: &Leaf, world_from_group: &Transform, local: DVec3) {
        let shape = self.scene.primitives[leaf.primitive as usize].unit_shape();
        let world_from_unit = *world_from_group.forward() * inverse_of(&leaf.unit_from_group);
        let half = shape.half_extent_under(&world_from_unit.matrix3);
        if !Aabb::around(world_from_unit.translation, half).rounded_outward().contains(self.point) {
            return;
        }
        // A local point beyond the range of f64 is outside.
        let value = shape.inside_outside(leaf.unit_from_group.transform_point3(local));
        let value = if value.is_nan() { f64::INFINITY } else { value };
        let is_less = self.least.as_ref().is_none_or(|(least, path)| {
            value < *least || (value == *least && self.scene.rank(&self.path) < self.scene.rank(path))
        });
        if is_less {
            self.least = Some((value, self.path.clone()));
        }
    }
}
