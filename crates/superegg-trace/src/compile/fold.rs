//! Folding: the content of a small child group becomes part of its parent.
//!
//! Each group that a ray enters costs it a map, a frame and the tests of a tree's root. A group of few items costs more than
//! it spares, so its items go into the tree of the parent, and an object of one shape and itself becomes a few wide groups
//! instead of one for each level. Limits on the number of items keep the graph small, however deep it is.

use std::sync::Arc;

use superegg_geom::glam::{DAffine3, DMat3};
use superegg_geom::{Aabb, Transform, inverse_of};

use super::parts::{FoldedLeaf, GroupItem, LeafMaps, Parts};
use crate::scene::group::{FoldedName, Group, Instance, Leaf, NameRef};
use crate::scene::node::{Node, Slot};

/// Limits on what is folded into one group.
struct Limits {
    /// Groups of more items are not folded.
    most_folded: usize,
    /// Nothing is folded into a group that would have more items by that.
    most_items: usize,
}

/// The limits while little of the scene has been folded: rays enter as few groups as possible.
const WIDE: Limits = Limits { most_folded: 512, most_items: 4096 };
/// The limits of scenes whose many objects would take too much memory with wide groups.
const NARROW: Limits = Limits { most_folded: 64, most_items: 512 };
/// From this many folded items of a scene on, the limits are narrow. An item takes about 170 bytes.
const MOST_WIDE: usize = 1 << 17;
/// Nothing is folded into a group that would have more groups by that: their boxes take time to compile.
const MOST_GROUPS: usize = 32;
/// Boxes of a tree are f32, so a group stays out that has a primitive smaller than this part of the parent.
const LEAST_LEAF: f64 = 1.0 / (1 << 10) as f64;
/// A group stays out that has groups smaller than this part of the parent. Groups smaller than a pixel are hit as their proxies,
/// so a ray that opens a group a little larger than a pixel should not find many levels of detail in it.
const LEAST_GROUP: f64 = 1.0 / 8.0;
/// A group stays out whose groups take more than this part of its volume together. Nearly every ray through it meets several of
/// them, so a fold would show the ray all their parts before it has met the first.
const MOST_OVERLAP: f64 = 1.5;
/// The most that the product of a composed map and its inverse may differ from the identity, relative to the item.
const MOST_ERROR: f64 = 1e-9;

/// The content of a child in the parent's space.
struct Content {
    leaves: Vec<(NameRef, u32, LeafMaps)>,
    groups: Vec<(NameRef, Transform, Arc<Group>)>,
}

/// Folds the smallest groups of a parent into it while there is room. `leaf_box` is the box around its leaves, and
/// `folded_before` the number of items that were folded into other groups of the scene.
pub(super) fn fold(parts: &mut Parts<'_>, leaf_box: &Aabb, folded_before: usize) {
    let Limits { most_folded, most_items } = if folded_before < MOST_WIDE { WIDE } else { NARROW };
    let (mut item_count, mut group_count) = (parts.item_count(), parts.groups.len());
    let items = std::mem::take(&mut parts.groups);
    let parent_size = 2.0 * whole_box(&items, leaf_box).half_extent().length();
    let mut order: Vec<usize> = (0..items.len()).collect();
    order.sort_by_key(|&index| items[index].group.item_count());
    let mut contents: Vec<Option<Content>> = items.iter().map(|_| None).collect();
    for index in order {
        let item = &items[index];
        let (count, groups) = (item.group.item_count(), item.group.instances.len());
        let has_room = count <= most_folded
            && item_count + count <= most_items + 1
            && (groups <= 1 || group_count + groups <= MOST_GROUPS + 1);
        let is_of_use = || is_large_enough(item, parent_size) && !overlaps_much(&item.group);
        if count == 1 || (has_room && is_of_use()) {
            contents[index] = content(item);
            if contents[index].is_some() {
                item_count = item_count + count - 1;
                group_count = group_count + groups - 1;
            }
        }
    }
    for (item, content) in items.into_iter().zip(contents) {
        match content {
            Some(content) => push(parts, &item, content),
            None => parts.groups.push(item),
        }
    }
}

