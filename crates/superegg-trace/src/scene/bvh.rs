//! Building and refitting bounding volume hierarchies.
//!
//! Only this file uses the library that builds binary trees. Boxes go in and a tree of eight-wide nodes comes out.

use std::sync::Mutex;

use obvhs::BvhBuildParams;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::reinsertion::ReinsertionOptimizer;
use obvhs::ploc::PlocBuilder;
use rayon::prelude::*;
use smallvec::SmallVec;
use superegg_geom::glam::Vec3A;

use super::node::{Node, Slot, TreeBox, WIDTH, whole_box};

/// A tree over items 0..n. Node 0 is the root; no items make no nodes. Leaf `i` is item `order[i]`.
#[derive(Clone, Debug, Default)]
pub(crate) struct Tree {
    pub(crate) nodes: Vec<Node>,
    pub(crate) order: Vec<u32>,
}

/// The most items of one call of the library. It bounds the library's memory, and chunks are built in parallel.
const CHUNK: usize = 1 << 15;

impl Tree {
    pub(crate) fn build(boxes: &[TreeBox]) -> Self {
        if boxes.len() <= CHUNK {
            let mut tree = Self::default();
            let items = (0..boxes.len() as u32).collect();
            let mut workspace = Workspace { items, boxes: boxes.to_vec(), ..Workspace::default() };
            tree.build_chunk(&mut workspace);
            tree.nodes.shrink_to_fit();
            return tree;
        }
        let mut items: Vec<Item> = (0..).zip(boxes).map(|(item, &bounds)| Item { bounds, item }).collect();
        let mut chunks = Vec::new();
        cut(&mut items, &mut chunks);
        let box_of = |chunk: &&mut [Item]| whole_box(chunk.iter().map(|item| &item.bounds));
        let chunk_boxes: Vec<TreeBox> = chunks.par_iter().map(box_of).collect();
        // Memory that is freed and taken again for each chunk costs as much as a tenth of the time.
        let workspaces: Mutex<Vec<Workspace>> = Mutex::default();
        let build = |(chunk, tree): (&&mut [Item], &mut Self)| {
            let mut workspace = workspaces.lock().ok().and_then(|mut free| free.pop()).unwrap_or_default();
            workspace.items.clear();
            workspace.items.extend(chunk.iter().map(|item| item.item));
            workspace.boxes.clear();
            workspace.boxes.extend(chunk.iter().map(|item| item.bounds));
            tree.build_chunk(&mut workspace);
            if let Ok(mut free) = workspaces.lock() {
                free.push(workspace);
            }
        };
        let mut joined = Joined::new(&chunk_boxes, boxes.len());
        // Each tree is copied before many others are built.
        let mut trees = vec![Self::default(); 2 * rayon::current_num_threads()];
        for some in chunks.chunks(trees.len()) {
            some.par_iter().zip(&mut trees).for_each(build);
            trees[..some.len()].iter().for_each(|tree| joined.push(tree));
        }
        joined.finish()
    }

    /// Becomes the tree of the items of a workspace.
    fn build_chunk(&mut self, workspace: &mut Workspace) {
        self.nodes.clear();
        self.order.clear();
        let Workspace { items, boxes, .. } = workspace;
        if items.len() <= WIDTH {
            let leaves: SmallVec<[Slot; WIDTH]> = (0..items.len() as u32).map(Slot::Leaf).collect();
            self.nodes.extend((!items.is_empty()).then(|| Node::new(boxes, &leaves)));
            self.order.extend_from_slice(items);
            return;
        }
        self.nodes.reserve(items.len() / 4);
        self.order.reserve(items.len());
        workspace.build_binary();
        self.widen(workspace);
    }

