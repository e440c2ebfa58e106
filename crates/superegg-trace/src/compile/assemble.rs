//! Assembling a group from its parts.

use std::hint::black_box;
use std::sync::{Arc, OnceLock};

use rayon::prelude::*;
use superegg_geom::{Aabb, BOUND_SHAPES, Transform};

use super::bounds;
use super::described::Described;
use super::fold::fold;
use super::parts::{FoldedLeaf, GroupItem, LARGE, LeafImage, NO_MAP, Parts, map_all, unit_from_group};
use super::survey::Survey;
use crate::scene::bvh::Tree;
use crate::scene::compiled::BoxInflation;
use crate::scene::group::{Group, Instance, Leaf, NameRef, Names};
use crate::scene::node::{Slot, TreeBox, TreeSpace, whole_box};

/// The sum that becomes a [`BoxInflation`].
#[derive(Default)]
pub(super) struct InflationSum {
    instances: u64,
    ratios: f64,
}

impl InflationSum {
    pub(super) fn mean(&self) -> BoxInflation {
        let Self { instances, ratios } = *self;
        let mean_ratio = if instances == 0 { 1.0 } else { ratios / instances as f64 };
        BoxInflation { instances, mean_ratio }
    }
}

/// Assembles a group after its small children are folded into it; `None` if it is empty. `folded_before` counts the items
/// that were folded into other groups.
///
/// Loose boxes determine the space of the tree, tight boxes the tree, and the tree the order of the leaves.
pub(super) fn assemble(
    mut parts: Parts<'_>,
    names: Arc<Names>,
    survey: Survey,
    described: &Described,
    inflation: &mut InflationSum,
    folded_before: usize,
) -> Option<Group> {
    let has_one_child = parts.item_count() == 1;
    fold(&mut parts, &survey.leaf_box, folded_before);
    let mut whole = survey.leaf_box;
    let image = |leaf: &FoldedLeaf| leaf.maps.image(described.primitives.exponents(leaf.primitive));
    whole = parts.folded.iter().fold(whole, |whole, leaf| whole.union(&image(leaf).loose_box()));
    let group_boxes: Vec<Aabb> = parts
        .groups
        .iter()
        .map(|item| {
            let corners = item.group.bounds.transformed(&item.parent_from_child);
            let refined = bounds::image_box(&item.group, &described.primitives, &item.parent_from_child)
                .rounded_outward();
            inflation.instances += 1;
            inflation.ratios += (corners.half_area() / refined.half_area()).max(1.0);
            refined
        })
        .collect();
    whole = group_boxes.iter().fold(whole, |whole, b| whole.union(b));
    if parts.item_count() == 0 {
        return None;
    }
    let space = TreeSpace::of(&whole);
    let mut boxes = leaf_boxes(&parts, survey.boxes, &space, described);
    boxes.extend(group_boxes.iter().map(|b| space.tree_box(b)));
    let bounds = space.bounds_of(&boxes);
    let Tree { mut nodes, order } = Tree::build(&boxes);
    drop(boxes);

    let leaf_count = parts.leaves.len() + parts.folded.len();
    let mut folded: Vec<Option<Leaf>> = Vec::with_capacity(parts.folded.len());
    for FoldedLeaf { name, primitive, maps } in std::mem::take(&mut parts.folded) {
        folded.push(Some(Leaf::new(maps.unit_from_group, primitive, name, &described.primitives)));
    }
    let mut groups: Vec<Option<Instance>> = Vec::with_capacity(parts.groups.len());
    for GroupItem { name, parent_from_child, group } in std::mem::take(&mut parts.groups) {
        let stretch = stretch_of(&parent_from_child);
        groups.push(Some(Instance { parent_from_child, group, name, stretch }));
    }
    let folded_names = std::mem::take(&mut parts.folded_names);
    let plain = &parts.leaves;
    let make_plain = |item: u32| {
        let (child, primitive) = plain[item as usize];
        let radii = described.radii[primitive as usize];
        let unit_from_group = parts.transform(child).map_or(NO_MAP, |map| unit_from_group(&map, radii));
        Leaf::new(unit_from_group, primitive, NameRef::child(child), &described.primitives)
    };
    let mut instances = Vec::with_capacity(groups.len());
    let leaves = if leaf_count == plain.len() && groups.is_empty() {
        in_order(order, make_plain)
    } else {
        // Leaves and instances have indices of their own, in the order of the tree.
        let mut leaves = Vec::with_capacity(leaf_count);
        let mut slot_of = Vec::with_capacity(order.len());
        for &item in &order {
            let index = item as usize;
            if index < leaf_count {
                slot_of.push(Slot::Leaf(leaves.len() as u32));
                let leaf = if index < plain.len() {
                    Some(make_plain(item))
                } else {
                    folded[index - plain.len()].take()
                };
                leaves.extend(leaf);
            } else {
                slot_of.push(Slot::Instance(instances.len() as u32));
                instances.extend(groups[index - leaf_count].take());
            }
        }
        for node in &mut nodes {
            node.map_slots(|slot| match slot {
                Slot::Leaf(leaf) => slot_of[leaf as usize],
                Slot::Node(_) | Slot::Instance(_) => slot,
            });
        }
        leaves
    };
    let count = parts.group_count + parts.primitive_count;
    Some(Group {
        leaves,
        instances,
        nodes,
        space,
        bounds,
        names,
        work: Group::work_with(&folded_names),
        folded: folded_names,
        has_one_child,
        count,
        signature: survey.signature,
        growth: 1.0,
        proxy: OnceLock::new(),
    })
}

