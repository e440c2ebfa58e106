//! How far a group reaches in a direction, for boxes that do not swell from level to level.
//!
//! The box of a transformed group, made of the corners of the group's own box, grows with every turned level. Here it is made of the group's
//! reach along the parent's axes: a search down the graph, best bound first, that ends at a leaf, whose reach is exact.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use superegg_geom::glam::DVec3;
use superegg_geom::{Aabb, Transform, inverse_of};

use crate::bvh::Slot;
use crate::compiled::{CompiledPrimitive, Group, Leaf};

/// So many nodes are opened for one direction; after that the best bound so far is taken.
const MOST_OPENED: usize = 96;

/// The box around the image of a group: never too small, and nearly the smallest.
pub(crate) fn image_box(
    group: &Group,
    primitives: &[CompiledPrimitive],
    parent_from_child: &Transform,
) -> Aabb {
    let by_corners = group.bounds.transformed(parent_from_child);
    let forward = parent_from_child.forward();
    let rows = forward.matrix3.transpose();
    let reach = |u: DVec3| reach(group, primitives, u);
    let mut refined = by_corners;
    for (axis, row) in [rows.x_axis, rows.y_axis, rows.z_axis].into_iter().enumerate() {
        let at = forward.translation[axis];
        // A bound that is not a number is no bound.
        refined.max[axis] = (at + reach(row)).min(by_corners.max[axis]);
        refined.min[axis] = (at - reach(-row)).max(by_corners.min[axis]);
    }
    refined
}

/// A part of the graph that may reach furthest.
struct Candidate<'a> {
    /// No point of it reaches further.
    bound: f64,
    part: Part<'a>,
}

enum Part<'a> {
    /// A node of a group, the direction in the group's space, and what the way there adds.
    Node(&'a Group, u32, DVec3, f64),
    /// A leaf, whose bound is its reach.
    Leaf,
}

impl PartialEq for Candidate<'_> {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Candidate<'_> {}

impl PartialOrd for Candidate<'_> {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Candidate<'_> {
    fn cmp(&self, other: &Self) -> Ordering {
        self.bound.total_cmp(&other.bound)
    }
}

/// At least the largest `u . p` over the points p of a group.
fn reach(group: &Group, primitives: &[CompiledPrimitive], u: DVec3) -> f64 {
    let mut open = BinaryHeap::new();
    open.push(Candidate { bound: f64::INFINITY, part: Part::Node(group, 0, u, 0.0) });
    for _ in 0..MOST_OPENED {
        let Some(Candidate { bound, part }) = open.pop() else { return f64::NEG_INFINITY };
        let Part::Node(group, node, u, so_far) = part else { return bound };
        let node = &group.nodes[node as usize];
        for (place, slot) in node.slots().enumerate() {
            let box_bound = so_far + box_reach(group, &node.child_box(place), u);
            open.push(match slot {
                Slot::Node(child) => {
                    Candidate { bound: box_bound, part: Part::Node(group, child, u, so_far) }
                }
                Slot::Leaf(leaf) => {
                    let exact = so_far + leaf_reach(&group.leaves[leaf as usize], primitives, u);
                    Candidate { bound: if exact < box_bound { exact } else { box_bound }, part: Part::Leaf }
                }
                Slot::Instance(instance) => {
                    let instance = &group.instances[instance as usize];
                    let forward = instance.parent_from_child.forward();
                    let so_far = so_far + u.dot(forward.translation);
                    let u = forward.matrix3.transpose() * u;
                    Candidate { bound: box_bound, part: Part::Node(&instance.group, 0, u, so_far) }
                }
            });
        }
    }
    open.pop().map_or(f64::NEG_INFINITY, |best| best.bound)
}

fn box_reach(group: &Group, tree_box: &Aabb, u: DVec3) -> f64 {
    let center = tree_box.center() / group.space.scale + group.space.center;
    u.dot(center) + u.abs().dot(tree_box.half_extent() / group.space.scale)
}

fn leaf_reach(leaf: &Leaf, primitives: &[CompiledPrimitive], u: DVec3) -> f64 {
    let group_from_unit = inverse_of(&leaf.unit_from_group);
    let local = group_from_unit.matrix3.transpose() * u;
    u.dot(group_from_unit.translation)
        + primitives[leaf.primitive as usize].unit_shape().norm().support(local)
}