    /// Collapses a binary tree to eight-wide nodes.
    ///
    /// A node replaces its child of the largest surface area by that child's children, as long as the child holds more
    /// than a node's worth of leaves. The slots that remain go to the smallest children.
    fn widen(&mut self, workspace: &Workspace) {
        let Workspace { items, binary, subtrees, .. } = workspace;
        self.nodes.push(Node::EMPTY);
        let mut pending = vec![(0u32, 0usize)];
        while let Some((index, wide_index)) = pending.pop() {
            // The node itself is the first to be opened.
            let mut children = Children { count: 1, ..Children::default() };
            children.open(0, binary.nodes[index as usize].first_index, subtrees);
            while let Some(opened) = children.to_open() {
                let first = binary.nodes[children.indices[opened] as usize].first_index;
                children.open(opened, first, subtrees);
            }
            let mut boxes = [TreeBox::POINT; WIDTH];
            let mut slots = [Slot::Leaf(0); WIDTH];
            for child in 0..children.count {
                let index = children.indices[child];
                boxes[child] = subtrees[index as usize].bounds;
                if children.sizes[child] == 1 {
                    let first = binary.nodes[index as usize].first_index as usize;
                    slots[child] = Slot::Leaf(self.order.len() as u32);
                    self.order.push(items[binary.primitive_indices[first] as usize]);
                } else {
                    slots[child] = Slot::Node(self.nodes.len() as u32);
                    pending.push((index, self.nodes.len()));
                    self.nodes.push(Node::EMPTY);
                }
            }
            self.nodes[wide_index] = Node::new(&boxes[..children.count], &slots[..children.count]);
        }
    }
}

/// The children of a wide node while they are opened.
#[derive(Default)]
struct Children {
    count: usize,
    /// Their nodes of the binary tree.
    indices: [u32; WIDTH],
    /// Their numbers of leaves.
    sizes: [u32; WIDTH],
    /// The areas of those that hold more than a node's worth of leaves; otherwise negative.
    areas: [f32; WIDTH],
}

impl Children {
    /// Replaces a child by its pair of binary nodes.
    fn open(&mut self, child: usize, first: u32, subtrees: &[Subtree]) {
        self.set(child, first, subtrees);
        self.set(self.count, first + 1, subtrees);
        self.count += 1;
    }

    fn set(&mut self, at: usize, index: u32, subtrees: &[Subtree]) {
        let Subtree { leaves, half_area, .. } = subtrees[index as usize];
        self.indices[at] = index;
        self.sizes[at] = leaves;
        self.areas[at] = if leaves as usize > WIDTH { half_area } else { -1.0 };
    }

    /// The next child to open, if there is room.
    fn to_open(&self) -> Option<usize> {
        let room = WIDTH - self.count;
        if room == 0 {
            return None;
        }
        let (mut largest, mut area) = (None, 0.0);
        for child in 0..self.count {
            if self.areas[child] >= area {
                (largest, area) = (Some(child), self.areas[child]);
            }
        }
        let fits = |&child: &usize| (2..=room + 1).contains(&(self.sizes[child] as usize));
        largest.or_else(|| (0..self.count).filter(fits).min_by_key(|&child| self.sizes[child]))
    }
}

/// Memory to build trees in, one after the other.
#[derive(Default)]
struct Workspace {
    items: Vec<u32>,
    /// The box of each item.
    boxes: Vec<TreeBox>,
    /// The boxes in the type of the library.
    library_boxes: Vec<obvhs::aabb::Aabb>,
    builder: PlocBuilder,
    optimizer: ReinsertionOptimizer,
    /// The binary tree.
    binary: Bvh2,
    /// The content below each of its nodes.
    subtrees: Vec<Subtree>,
}

impl Workspace {
    /// Builds the binary tree over the items, one in each leaf.
    fn build_binary(&mut self) {
        let Self { items, boxes, library_boxes, builder, optimizer, binary, subtrees } = self;
        library_boxes.clear();
        let untied = boxes.iter().zip(&*items).map(|(bounds, &item)| untied(bounds, item));
        library_boxes.extend(untied.map(|bounds| library_box(&bounds)));
        let BvhBuildParams {
            ploc_search_distance,
            search_depth_threshold,
            reinsertion_batch_ratio,
            sort_precision,
            ..
        } = BvhBuildParams::fast_build();
        let mut indices = std::mem::take(&mut binary.primitive_indices);
        indices.clear();
        indices.extend(0..boxes.len() as u32);
        builder.build_with_bvh(
            binary,
            ploc_search_distance,
            library_boxes,
            indices,
            sort_precision,
            search_depth_threshold,
        );
        // Leaves are not joined: a shape test costs more than a box test.
        optimizer.run(binary, reinsertion_batch_ratio, None);
        find_subtrees(binary, boxes, subtrees);
    }
}