/// A box around leaves and groups.
fn whole_box(items: &[GroupItem], leaf_box: &Aabb) -> Aabb {
    let image = |item: &GroupItem| item.group.bounds.transformed(&item.parent_from_child);
    items.iter().fold(*leaf_box, |whole, item| whole.union(&image(item)))
}

/// Whether each item of a group is large enough for the tree of a parent of this size.
fn is_large_enough(item: &GroupItem, parent_size: f64) -> bool {
    let GroupItem { group, parent_from_child, .. } = item;
    let image_size = 2.0 * group.bounds.transformed(parent_from_child).half_extent().length();
    let scale = image_size / (group.size() * group.space.scale);
    group.nodes.iter().flat_map(Node::children).all(|(tree_box, slot)| {
        let least_part = match slot {
            Slot::Node(_) => return true,
            Slot::Leaf(_) => LEAST_LEAF,
            Slot::Instance(_) => LEAST_GROUP,
        };
        2.0 * tree_box.half_extent().length() * scale >= least_part * parent_size
    })
}

/// Whether the groups of a group fill it more than once. One group alone never does.
fn overlaps_much(group: &Group) -> bool {
    let volume = |tree_box: &Aabb| tree_box.half_extent().to_array().into_iter().product::<f64>();
    let mut whole = Aabb::EMPTY;
    let mut filled = 0.0;
    for (tree_box, slot) in group.nodes.iter().flat_map(Node::children) {
        whole = whole.union(&tree_box);
        if matches!(slot, Slot::Instance(_)) {
            filled += volume(&tree_box);
        }
    }
    group.instances.len() > 1 && filled > MOST_OVERLAP * volume(&whole)
}

/// The content of a child in the parent's space; `None` if a map cannot be composed well. The content of a group of one item
/// is taken if it can be composed at all.
fn content(item: &GroupItem) -> Option<Content> {
    let GroupItem { group, parent_from_child, .. } = item;
    let needs_check = group.item_count() > 1;
    let leaf = |leaf: &Leaf| {
        let maps = LeafMaps {
            unit_from_group: leaf.unit_from_group * *parent_from_child.inverse(),
            group_from_unit: *parent_from_child.forward() * inverse_of(&leaf.unit_from_group),
        };
        let is_exact = !needs_check || is_identity(&(maps.unit_from_group * maps.group_from_unit), 1.0);
        is_exact.then_some((leaf.name, leaf.primitive, maps))
    };
    let instance = |instance: &Instance| {
        let map = parent_from_child.after(instance.map()).ok()?;
        let is_exact = !needs_check || is_identity(&(*map.inverse() * *map.forward()), instance.group.size());
        is_exact.then(|| (instance.name, map, instance.group.clone()))
    };
    Some(Content {
        leaves: group.leaves.iter().map(leaf).collect::<Option<_>>()?,
        groups: group.instances.iter().map(instance).collect::<Option<_>>()?,
    })
}

/// Whether a map moves no point of an item of this size by more than a small part of the size.
fn is_identity(map: &DAffine3, size: f64) -> bool {
    let turned = map.matrix3 - DMat3::IDENTITY;
    let columns = [turned.x_axis, turned.y_axis, turned.z_axis];
    columns.iter().all(|column| column.abs().max_element() <= MOST_ERROR)
        && map.translation.abs().max_element() <= MOST_ERROR * size
}

/// Adds the content of a child to its parent.
fn push(parts: &mut Parts<'_>, item: &GroupItem, content: Content) {
    let Some(child) = item.name.as_child() else { return };
    let mut folded_name = |name: NameRef| {
        parts.folded_names.push(FoldedName { child, group: item.group.clone(), name });
        NameRef::folded(parts.folded_names.len() as u32 - 1)
    };
    for (name, primitive, maps) in content.leaves {
        parts.folded.push(FoldedLeaf { name: folded_name(name), primitive, maps });
    }
    for (name, parent_from_child, group) in content.groups {
        parts.groups.push(GroupItem { name: folded_name(name), parent_from_child, group });
    }
}
