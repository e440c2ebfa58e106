//! The box of a transformed group, from the group's extent along the parent's axes.
//!
//! A box around the transformed corners of the group's own box grows with every rotated level. The extent along an axis
//! does not. It is found by a best-first search down the graph that ends at a leaf, whose extent is exact.

use std::collections::BinaryHeap;

use superegg_geom::glam::DVec3;
use superegg_geom::{Aabb, Transform, inverse_of};

use crate::ranked::Ranked;
use crate::scene::compiled::CompiledScene;
use crate::scene::group::{Group, Leaf};
use crate::scene::node::Slot;
use crate::scene::primitive::Primitives;

/// The most nodes to open for one direction. Beyond it the best bound so far counts.
const MOST_OPENED: usize = 96;

impl CompiledScene {
    /// The extent along a direction: the largest `u . p` over the points p of the scene, in world
    /// units times the length of `u`. Never too small, and nearly exact. `None` for an empty scene.
    pub fn extent(&self, u: DVec3) -> Option<f64> {
        let root = self.root.as_ref()?;
        let refined = extent(root, &self.primitives, u);
        let of_box = u.dot(root.bounds.center()) + u.abs().dot(root.bounds.half_extent());
        // `min` ignores an extent that is NaN.
        Some(refined.min(of_box))
    }
}

/// The box around the image of a group: never too small, and nearly the smallest.
pub(super) fn image_box(group: &Group, primitives: &Primitives, parent_from_child: &Transform) -> Aabb {
    let by_corners = group.bounds.transformed(parent_from_child);
    let forward = parent_from_child.forward();
    let rows = forward.matrix3.transpose();
    let extent = |u: DVec3| extent(group, primitives, u);
    let mut refined = by_corners;
    for (axis, row) in [rows.x_axis, rows.y_axis, rows.z_axis].into_iter().enumerate() {
        let at = forward.translation[axis];
        // `min` and `max` ignore an extent that is NaN.
        refined.max[axis] = (at + extent(row)).min(by_corners.max[axis]);
        refined.min[axis] = (at - extent(-row)).max(by_corners.min[axis]);
    }
    refined
}

/// A part of the graph. Its priority is an upper bound on its extent.
type Candidate<'a> = Ranked<(), Part<'a>>;

fn candidate(bound: f64, part: Part<'_>) -> Candidate<'_> {
    Ranked { priority: bound, rank: (), item: part }
}

enum Part<'a> {
    /// A node of a group, the direction in the group's space, and what the maps on the path to the group add.
    Node(&'a Group, u32, DVec3, f64),
    /// A leaf, whose bound is its extent.
    Leaf,
}

/// An upper bound on `u . p` over the points p of a group. Its loop over nodes is its own, not [`Group::walk`], since it
/// has one queue for all groups; so is that of `nearest.rs`.
fn extent(group: &Group, primitives: &Primitives, u: DVec3) -> f64 {
    let mut open = BinaryHeap::new();
    open.push(candidate(f64::INFINITY, Part::Node(group, 0, u, 0.0)));
    for _ in 0..MOST_OPENED {
        let Some(Candidate { priority: bound, item: part, .. }) = open.pop() else {
            return f64::NEG_INFINITY;
        };
        let Part::Node(group, node, u, so_far) = part else { return bound };
        for (child_box, slot) in group.nodes[node as usize].children() {
            let bound = so_far + box_extent(group, &child_box, u);
            open.push(match slot {
                Slot::Node(child) => candidate(bound, Part::Node(group, child, u, so_far)),
                Slot::Leaf(leaf) => {
                    let exact = so_far + leaf_extent(&group.leaves[leaf as usize], primitives, u);
                    candidate(if exact < bound { exact } else { bound }, Part::Leaf)
                }
                Slot::Instance(instance) => {
                    let instance = &group.instances[instance as usize];
                    let forward = instance.map().forward();
                    let so_far = so_far + u.dot(forward.translation);
                    let u = forward.matrix3.transpose() * u;
                    candidate(bound, Part::Node(&instance.group, 0, u, so_far))
                }
            });
        }
    }
    open.pop().map_or(f64::NEG_INFINITY, |best| best.priority)
}

fn box_extent(group: &Group, tree_box: &Aabb, u: DVec3) -> f64 {
    let center = tree_box.center() / group.space.scale + group.space.center;
    u.dot(center) + u.abs().dot(tree_box.half_extent() / group.space.scale)
}

fn leaf_extent(leaf: &Leaf, primitives: &Primitives, u: DVec3) -> f64 {
    let group_from_unit = inverse_of(&leaf.unit_from_group);
    let local = group_from_unit.matrix3.transpose() * u;
    u.dot(group_from_unit.translation) + primitives.unit_shape(leaf.primitive).norm().support(local)
}