/// Trees that are joined under a tree over their boxes.
struct Joined {
    /// The tree over the boxes, whose leaves have become nodes: the roots of the trees. Behind it are their other nodes.
    tree: Tree,
    /// The node that the root of each tree becomes.
    roots: std::vec::IntoIter<usize>,
}

impl Joined {
    /// No trees yet; these are the boxes around each.
    fn new(boxes: &[TreeBox], item_count: usize) -> Self {
        let top = Tree::build(boxes);
        // Nodes have about six children. Memory that is not written is not resident.
        let mut nodes = Vec::with_capacity(item_count / 4);
        nodes.push(Node::EMPTY);
        let mut roots = vec![0; boxes.len()];
        let mut pending = vec![(0, 0)];
        while let Some((from, to)) = pending.pop() {
            let node: &Node = &top.nodes[from];
            let slots: SmallVec<[Slot; WIDTH]> =
                (nodes.len() as u32..).take(node.count.into()).map(Slot::Node).collect();
            for slot in node.slots() {
                match slot {
                    Slot::Node(inner) => pending.push((inner as usize, nodes.len())),
                    Slot::Leaf(leaf) => roots[top.order[leaf as usize] as usize] = nodes.len(),
                    Slot::Instance(_) => {}
                }
                nodes.push(Node::EMPTY);
            }
            nodes[to] = Node::new(&node.tree_boxes(), &slots);
        }
        Self { tree: Tree { nodes, order: Vec::with_capacity(item_count) }, roots: roots.into_iter() }
    }

    /// Adds the next tree.
    fn push(&mut self, tree: &Tree) {
        let Tree { nodes, order } = &mut self.tree;
        let (Some((root, others)), Some(to)) = (tree.nodes.split_first(), self.roots.next()) else { return };
        // The root is not among the other nodes.
        let (nodes_before, items_before) = (nodes.len() as u32 - 1, order.len() as u32);
        order.extend_from_slice(&tree.order);
        nodes[to] = root.moved(nodes_before, items_before);
        nodes.extend(others.iter().map(|node| node.moved(nodes_before, items_before)));
    }

    /// The whole tree.
    fn finish(self) -> Tree {
        let mut tree = self.tree;
        tree.nodes.shrink_to_fit();
        tree
    }
}

/// A tree after some leaves have changed their boxes.
#[derive(Debug)]
pub(crate) struct Refitted {
    pub(crate) nodes: Vec<Node>,
    /// The box around everything.
    pub(crate) bounds: TreeBox,
    /// The surface area of all boxes, as a multiple of that before.
    pub(crate) growth: f64,
    /// Whether the tree's space still fits: nothing lies outside, and nothing is too small for f32 in it.
    pub(crate) is_within_space: bool,
}

/// Gives leaves (index, new box) new boxes and refits the nodes above them. `None` for a tree without nodes.
pub(crate) fn refit(nodes: &[Node], leaf_count: usize, changed: &[(u32, TreeBox)]) -> Option<Refitted> {
    let bounds_before = nodes.first()?.whole_box();
    let mut change_of: Vec<Option<u32>> = vec![None; leaf_count];
    for (change, (leaf, _)) in (0..).zip(changed) {
        change_of[*leaf as usize] = Some(change);
    }
    let mut nodes: Vec<Node> = nodes.par_iter().copied().collect();
    let mut is_changed = vec![false; nodes.len()];
    let (mut area_before, mut area_more) = (0.0, 0.0);
    // Parents come before their children.
    for index in (0..nodes.len()).rev() {
        let mut boxes = nodes[index].tree_boxes();
        let before = area_of(&boxes);
        area_before += before;
        for (held, slot) in boxes.iter_mut().zip(nodes[index].slots()) {
            *held = match slot {
                Slot::Node(child) if is_changed[child as usize] => nodes[child as usize].whole_box(),
                Slot::Leaf(leaf) => match change_of[leaf as usize] {
                    Some(change) => changed[change as usize].1,
                    None => continue,
                },
                Slot::Node(_) | Slot::Instance(_) => continue,
            };
            is_changed[index] = true;
        }
        if is_changed[index] {
            nodes[index].set_boxes(&boxes);
            area_more += area_of(&nodes[index].tree_boxes()) - before;
        }
    }
    let bounds = nodes[0].whole_box();
    // Half edges were below 1. If everything has become much smaller than the space, f32 is too coarse.
    let farthest = bounds.min.iter().chain(&bounds.max).fold(0.0, |most: f32, x| most.max(x.abs()));
    let is_within_space = farthest <= 1.0 && bounds.half_area() >= bounds_before.half_area() / 16.0;
    Some(Refitted { nodes, bounds, growth: 1.0 + area_more / area_before, is_within_space })
}

