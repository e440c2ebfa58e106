//! The seam to the library that builds trees: boxes go in, a tree of boxes comes out, and no type of the library shows.

use std::time::Duration;

use obvhs::BvhBuildParams;
use obvhs::bvh2::builder::build_bvh2;
use superegg_geom::Aabb;
use superegg_geom::glam::DVec3;

/// A node: a leaf with `count` items from `first` on, or for `count` 0 an inner node whose children are nodes `first` and `first + 1`.
#[derive(Clone, Debug)]
pub(crate) struct Node {
    pub(crate) bounds: Aabb,
    pub(crate) first: u32,
    pub(crate) count: u32,
}

/// A tree of boxes over items 0..n. Node 0 is the root; there is none for no items.
#[derive(Clone, Debug, Default)]
pub(crate) struct Bvh {
    pub(crate) nodes: Vec<Node>,
    /// The items in the order that leaves name them.
    pub(crate) items: Vec<u32>,
}

/// So few items need no tree.
const SMALLEST_TREE: usize = 3;

impl Bvh {
    pub(crate) fn build(boxes: &[Aabb]) -> Self {
        let whole = boxes.iter().fold(Aabb::EMPTY, |whole, b| whole.union(b));
        let extent = whole.half_extent();
        let is_buildable = extent.is_finite() && whole.center().is_finite();
        if boxes.len() < SMALLEST_TREE || !is_buildable {
            return Self::single_leaf(boxes.len(), whole);
        }
        // The library works in f32: it sees the boxes scaled to the unit cube, and only its topology is kept.
        let scale = DVec3::from_array(extent.to_array().map(|e| if e > 0.0 { 1.0 / e } else { 0.0 }));
        let to_unit = |p: DVec3| ((p - whole.center()) * scale).as_vec3a();
        let unit_boxes: Vec<_> =
            boxes.iter().map(|b| obvhs::aabb::Aabb::new(to_unit(b.min), to_unit(b.max))).collect();
        let tree = build_bvh2(&unit_boxes, BvhBuildParams::medium_build(), &mut Duration::default());
        let nodes = tree.nodes.iter();
        let mut bvh = Self {
            nodes: nodes
                .map(|n| Node { bounds: Aabb::EMPTY, first: n.first_index, count: n.prim_count })
                .collect(),
            items: tree.primitive_indices,
        };
        bvh.fit(boxes);
        bvh
    }

    fn single_leaf(count: usize, bounds: Aabb) -> Self {
        let nodes =
            if count == 0 { Vec::new() } else { vec![Node { bounds, first: 0, count: count as u32 }] };
        Self { nodes, items: (0..count as u32).collect() }
    }

    /// Gives every node the exact f64 box of what is below it.
    fn fit(&mut self, boxes: &[Aabb]) {
        // A node is done when it is met the second time, after its children.
        let mut pending = vec![(0usize, false)];
        while let Some((index, children_done)) = pending.pop() {
            let Node { first, count, .. } = self.nodes[index];
            let (first, count) = (first as usize, count as usize);
            self.nodes[index].bounds = if count > 0 {
                self.items[first..first + count]
                    .iter()
                    .fold(Aabb::EMPTY, |all, &i| all.union(&boxes[i as usize]))
            } else if children_done {
                self.nodes[first].bounds.union(&self.nodes[first + 1].bounds)
            } else {
                pending.extend([(index, true), (first, false), (first + 1, false)]);
                continue;
            };
        }
    }

    /// The box of everything.
    pub(crate) fn bounds(&self) -> Aabb {
        self.nodes.first().map_or(Aabb::EMPTY, |root| root.bounds)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every item is in one leaf, and within the box of each node above it.
    fn check(boxes: &[Aabb]) {
        let bvh = Bvh::build(boxes);
        let mut seen = vec![0; boxes.len()];
        let mut pending: Vec<(u32, Vec<Aabb>)> = if boxes.is_empty() { vec![] } else { vec![(0, vec![])] };
        while let Some((index, mut above)) = pending.pop() {
            let node = &bvh.nodes[index as usize];
            above.push(node.bounds);
            if node.count == 0 {
                pending.extend([(node.first, above.clone()), (node.first + 1, above)]);
                continue;
            }
            for &item in &bvh.items[node.first as usize..(node.first + node.count) as usize] {
                seen[item as usize] += 1;
                let item = &boxes[item as usize];
                assert!(above.iter().all(|b| b.contains(item.min) && b.contains(item.max)));
            }
        }
        assert!(seen.iter().all(|&count| count == 1), "{seen:?}");
    }

    #[test]
    fn holds_every_item_once_whatever_the_boxes() {
        let at = |x: f64, y: f64, r: f64| Aabb::around(DVec3::new(x, y, 0.0), DVec3::splat(r));
        for count in [0, 1, 2, 3, 4, 100] {
            check(
                &(0..count)
                    .map(|i| at(f64::from(i * 7 % 13), f64::from(i * 5 % 11), 0.3))
                    .collect::<Vec<_>>(),
            );
            check(&vec![at(1.0, 2.0, 0.5); count as usize]);
            check(
                &(0..count).map(|i| at(1e-40 * f64::from(i), 1e30 * f64::from(i), 1e-50)).collect::<Vec<_>>(),
            );
        }
        check(&[at(1e308, 0.0, 1e308), at(-1e308, 0.0, 1e308), at(0.0, 0.0, 1.0)]);
    }
}
