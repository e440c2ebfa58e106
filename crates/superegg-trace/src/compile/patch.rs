//! A flat group of which only some leaves have changed: those leaves anew, and the boxes above them, in the tree that was there.
//!
//! A flat group has no children but primitives. Which leaf is where in its tree is no part of what rays meet, so the patched group answers as one
//! compiled anew.

use std::sync::{Arc, OnceLock};

use super::{Compiler, LeafMaps, NOWHERE, Parts, each};
use crate::bvh::{UnitBox, refit};
use crate::compiled::{Group, Leaf, NameRef, Names};

/// Smaller groups are compiled anew in less than a millisecond, and have the best tree then.
const LEAST_PATCHED: usize = 256;

/// A tree whose boxes have come to more than so much of the surface that they had when it was built is built again: rays meet boxes in
/// proportion to their surface.
const MOST_GROWTH: f64 = 4.0 / 3.0;

/// The group before a change, and where each child's leaf is in it.
pub(super) struct Patchable<'a> {
    group: &'a Group,
    seats: Vec<u32>,
}

impl<'a> Patchable<'a> {
    const NO_SEAT: u32 = u32::MAX;

    /// `None` where the group has to be compiled anew: it is small, or was not flat, or is not, or has more or fewer leaves now.
    pub(super) fn new(group: &'a Group, parts: &Parts<'_>) -> Option<Self> {
        let is_flat = parts.folded.is_empty()
            && parts.groups.is_empty()
            && group.instances.is_empty()
            && group.chains.is_empty();
        if !is_flat || parts.leaves.len() != group.leaves.len() || parts.leaves.len() < LEAST_PATCHED {
            return None;
        }
        let mut seats = vec![Self::NO_SEAT; parts.children.len()];
        for (seat, leaf) in group.leaves.iter().enumerate() {
            *seats.get_mut(leaf.name.as_child()? as usize)? = seat as u32;
        }
        Some(Self { group, seats })
    }

    /// The leaf that a child was.
    pub(super) fn leaf_before(&self, child: u32) -> Option<&'a Leaf> {
        self.group.leaves.get(self.seats[child as usize] as usize)
    }
}

impl<'a> Compiler<'a> {
    /// The group with some leaves changed: child and primitive of each. `None` where a new tree is called for.
    pub(super) fn patched(
        &self,
        before: &Patchable<'_>,
        parts: &Parts<'a>,
        changed: &[(u32, u32)],
        names: &Arc<Names>,
        signature: u64,
    ) -> Option<Group> {
        let Patchable { group, seats } = before;
        let primitives = &self.primitives;
        let patches: Vec<(u32, Leaf, UnitBox)> = each(changed, |&(child, primitive)| {
            let maps = parts.maps(&(child, primitive), primitives);
            let tight =
                |maps: &LeafMaps| group.space.unit_box(&maps.tight_box(&primitives[primitive as usize]));
            let unit_from_group = maps.as_ref().map_or(NOWHERE, |maps| maps.unit_from_group);
            let leaf = Leaf::new(unit_from_group, primitive, NameRef::child(child), primitives);
            (seats[child as usize], leaf, maps.as_ref().map_or(UnitBox::POINT, tight))
        })
        .collect();
        // Each leaf has one name, and there are as many as before: where all have a seat, each has its own.
        if patches.iter().any(|(seat, ..)| *seat == Patchable::NO_SEAT) {
            return None;
        }
        let boxes: Vec<(u32, UnitBox)> = patches.iter().map(|&(seat, _, bounds)| (seat, bounds)).collect();
        let refitted = refit(&group.nodes, group.leaves.len(), &boxes)?;
        let growth = group.growth * refitted.growth;
        if !refitted.is_within_space || growth.is_nan() || growth > MOST_GROWTH {
            return None;
        }
        let mut leaves: Vec<Leaf> = each(&group.leaves, |leaf| *leaf).collect();
        for (seat, leaf, _) in patches {
            leaves[seat as usize] = leaf;
        }
        Some(Group {
            leaves,
            instances: Vec::new(),
            bounds: group.space.bounds_of(&[refitted.bounds]),
            nodes: refitted.nodes,
            space: group.space,
            names: names.clone(),
            chains: Vec::new(),
            count: parts.primitive_count.into(),
            signature,
            growth,
            stand_in: OnceLock::new(),
        })
    }
}