fn area_of(boxes: &[TreeBox]) -> f64 {
    boxes.iter().map(|held| f64::from(held.half_area())).sum()
}

/// The content below a node of the binary tree.
#[derive(Clone, Copy)]
struct Subtree {
    /// The number of leaves.
    leaves: u32,
    /// The box around them.
    bounds: TreeBox,
    half_area: f32,
}

impl Subtree {
    fn new(leaves: u32, bounds: TreeBox) -> Self {
        Self { leaves, bounds, half_area: bounds.half_area() }
    }

    fn is_known(&self) -> bool {
        self.leaves > 0
    }
}

/// The content below each node. The library's own boxes are those that it got, which are moved.
fn find_subtrees(binary: &Bvh2, boxes: &[TreeBox], subtrees: &mut Vec<Subtree>) {
    subtrees.clear();
    subtrees.resize(binary.nodes.len(), Subtree::new(0, TreeBox::POINT));
    let find = |subtrees: &mut [Subtree], index: usize| {
        let node = &binary.nodes[index];
        let first = node.first_index as usize;
        if node.prim_count > 0 {
            subtrees[index] = Subtree::new(1, boxes[binary.primitive_indices[first] as usize]);
            return true;
        }
        let (left, right) = (&subtrees[first], &subtrees[first + 1]);
        let is_known = left.is_known() && right.is_known();
        if is_known {
            subtrees[index] = Subtree::new(left.leaves + right.leaves, left.bounds.union(&right.bounds));
        }
        is_known
    };
    // Nearly all nodes come before their children. The library has moved a few.
    for index in (0..binary.nodes.len()).rev() {
        find(subtrees, index);
    }
    let mut pending = vec![0];
    while let Some(&index) = pending.last() {
        if find(subtrees, index) {
            pending.pop();
        } else {
            let first = binary.nodes[index].first_index as usize;
            pending.extend([first, first + 1].iter().filter(|&&child| !subtrees[child].is_known()));
        }
    }
}

/// How far a box is moved for the library, as a part of its size.
const MOVE: f32 = 1e-3;
/// The least move: some units in the last place of coordinates near 1.
const LEAST_MOVE: f32 = 1e-6;

/// A box moved by a hash of its item, so that no two unions have the same surface area.
///
/// The library (PLOC) merges boxes that are each other's nearest. In a row of equal distances, or
/// among boxes in one place, all distances are ties, so one pair is merged in each of its rounds and
/// building takes quadratic time. Moved boxes decide the shape of the tree only; its boxes are those of
/// the items.
fn untied(bounds: &TreeBox, item: u32) -> TreeBox {
    let mut hash = item.wrapping_mul(0x9e37_79b9) ^ 0x85eb_ca6b;
    let by: [f32; 3] = std::array::from_fn(|axis| {
        hash = (hash ^ (hash >> 15)).wrapping_mul(0x2c1b_3c6d);
        hash ^= hash >> 12;
        let unit = (hash >> 8) as f32 / (1 << 23) as f32 - 1.0;
        unit * (MOVE * (bounds.max[axis] - bounds.min[axis])).max(LEAST_MOVE)
    });
    TreeBox {
        min: std::array::from_fn(|axis| bounds.min[axis] + by[axis]),
        max: std::array::from_fn(|axis| bounds.max[axis] + by[axis]),
    }
}

/// An item with its box, so that the boxes of a chunk lie side by side.
#[derive(Clone, Copy)]
struct Item {
    bounds: TreeBox,
    item: u32,
}

