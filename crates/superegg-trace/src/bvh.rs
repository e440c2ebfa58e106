//! The seam to the library that builds trees: boxes go in, a tree of boxes comes out, and no type of the library shows.
//!
//! Trees are eight wide. Their boxes are f32, rounded outwards, in a space of their own ([`TreeSpace`]) in which coordinates are of the order of
//! 1; so no scene is too large or too small for them.

use std::time::Duration;

use obvhs::BvhBuildParams;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2;
use rayon::prelude::*;
use superegg_geom::Aabb;
use superegg_geom::glam::{DAffine3, DMat3, DVec3, Vec3A};

/// Children of a node.
pub(crate) const WIDTH: usize = 8;

/// What a slot of a node leads to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Slot {
    /// A node of the same tree.
    Node(u32),
    /// A leaf: a primitive of the group.
    Leaf(u32),
    /// A child that is a group.
    Instance(u32),
}

/// A [`Slot`] in 32 bits.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct PackedSlot(u32);

impl PackedSlot {
    const INDEX: u32 = (1 << 30) - 1;

    pub(crate) fn new(slot: Slot) -> Self {
        match slot {
            Slot::Node(i) => Self(i & Self::INDEX),
            Slot::Leaf(i) => Self(1 << 30 | (i & Self::INDEX)),
            Slot::Instance(i) => Self(2 << 30 | (i & Self::INDEX)),
        }
    }

    pub(crate) fn unpack(self) -> Slot {
        let index = self.0 & Self::INDEX;
        match self.0 >> 30 {
            0 => Slot::Node(index),
            1 => Slot::Leaf(index),
            _ => Slot::Instance(index),
        }
    }
}

/// A node: the boxes of up to eight children, a column for each bound.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub(crate) struct Node {
    /// The least x, y and z of each child, then the largest ones.
    pub(crate) bounds: [[f32; WIDTH]; 6],
    pub(crate) slots: [PackedSlot; WIDTH],
    /// How many of them are in use.
    pub(crate) count: u32,
}

impl Node {
    /// Slots that are not in use hold a box that lies far from everything.
    const EMPTY: Self = Self { bounds: [[f32::MAX; WIDTH]; 6], slots: [PackedSlot(0); WIDTH], count: 0 };

    fn push(&mut self, bounds: &UnitBox, slot: Slot) {
        let place = self.count as usize;
        self.set_unit_box(place, bounds);
        self.slots[place] = PackedSlot::new(slot);
        self.count += 1;
    }

    fn unit_box(&self, place: usize) -> UnitBox {
        let corner = |first: usize| std::array::from_fn(|axis| self.bounds[first + axis][place]);
        UnitBox { min: corner(0), max: corner(3) }
    }

    fn set_unit_box(&mut self, place: usize, bounds: &UnitBox) {
        for axis in 0..3 {
            self.bounds[axis][place] = bounds.min[axis];
            self.bounds[axis + 3][place] = bounds.max[axis];
        }
    }

    /// The box around all children.
    fn whole_box(&self) -> UnitBox {
        (0..self.count as usize).fold(UnitBox::EMPTY, |whole, place| whole.union(&self.unit_box(place)))
    }

    pub(crate) fn slots(&self) -> impl Iterator<Item = Slot> {
        self.slots[..self.count as usize].iter().map(|slot| slot.unpack())
    }

    /// A bit for each slot that is a leaf.
    #[inline(always)]
    pub(crate) fn leaves(&self) -> u8 {
        let mut leaves = 0;
        for (place, slot) in self.slots.iter().enumerate() {
            leaves |= u8::from(slot.0 >> 30 == 1) << place;
        }
        leaves
    }

    /// The box of a child, in the tree's space.
    pub(crate) fn child_box(&self, place: usize) -> Aabb {
        let corner = |first: usize| {
            DVec3::from_array(std::array::from_fn(|axis| f64::from(self.bounds[first + axis][place])))
        };
        Aabb { min: corner(0), max: corner(3) }
    }
}

