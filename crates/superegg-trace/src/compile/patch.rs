//! Patching a flat group: new leaves and boxes in the tree from before.
//!
//! A flat group has only primitives as children. Queries do not depend on the order of leaves in the tree, so a patched
//! group gives the answers of a group compiled from scratch.

use std::sync::{Arc, OnceLock};

use superegg_geom::Exponents;
use superegg_geom::glam::DAffine3;

use super::described::Described;
use super::parts::{LeafMaps, NO_MAP, Parts, map_all};
use crate::scene::bvh::refit;
use crate::scene::group::{Group, Leaf, NameRef, Names};
use crate::scene::node::TreeBox;
use crate::scene::primitive::Primitives;

/// Smaller groups are compiled in less than a millisecond, and get the best tree then.
const LEAST_PATCHED: usize = 256;

/// A tree is rebuilt once the surface area of its boxes exceeds this multiple of the area when the tree was built. The
/// number of boxes that rays hit is proportional to the area.
const MOST_GROWTH: f64 = 4.0 / 3.0;

/// The group before a change, with the seat of each child: the index of its leaf.
pub(super) struct Patchable<'a> {
    group: &'a Group,
    /// The primitives before the change.
    primitives: &'a Primitives,
    seats: Vec<Option<u32>>,
}

impl<'a> Patchable<'a> {
    /// `None` if the group cannot be patched: it is small, was or is not flat, or its number of leaves has changed.
    pub(super) fn new(group: &'a Group, primitives: &'a Primitives, parts: &Parts<'_>) -> Option<Self> {
        let is_flat = parts.folded.is_empty()
            && parts.groups.is_empty()
            && group.instances.is_empty()
            && group.folded.is_empty();
        if !is_flat || parts.leaves.len() != group.leaves.len() || parts.leaves.len() < LEAST_PATCHED {
            return None;
        }
        let mut seats = vec![None; parts.child_count()];
        for (seat, leaf) in group.leaves.iter().enumerate() {
            *seats.get_mut(leaf.name.as_child()? as usize)? = Some(seat as u32);
        }
        Some(Self { group, primitives, seats })
    }

    /// Whether a leaf (child, primitive) with this map differs from that of the child before.
    pub(super) fn has_changed(
        &self,
        (child, primitive): (u32, u32),
        unit_from_group: Option<DAffine3>,
        exponents: Exponents,
    ) -> bool {
        let leaf = self.seats[child as usize].and_then(|seat| self.group.leaves.get(seat as usize));
        let is_as_before = unit_from_group.zip(leaf).is_some_and(|(unit_from_group, leaf)| {
            leaf.primitive == primitive
                && leaf.unit_from_group == unit_from_group
                && self.primitives.exponents(leaf.primitive) == exponents
        });
        !is_as_before
    }
}

/// The group with the `changed` leaves (child, primitive) replaced. `None` if a new tree is needed.
pub(super) fn patched(
    before: &Patchable<'_>,
    parts: &Parts<'_>,
    described: &Described,
    changed: &[(u32, u32)],
    names: &Arc<Names>,
    signature: u64,
) -> Option<Group> {
    let Patchable { group, seats, .. } = before;
    let patches: Vec<(Option<u32>, Leaf, TreeBox)> = map_all(changed, |&(child, primitive)| {
        let maps = parts.maps(&(child, primitive), described);
        let tight = |maps: &LeafMaps| {
            group.space.tree_box(&maps.image(described.primitives.exponents(primitive)).tight_box())
        };
        let unit_from_group = maps.as_ref().map_or(NO_MAP, |maps| maps.unit_from_group);
        let leaf = Leaf::new(unit_from_group, primitive, NameRef::child(child), &described.primitives);
        (seats[child as usize], leaf, maps.as_ref().map_or(TreeBox::POINT, tight))
    });
    // The number of leaves is that of before, and each has one name: if all have a seat, each has its own.
    let boxes: Vec<(u32, TreeBox)> =
        patches.iter().map(|&(seat, _, bounds)| Some((seat?, bounds))).collect::<Option<_>>()?;
    let refitted = refit(&group.nodes, group.leaves.len(), &boxes)?;
    let growth = group.growth * refitted.growth;
    if !refitted.is_within_space || growth.is_nan() || growth > MOST_GROWTH {
        return None;
    }
    let mut leaves: Vec<Leaf> = map_all(&group.leaves, |leaf| *leaf);
    for ((seat, _), (_, leaf, _)) in boxes.iter().zip(patches) {
        leaves[*seat as usize] = leaf;
    }
    Some(Group {
        leaves,
        instances: Vec::new(),
        bounds: group.space.bounds_of(&[refitted.bounds]),
        nodes: refitted.nodes,
        space: group.space,
        names: names.clone(),
        folded: Vec::new(),
        work: group.work,
        has_one_child: group.has_one_child,
        count: parts.primitive_count.into(),
        signature,
        growth,
        proxy: OnceLock::new(),
    })
}