/// The boxes of plain and folded leaves in the space of a tree, from those of a survey if there are any.
fn leaf_boxes(
    parts: &Parts<'_>,
    surveyed: Option<Vec<Aabb>>,
    space: &TreeSpace,
    described: &Described,
) -> Vec<TreeBox> {
    let mut boxes =
        match surveyed {
            Some(surveyed) => map_all(&surveyed, |leaf_box| {
                if leaf_box.is_empty() { TreeBox::POINT } else { space.tree_box(leaf_box) }
            }),
            None => plain_boxes(parts, space, described),
        };
    let image = |leaf: &FoldedLeaf| leaf.maps.image(described.primitives.exponents(leaf.primitive));
    for leaves in parts.folded.chunks(BOUND_SHAPES) {
        let images = std::array::from_fn(|i| leaves.get(i).map(image));
        boxes.extend(LeafImage::tight_boxes(&images).iter().flatten().map(|tight| space.tree_box(tight)));
    }
    // The box of a group is exact, so the boxes that may touch its faces are.
    let whole = whole_box(boxes.iter());
    let is_outer = whole.outer_test();
    let (plain, folded) = boxes.split_at_mut(parts.leaves.len());
    for (held, leaf) in plain.iter_mut().zip(&parts.leaves).filter(|(held, _)| is_outer(held)) {
        if let Some(image) = parts.image(leaf, described) {
            *held = space.tree_box(&image.exact_box());
        }
    }
    for (held, leaf) in folded.iter_mut().zip(&parts.folded).filter(|(held, _)| is_outer(held)) {
        *held = space.tree_box(&image(leaf).exact_box());
    }
    boxes
}

/// The boxes of plain leaves, several at once, on all threads if there are many.
fn plain_boxes(parts: &Parts<'_>, space: &TreeSpace, described: &Described) -> Vec<TreeBox> {
    let mut boxes = vec![TreeBox::POINT; parts.leaves.len()];
    let leaves = parts.leaves.par_chunks(BOUND_SHAPES);
    let both = leaves.zip(boxes.par_chunks_mut(BOUND_SHAPES)).with_min_len(LARGE / BOUND_SHAPES);
    both.for_each(|(leaves, boxes)| {
        let images = std::array::from_fn(|i| parts.image(leaves.get(i)?, described));
        for (held, tight) in boxes.iter_mut().zip(LeafImage::tight_boxes(&images)) {
            *held = tight.map_or(TreeBox::POINT, |tight| space.tree_box(&tight));
        }
    });
    boxes
}

/// Makes leaves in the order of a tree.
///
/// Many leaves are made in the order of their children, and each thread makes those of its own part of the tree: the
/// children lie in memory in that order. Writes to far places wait for memory one after the other, so the seats of
/// some leaves are loaded together before they are written.
fn in_order(order: Vec<u32>, make: impl Fn(u32) -> Leaf + Sync) -> Vec<Leaf> {
    const TOGETHER: usize = 64;
    if order.len() < LARGE {
        return order.iter().map(|&item| make(item)).collect();
    }
    let mut seat_of = vec![0u32; order.len()];
    (0..).zip(&order).for_each(|(seat, &item)| seat_of[item as usize] = seat);
    drop(order);
    let none = Leaf { unit_from_group: NO_MAP, primitive: 0, name: NameRef::ROOT, lane_powers: None };
    let mut leaves: Vec<Leaf> = seat_of.par_iter().map(|_| none).collect();
    let part = seat_of.len().div_ceil(rayon::current_num_threads());
    leaves.par_chunks_mut(part).enumerate().for_each(|(number, leaves)| {
        let mut own = [(0, 0); TOGETHER];
        for (first, seats) in (0..).step_by(TOGETHER).zip(seat_of.chunks(TOGETHER)) {
            let mut count = 0;
            for (item, &seat) in (first..).zip(seats) {
                own[count] = (item, (seat as usize).wrapping_sub(number * part));
                count += usize::from(own[count].1 < leaves.len());
            }
            let mut loaded = 0.0;
            for &(_, seat) in &own[..count] {
                let map = &leaves[seat].unit_from_group;
                loaded += map.matrix3.x_axis.x + map.matrix3.z_axis.z + map.translation.z;
            }
            black_box(loaded);
            for &(item, seat) in &own[..count] {
                leaves[seat] = make(item);
            }
        }
    });
    leaves
}

/// An upper bound on the factor by which a map stretches a length: the longest column if the columns are orthogonal, else
/// the Frobenius norm.
fn stretch_of(map: &Transform) -> f64 {
    let columns = map.forward().matrix3;
    let largest =
        columns.x_axis.length_squared() + columns.y_axis.length_squared() + columns.z_axis.length_squared();
    let bound = largest.sqrt();
    let by_lengths = columns.x_axis.length().max(columns.y_axis.length()).max(columns.z_axis.length());
    let skew = columns
        .x_axis
        .dot(columns.y_axis)
        .abs()
        .max(columns.x_axis.dot(columns.z_axis).abs())
        .max(columns.y_axis.dot(columns.z_axis).abs());
    if skew <= 1e-9 * by_lengths * by_lengths { by_lengths } else { bound }
}