/// Where the boxes of a tree live: `(p - center) * scale`, the scale a power of two.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct TreeSpace {
    pub(crate) center: DVec3,
    pub(crate) scale: f64,
}

impl TreeSpace {
    /// The space in which a box of this size has half edges below 1.
    pub(crate) fn of(whole: &Aabb) -> Self {
        let center = whole.center();
        let extent = whole.half_extent().max_element();
        if !center.is_finite() || !extent.is_finite() || extent <= 0.0 {
            let scale = 1.0;
            return Self { center: if center.is_finite() { center } else { DVec3::ZERO }, scale };
        }
        let exponent = (extent.to_bits() >> 52) as i32 - 1022;
        Self { center, scale: f64::from_bits(((-exponent).clamp(-1000, 1000) + 1023) as u64 * (1 << 52)) }
    }

    /// A box, in f32 and rounded outwards.
    pub(crate) fn unit_box(&self, bounds: &Aabb) -> UnitBox {
        // Twice the rounding of the subtraction, which is that of the operands.
        let slack =
            4.0 * f64::EPSILON * (bounds.min.abs().max(bounds.max.abs()) + self.center.abs()) * self.scale;
        let min = (bounds.min - self.center) * self.scale - slack;
        let max = (bounds.max - self.center) * self.scale + slack;
        let known = |x: f64, otherwise: f64| if x.is_nan() { otherwise } else { x };
        UnitBox {
            min: std::array::from_fn(|axis| below(known(min[axis], f64::NEG_INFINITY))),
            max: std::array::from_fn(|axis| above(known(max[axis], f64::INFINITY))),
        }
    }
}

impl TreeSpace {
    /// The box around boxes of this space, outside of it.
    pub(crate) fn bounds_of(&self, boxes: &[UnitBox]) -> Aabb {
        let whole = whole_box(boxes.iter());
        let corner = |c: [f32; 3]| DVec3::from_array(c.map(f64::from));
        self.group_box(&Aabb { min: corner(whole.min), max: corner(whole.max) })
    }

    /// A box of this space, outside of it.
    pub(crate) fn group_box(&self, tree_box: &Aabb) -> Aabb {
        let corner = |c: DVec3| c / self.scale + self.center;
        Aabb { min: corner(tree_box.min), max: corner(tree_box.max) }.rounded_outward()
    }

    /// The map into this space.
    pub(crate) fn tree_from_group(&self) -> DAffine3 {
        DAffine3::from_mat3_translation(
            DMat3::from_diagonal(DVec3::splat(self.scale)),
            -self.center * self.scale,
        )
    }
}

/// Boxes end here: rays that see so far are in f64's hands.
const FARTHEST: f32 = 1e18;

/// An f32 not above.
fn below(x: f64) -> f32 {
    let nearest = x as f32;
    let below = if f64::from(nearest) > x { nearest.next_down() } else { nearest };
    below.clamp(-FARTHEST, FARTHEST)
}

/// An f32 not below.
fn above(x: f64) -> f32 {
    -below(-x)
}

/// A box in a tree's space.
#[derive(Clone, Copy, Debug)]
pub(crate) struct UnitBox {
    pub(crate) min: [f32; 3],
    pub(crate) max: [f32; 3],
}

impl UnitBox {
    /// A point in the middle.
    pub(crate) const POINT: Self = Self { min: [0.0; 3], max: [0.0; 3] };
    const EMPTY: Self = Self { min: [f32::INFINITY; 3], max: [f32::NEG_INFINITY; 3] };

    fn union(&self, other: &Self) -> Self {
        Self {
            min: std::array::from_fn(|axis| self.min[axis].min(other.min[axis])),
            max: std::array::from_fn(|axis| self.max[axis].max(other.max[axis])),
        }
    }

    fn half_area(&self) -> f32 {
        let [x, y, z] = std::array::from_fn(|axis| (self.max[axis] - self.min[axis]).max(0.0));
        x * y + y * z + z * x
    }

    fn center(&self, axis: usize) -> f32 {
        0.5 * (self.min[axis] + self.max[axis])
    }