/// Splits items at the median of the widest axis of the centers of their boxes until each part is small enough.
fn cut<'a>(items: &'a mut [Item], parts: &mut Vec<&'a mut [Item]>) {
    if items.len() <= CHUNK {
        parts.push(items);
        return;
    }
    let (mut least, mut most) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
    for Item { bounds, .. } in &*items {
        for axis in 0..3 {
            least[axis] = least[axis].min(bounds.center(axis));
            most[axis] = most[axis].max(bounds.center(axis));
        }
    }
    let extent = |axis: usize| most[axis] - least[axis];
    let axis = (0..3).max_by(|&a, &b| extent(a).total_cmp(&extent(b))).unwrap_or(0);
    let middle = items.len() / 2;
    items.select_nth_unstable_by(middle, |a, b| {
        a.bounds.center(axis).total_cmp(&b.bounds.center(axis)).then(a.item.cmp(&b.item))
    });
    let (before, after) = items.split_at_mut(middle);
    let (mut first, mut second) = (Vec::new(), Vec::new());
    rayon::join(|| cut(before, &mut first), || cut(after, &mut second));
    parts.extend(first);
    parts.extend(second);
}

/// The box in the type of the library.
fn library_box(bounds: &TreeBox) -> obvhs::aabb::Aabb {
    obvhs::aabb::Aabb::new(Vec3A::from_array(bounds.min), Vec3A::from_array(bounds.max))
}

#[cfg(test)]
mod tests {
    use super::*;

    use superegg_geom::Aabb;
    use superegg_geom::glam::DVec3;

    use super::super::node::TreeSpace;
    /// Every item is in one leaf, and within the box of each node above it.
    fn check(boxes: &[Aabb]) {
        let space = TreeSpace::of(&boxes.iter().fold(Aabb::EMPTY, |whole, b| whole.union(b)));
        let boxes: Vec<TreeBox> = boxes.iter().map(|b| space.tree_box(b)).collect();
        let tree = Tree::build(&boxes);
        let mut seen = vec![0; boxes.len()];
        let mut pending: Vec<(u32, Vec<Aabb>)> = if boxes.is_empty() { vec![] } else { vec![(0, vec![])] };
        while let Some((index, above)) = pending.pop() {
            for (child_box, slot) in tree.nodes[index as usize].children() {
                let mut above = above.clone();
                above.push(child_box);
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
            TreeBox { min: middle.map(|x| x - r), max: middle.map(|x| x + r) }
        };
        for count in [1, 8, 9, 100, CHUNK as i32 + 7] {
            let boxes: Vec<TreeBox> = (0..count).map(|i| at(i, 0.01)).collect();
            let tree = Tree::build(&boxes);
            let mut items: Vec<TreeBox> = tree.order.iter().map(|&item| boxes[item as usize]).collect();
            let changed: Vec<(u32, TreeBox)> =
                (0..count).step_by(5).map(|leaf| (leaf as u32, at(3 * leaf + 1, 0.02))).collect();
            changed.iter().for_each(|&(leaf, bounds)| items[leaf as usize] = bounds);
            let area = |nodes: &[Node]| -> f64 { nodes.iter().map(|node| area_of(&node.tree_boxes())).sum() };
            let refitted = refit(&tree.nodes, items.len(), &changed).unwrap();
            // Bounds are rounded outwards to steps of their node, and once more if the node changes.
            let is_around = |held: &TreeBox, expected: &TreeBox, node: &TreeBox| {
                (0..3).all(|axis| {
                    let slack = 2.0 * (node.max[axis] - node.min[axis]) / 32_000.0;
                    let (below, above) =
                        (expected.min[axis] - held.min[axis], held.max[axis] - expected.max[axis]);
                    (0.0..=slack).contains(&below) && (0.0..=slack).contains(&above)
                })
            };
            for node in &refitted.nodes {
                for (child, slot) in node.slots().enumerate() {
                    let expected = match slot {
                        Slot::Node(child) => refitted.nodes[child as usize].whole_box(),
                        Slot::Leaf(leaf) => items[leaf as usize],
                        Slot::Instance(_) => panic!("items are leaves"),
                    };
                    assert!(is_around(&node.tree_box(child), &expected, &node.whole_box()));
                }
            }
            let whole = whole_box(items.iter());
            assert!(is_around(&refitted.bounds, &whole, &whole));
            let growth = area(&refitted.nodes) / area(&tree.nodes);
            assert!((refitted.growth / growth - 1.0).abs() < 1e-9, "{} {growth}", refitted.growth);
        }
    }
}
