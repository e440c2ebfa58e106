//! Questions about places: the inside-outside test at a point, and what is in a box.

use std::sync::atomic::{AtomicBool, Ordering};

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
        let unbroken = AtomicBool::new(false);
        self.query_point_unless(point, &unbroken).unwrap_or(PointAnswer { inside: false, least: None })
    }

    /// The same, but `None` when `cancel` turns true: where the parts of a deep fractal overlap, a point may be in the boxes of more than can ever be
    /// asked.
    pub fn query_point_unless(&self, point: DVec3, cancel: &AtomicBool) -> Option<PointAnswer> {
        let mut query = PointQuery { scene: self, point, path: InstancePath::default(), least: None, cancel };
        if let Some(root) = self.root.as_deref() {
            query.visit_group(root, &Transform::IDENTITY, point);
        }
        let inside = query.least.as_ref().is_some_and(|(value, _)| *value < 0.0);
        (!cancel.load(Ordering::Relaxed)).then_some(PointAnswer { inside, least: query.least })
    }

    /// Whether a point of world space is inside any primitive, as [`PointAnswer::inside`] tells it, but for rounding. It ends with the first that
    /// has it inside, and looks only into boxes that hold the point in their own space. `None` when `cancel` turns true.
    pub fn contains_point_unless(&self, point: DVec3, cancel: &AtomicBool) -> Option<bool> {
        self.root.as_deref().map_or(Some(false), |root| self.group_contains(root, point, cancel))
    }

    fn group_contains(&self, group: &Group, local: DVec3, cancel: &AtomicBool) -> Option<bool> {
        if cancel.load(Ordering::Relaxed) {
            return None;
        }
        let mut pending = vec![0u32];
        while let Some(node) = pending.pop() {
            let node = &group.nodes[node as usize];
            for (place, slot) in node.slots().enumerate() {
                if !group.space.group_box(&node.child_box(place)).contains(local) {
                    continue;
                }
                let holds = match slot {
                    Slot::Node(child) => {
                        pending.push(child);
                        false
                    }
                    Slot::Leaf(leaf) => {
                        let leaf = &group.leaves[leaf as usize];
                        let shape = self.primitives[leaf.primitive as usize].unit_shape();
                        shape.inside_outside(leaf.unit_from_group.transform_point3(local)) < 0.0
                    }
                    Slot::Instance(place) => {
                        let instance = &group.instances[place as usize];
                        let local = instance.map().inverse().transform_point3(local);
                        self.group_contains(&instance.group, local, cancel)?
                    }
                };
                if holds {
                    return Some(true);
                }
            }
        }
        Some(false)
    }
}

impl CompiledScene {
    /// The instances of primitives whose world box (the smallest axis-aligned one) meets a box of world space, but for rounding: nothing that does is left
    /// out. In no particular order, and at most `limit` of them; a fractal may have more than can be listed.
    pub fn query_box(&self, query: &Aabb, limit: usize) -> Vec<InstancePath> {
        let mut answer =
            BoxQuery { scene: self, query, limit, path: InstancePath::default(), found: Vec::new() };
        if let Some(root) = self.root.as_deref() {
            answer.visit_group(root, &Transform::IDENTITY);
        }
        answer.found
    }
}

struct BoxQuery<'a> {
    scene: &'a CompiledScene,
    query: &'a Aabb,
    limit: usize,
    path: InstancePath,
    found: Vec<InstancePath>,
}

impl BoxQuery<'_> {
    fn visit_group(&mut self, group: &Group, world_from_group: &Transform) {
        let mut pending = vec![0u32];
        while let Some(node) = pending.pop() {
            let node = &group.nodes[node as usize];
            for (place, slot) in node.slots().enumerate() {
                let bounds = group.space.group_box(&node.child_box(place));
                let meets = bounds.transformed(world_from_group).rounded_outward().meets(self.query);
                if !meets || self.found.len() >= self.limit {
                    continue;
                }
                match slot {
                    Slot::Node(child) => pending.push(child),
                    Slot::Leaf(leaf) => {
                        if leaf_bounds(self.scene, &group.leaves[leaf as usize], world_from_group)
                            .meets(self.query)
                        {
                            self.path.push(leaf);
                            self.found.push(self.path.clone());
                            self.path.pop();
                        }
                    }
                    Slot::Instance(place) => {
                        let instance = &group.instances[place as usize];
                        if let Ok(world_from_child) = world_from_group.after(instance.map()) {
                            self.path.push(place);
                            self.visit_group(&instance.group, &world_from_child);
                            self.path.pop();
                        }
                    }
                }
            }
        }
    }
}

/// The smallest axis-aligned box around a leaf in the world, but for rounding.
fn leaf_bounds(scene: &CompiledScene, leaf: &Leaf, world_from_group: &Transform) -> Aabb {
    let shape = scene.primitives[leaf.primitive as usize].unit_shape();
    let world_from_unit = *world_from_group.forward() * inverse_of(&leaf.unit_from_group);
    let half = shape.half_extent_under(&world_from_unit.matrix3);
    Aabb::around(world_from_unit.translation, half).rounded_outward()
}

struct PointQuery<'a> {
    scene: &'a CompiledScene,
    point: DVec3,
    path: InstancePath,
    least: Option<(f64, InstancePath)>,
    cancel: &'a AtomicBool,
}

impl PointQuery<'_> {
    /// Everything in the space that `world_from_group` leads out of; `local` is the point in it.
    fn visit_group(&mut self, group: &Group, world_from_group: &Transform, local: DVec3) {
        if self.cancel.load(Ordering::Relaxed) {
            return;
        }
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
        if !leaf_bounds(self.scene, leaf, world_from_group).contains(self.point) {
            return;
        }
        let shape = self.scene.primitives[leaf.primitive as usize].unit_shape();
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