    fn library_box(&self) -> obvhs::aabb::Aabb {
        obvhs::aabb::Aabb::new(Vec3A::from_array(self.min), Vec3A::from_array(self.max))
    }
}

/// A tree over items 0..n: node 0 is the root (there is none for no items), and leaf `i` is item `order[i]`.
#[derive(Clone, Debug, Default)]
pub(crate) struct Tree {
    pub(crate) nodes: Vec<Node>,
    pub(crate) order: Vec<u32>,
}

/// The library builds trees of at most so many items at a time: its memory goes with them, and each can be another thread's.
const CHUNK: usize = 1 << 15;

impl Tree {
    pub(crate) fn build(boxes: &[UnitBox]) -> Self {
        let mut order: Vec<u32> = (0..boxes.len() as u32).collect();
        if boxes.len() <= CHUNK {
            return Self::build_chunk(boxes, &order);
        }
        let mut chunks = Vec::new();
        cut(boxes, &mut order, &mut chunks);
        let trees: Vec<(Self, UnitBox)> = chunks
            .into_par_iter()
            .map(|chunk| {
                let tree = Self::build_chunk(boxes, chunk);
                (tree, whole_box(chunk.iter().map(|&item| &boxes[item as usize])))
            })
            .collect();
        drop(order);
        Self::join(&trees)
    }

    /// A tree over trees.
    fn join(trees: &[(Self, UnitBox)]) -> Self {
        let chunk_boxes: Vec<UnitBox> = trees.iter().map(|(_, bounds)| *bounds).collect();
        let all: Vec<u32> = (0..trees.len() as u32).collect();
        let mut joined = Self::build_chunk(&chunk_boxes, &all);
        let top_order = std::mem::take(&mut joined.order);
        let mut first_node = joined.nodes.len() as u32;
        let mut roots = vec![0; trees.len()];
        for ((tree, _), root) in trees.iter().zip(&mut roots) {
            *root = first_node;
            first_node += tree.nodes.len() as u32;
        }
        for node in &mut joined.nodes {
            for slot in &mut node.slots[..node.count as usize] {
                if let Slot::Leaf(place) = slot.unpack() {
                    *slot = PackedSlot::new(Slot::Node(roots[top_order[place as usize] as usize]));
                }
            }
        }
        let items: usize = trees.iter().map(|(tree, _)| tree.order.len()).sum();
        joined.order.reserve_exact(items);
        let mut first_items = Vec::with_capacity(trees.len());
        for (tree, _) in trees {
            first_items.push(joined.order.len() as u32);
            joined.order.extend(&tree.order);
        }
        let top = joined.nodes.len() as u32;
        joined.nodes.reserve_exact((first_node - top) as usize);
        joined.nodes.par_extend((top..first_node).into_par_iter().map(|place| {
            let tree = roots.partition_point(|root| *root <= place) - 1;
            let (nodes_before, items_before) = (roots[tree], first_items[tree]);
            let mut node = trees[tree].0.nodes[(place - nodes_before) as usize];
            for slot in &mut node.slots[..node.count as usize] {
                *slot = PackedSlot::new(match slot.unpack() {
                    Slot::Node(i) => Slot::Node(i + nodes_before),
                    Slot::Leaf(i) => Slot::Leaf(i + items_before),
                    Slot::Instance(i) => Slot::Instance(i),
                });
            }
            node
        }));
        joined
    }

    /// The tree of some of the boxes, by the library.
    fn build_chunk(boxes: &[UnitBox], items: &[u32]) -> Self {
        if items.len() <= WIDTH {
            let mut node = Node::EMPTY;
            for (place, &item) in items.iter().enumerate() {
                node.push(&boxes[item as usize], Slot::Leaf(place as u32));
            }
            return Self { nodes: if items.is_empty() { vec![] } else { vec![node] }, order: items.to_vec() };
        }
        let library_boxes: Vec<_> = items.iter().map(|&item| boxes[item as usize].library_box()).collect();
        // One item a leaf: asking a shape costs more than asking a box.
        let params = BvhBuildParams { max_prims_per_leaf: 1, ..BvhBuildParams::fast_build() };
        let binary = build_bvh2(&library_boxes, params, &mut Duration::default());
        drop(library_boxes);
        let mut tree =
            Self { nodes: Vec::with_capacity(items.len() / 4), order: Vec::with_capacity(items.len()) };
        tree.widen(&binary, boxes, items);
        tree.nodes.shrink_to_fit();
        tree
    }

    /// Makes eight-wide nodes of binary ones. Of a node's children the one with the largest surface is opened first; one that will fill a node of
    /// its own stays whole as long as there are others, and what is left of the places goes to the smallest.
    fn widen(&mut self, binary: &Bvh2, boxes: &[UnitBox], items: &[u32]) {
        let sizes = leaf_counts(binary);
        let size = |index: u32| sizes[index as usize] as usize;
        self.nodes.push(Node::EMPTY);
        let mut pending = vec![(0u32, 0usize)];
        let is_leaf = |index: u32| binary.nodes[index as usize].prim_count > 0;
        let bounds = |index: u32| {
            let aabb = &binary.nodes[index as usize].aabb;
            UnitBox { min: aabb.min.to_array(), max: aabb.max.to_array() }
        };
        let area = |index: u32| bounds(index).half_area();
        while let Some((index, place)) = pending.pop() {
            let first = binary.nodes[index as usize].first_index;
            let mut children = arrayvec::ArrayVec::<u32, WIDTH>::from_iter([first, first + 1]);
            while !children.is_full() {
                let room = children.remaining_capacity() + 1;
                let large = (0..children.len())
                    .filter(|&i| size(children[i]) > WIDTH)
                    .max_by(|&a, &b| area(children[a]).total_cmp(&area(children[b])));
                let small = || {
                    let inner =
                        (0..children.len()).filter(|&i| !is_leaf(children[i]) && size(children[i]) <= room);
                    inner.min_by_key(|&i| size(children[i]))
                };
                let Some(opened) = large.or_else(small) else { break };
                let first = binary.nodes[children[opened] as usize].first_index;
                children[opened] = first;
                children.push(first + 1);
            }
            let mut node = Node::EMPTY;
            for child in children {
                if is_leaf(child) {
                    let item = items[binary.primitive_indices
                        [binary.nodes[child as usize].first_index as usize]
                        as usize];
                    node.push(&boxes[item as usize], Slot::Leaf(self.order.len() as u32));
                    self.order.push(item);
                } else {
                    node.push(&bounds(child), Slot::Node(self.nodes.len() as u32));
                    pending.push((child, self.nodes.len()));
                    self.nodes.push(Node::EMPTY);
                }
            }
            self.nodes[place] = node;
        }
    }
}

/// A tree with other boxes for some leaves.
#[derive(Debug)]
pub(crate) struct Refitted {
    pub(crate) nodes: Vec<Node>,
    /// Around everything.
    pub(crate) bounds: UnitBox,
    /// The surface of all boxes, as a multiple of what it was.
    pub(crate) growth: f64,
    /// Whether everything is still where the tree's space is as fine as it was made to be.
    pub(crate) is_within_space: bool,
}

/// Gives some leaves of a tree other boxes, and fits those of the nodes above them. `None` for a tree of no nodes.
pub(crate) fn refit(nodes: &[Node], leaf_count: usize, changed: &[(u32, UnitBox)]) -> Option<Refitted> {
    const UNCHANGED: u32 = u32::MAX;
    let bounds_before = nodes.first()?.whole_box();
    let mut change_of = vec![UNCHANGED; leaf_count];
    for (change, (leaf, _)) in changed.iter().enumerate() {
        change_of[*leaf as usize] = change as u32;
    }
    let mut nodes: Vec<Node> = nodes.par_iter().copied().collect();
    let mut is_changed = vec![false; nodes.len()];
    let (mut area_before, mut area_more) = (0.0, 0.0);
    // Parents come before their children.
    for index in (0..nodes.len()).rev() {
        for place in 0..nodes[index].count as usize {
            let old = nodes[index].unit_box(place);
            area_before += f64::from(old.half_area());
            let new = match nodes[index].slots[place].unpack() {
                Slot::Node(child) if is_changed[child as usize] => nodes[child as usize].whole_box(),
                Slot::Leaf(leaf) if change_of[leaf as usize] != UNCHANGED => {
                    changed[change_of[leaf as usize] as usize].1
                }
                _ => continue,
            };
            area_more += f64::from(new.half_area()) - f64::from(old.half_area());
            nodes[index].set_unit_box(place, &new);
            is_changed[index] = true;
        }
    }
    let bounds = nodes[0].whole_box();
    // Around the space's middle, half edges are below 1; when everything is small in it, f32 is coarse.
    let farthest = bounds.min.iter().chain(&bounds.max).fold(0.0, |most: f32, x| most.max(x.abs()));
    let is_within_space = farthest <= 1.0 && bounds.half_area() >= bounds_before.half_area() / 16.0;
    Some(Refitted { nodes, bounds, growth: 1.0 + area_more / area_before, is_within_space })
}

/// How many leaves are below each node.
fn leaf_counts(binary: &Bvh2) -> Vec<u32> {
    let mut counts = vec![0; binary.nodes.len()];
    let mut pending = vec![(0usize, false)];
    while let Some((index, children_done)) = pending.pop() {
        let node = &binary.nodes[index];
        let first = node.first_index as usize;
        if node.prim_count > 0 {
            counts[index] = 1;
        } else if children_done {
            counts[index] = counts[first] + counts[first + 1];
        } else {
            pending.extend([(index, true), (first, false), (first + 1, false)]);
        }
    }
    counts
}

fn whole_box<'a>(boxes: impl Iterator<Item = &'a UnitBox>) -> UnitBox {
    boxes.fold(UnitBox::EMPTY, |whole, b| whole.union(b))
}

/// Cuts items at the median of the widest axis of their centres until each part is small enough.
fn cut<'a>(boxes: &[UnitBox], items: &'a mut [u32], parts: &mut Vec<&'a mut [u32]>) {
    if items.len() <= CHUNK {
        parts.push(items);
        return;
    }
    let center = |item: u32, axis: usize| boxes[item as usize].center(axis);
    let extent = |axis: usize| {
        let (least, most) = items.iter().fold((f32::INFINITY, f32::NEG_INFINITY), |(least, most), &item| {
            (least.min(center(item, axis)), most.max(center(item, axis)))
        });
        most - least
    };
    let extents = [extent(0), extent(1), extent(2)];
    let axis = (0..3).max_by(|&a, &b| extents[a].total_cmp(&extents[b])).unwrap_or(0);
    let middle = items.len() / 2;
    items
        .select_nth_unstable_by(middle, |&a, &b| center(a, axis).total_cmp(&center(b, axis)).then(a.cmp(&b)));
    let (before, after) = items.split_at_mut(middle);
    let (mut first, mut second) = (Vec::new(), Vec::new());
    rayon::join(|| cut(boxes, before, &mut first), || cut(boxes, after, &mut second));
    parts.extend(first);
    parts.extend(second);
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every item is in one leaf, and within the box of each node above it.
    fn check(boxes: &[Aabb]) {
        let space = TreeSpace::of(&boxes.iter().fold(Aabb::EMPTY, |whole, b| whole.union(b)));
        let boxes: Vec<UnitBox> = boxes.iter().map(|b| space.unit_box(b)).collect();
        let tree = Tree::build(&boxes);
        let mut seen = vec![0; boxes.len()];
        let mut pending: Vec<(u32, Vec<Aabb>)> = if boxes.is_empty() { vec![] } else { vec![(0, vec![])] };
        while let Some((index, above)) = pending.pop() {
            let node = &tree.nodes[index as usize];
            for (place, slot) in node.slots().enumerate() {
                let mut above = above.clone();
                above.push(node.child_box(place));
                match slot {
                    Slot::Node(child) => pending.push((child, above)),
                    Slot::Leaf(leaf) => {
                        let item = tree.order[leaf as usize] as usize;
                        seen[item] += 1;
                        let corner = |c: [f32; 3]| DVec3::from_array(c.map(f64::from));
                        let (min, max) = (corner(boxes[item].min), corner(boxes[item].max));
                        assert!(above.iter().all(|b| b.contains(min) && b.contains(max)));
                    }
                    Slot::Instance(_) => panic!("items are leaves"),
                }
            }
        }
        assert!(seen.iter().all(|&count| count == 1), "{seen:?}");
    }

    #[test]
    fn holds_every_item_once_whatever_the_boxes() {
        let at = |x: f64, y: f64, r: f64| Aabb::around(DVec3::new(x, y, 0.0), DVec3::splat(r));
        for count in [0, 1, 2, 3, 4, 8, 9, 100, 2 * CHUNK as i32 + 7] {
            check(
                &(0..count)
                    .map(|i| at(f64::from(i * 7 % 1013), f64::from(i * 5 % 911), 0.3))
                    .collect::<Vec<_>>(),
            );
        }
        for count in [1, 9, 100] {
            check(&vec![at(1.0, 2.0, 0.5); count as usize]);
            check(
                &(0..count).map(|i| at(1e-40 * f64::from(i), 1e30 * f64::from(i), 1e-50)).collect::<Vec<_>>(),
            );
        }
        check(&[at(1e308, 0.0, 1e308), at(-1e308, 0.0, 1e308), at(0.0, 0.0, 1.0)]);
    }

    #[test]
    fn a_refitted_tree_has_the_boxes_of_its_leaves() {
        let at = |i: i32, r: f32| {
            let middle = [i * 7 % 101, i * 5 % 91, i % 13].map(|x| x as f32 / 101.0);
            UnitBox { min: middle.map(|x| x - r), max: middle.map(|x| x + r) }
        };
        for count in [1, 8, 9, 100, CHUNK as i32 + 7] {
            let boxes: Vec<UnitBox> = (0..count).map(|i| at(i, 0.01)).collect();
            let tree = Tree::build(&boxes);
            let mut items: Vec<UnitBox> = tree.order.iter().map(|&item| boxes[item as usize]).collect();
            let changed: Vec<(u32, UnitBox)> =
                (0..count).step_by(5).map(|leaf| (leaf as u32, at(3 * leaf + 1, 0.02))).collect();
            changed.iter().for_each(|&(leaf, bounds)| items[leaf as usize] = bounds);
            let area = |nodes: &[Node]| -> f64 {
                let boxes = nodes.iter().flat_map(|n| (0..n.count as usize).map(|place| n.unit_box(place)));
                boxes.map(|b| f64::from(b.half_area())).sum()
            };
            let refitted = refit(&tree.nodes, items.len(), &changed).unwrap();
            for node in &refitted.nodes {
                for (place, slot) in node.slots().enumerate() {
                    let expected = match slot {
                        Slot::Node(child) => refitted.nodes[child as usize].whole_box(),
                        Slot::Leaf(leaf) => items[leaf as usize],
                        Slot::Instance(_) => panic!("items are leaves"),
                    };
                    assert_eq!(
                        (node.unit_box(place).min, node.unit_box(place).max),
                        (expected.min, expected.max)
                    );
                }
            }
            let whole = whole_box(items.iter());
            assert_eq!((refitted.bounds.min, refitted.bounds.max), (whole.min, whole.max));
            let growth = area(&refitted.nodes) / area(&tree.nodes);
            assert!((refitted.growth / growth - 1.0).abs() < 1e-9, "{} {growth}", refitted.growth);
        }
    }

    #[test]
    fn boxes_are_rounded_outwards() {
        let space = TreeSpace { center: DVec3::new(0.1, 0.2, 0.3), scale: 1.0 / 64.0 };
        for i in 0..1000 {
            let at = DVec3::new((f64::from(i)).sin(), (1.7 * f64::from(i)).cos(), f64::from(i) * 0.01);
            let unit = space.unit_box(&Aabb { min: at, max: at });
            let exact = (at - space.center) / 64.0;
            for axis in 0..3 {
                assert!(f64::from(unit.min[axis]) <= exact[axis] && exact[axis] <= f64::from(unit.max[axis]));
            }
        }
    }
}
