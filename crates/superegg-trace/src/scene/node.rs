//! The nodes of a bounding volume hierarchy and the space of their boxes.
//!
//! Nodes have up to eight children. Their boxes are f32, rounded outwards, in a space of their own ([`TreeSpace`]) whose
//! coordinates are of the order of 1; so no scene is too large or too small for them.

use superegg_geom::Aabb;
use superegg_geom::glam::{DAffine3, DMat3, DVec3};

/// The most children of a node.
pub(crate) const WIDTH: usize = 8;

/// The target of a slot of a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Slot {
    /// A node of the same tree.
    Node(u32),
    /// A leaf: a primitive of the group.
    Leaf(u32),
    /// A child that is a group.
    Instance(u32),
}

/// A [`Slot`] in 32 bits: the kind in the upper two, the index in the others.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct PackedSlot(u32);

impl PackedSlot {
    const INDEX: u32 = (1 << 30) - 1;
    const LEAF: u32 = 1;
    const INSTANCE: u32 = 2;

    pub(crate) fn new(slot: Slot) -> Self {
        match slot {
            Slot::Node(i) => Self(i & Self::INDEX),
            Slot::Leaf(i) => Self(Self::LEAF << 30 | (i & Self::INDEX)),
            Slot::Instance(i) => Self(Self::INSTANCE << 30 | (i & Self::INDEX)),
        }
    }

    pub(crate) fn unpack(self) -> Slot {
        let index = self.0 & Self::INDEX;
        match self.0 >> 30 {
            0 => Slot::Node(index),
            Self::LEAF => Slot::Leaf(index),
            _ => Slot::Instance(index),
        }
    }
}

/// A node: the boxes of up to eight children, one column for each bound.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub(crate) struct Node {
    /// The least x, y and z of each child, then the largest.
    pub(crate) bounds: [[f32; WIDTH]; 6],
    pub(crate) slots: [PackedSlot; WIDTH],
    /// The number of slots in use.
    pub(crate) count: u8,
    /// A bit for each slot that is a leaf.
    pub(crate) leaves: u8,
}

impl Node {
    /// A node without children. Unused slots have a box far away from everything.
    pub(super) const EMPTY: Self =
        Self { bounds: [[f32::MAX; WIDTH]; 6], slots: [PackedSlot(0); WIDTH], count: 0, leaves: 0 };

    pub(super) fn push(&mut self, bounds: &TreeBox, slot: Slot) {
        let child = self.count as usize;
        self.set_tree_box(child, bounds);
        self.set_slot(child, slot);
        self.count += 1;
    }

    fn set_slot(&mut self, child: usize, slot: Slot) {
        self.slots[child] = PackedSlot::new(slot);
        self.leaves = self.leaves & !(1 << child) | u8::from(matches!(slot, Slot::Leaf(_))) << child;
    }

    pub(super) fn tree_box(&self, child: usize) -> TreeBox {
        let corner = |first: usize| std::array::from_fn(|axis| self.bounds[first + axis][child]);
        TreeBox { min: corner(0), max: corner(3) }
    }

    pub(super) fn set_tree_box(&mut self, child: usize, bounds: &TreeBox) {
        for axis in 0..3 {
            self.bounds[axis][child] = bounds.min[axis];
            self.bounds[axis + 3][child] = bounds.max[axis];
        }
    }

    /// The box around all children.
    pub(super) fn whole_box(&self) -> TreeBox {
        (0..self.count as usize).fold(TreeBox::EMPTY, |whole, child| whole.union(&self.tree_box(child)))
    }

    /// Replaces each slot in use.
    pub(crate) fn map_slots(&mut self, to: impl Fn(Slot) -> Slot) {
        for child in 0..self.count as usize {
            self.set_slot(child, to(self.slots[child].unpack()));
        }
    }

    pub(crate) fn slots(&self) -> impl Iterator<Item = Slot> {
        self.slots[..self.count as usize].iter().map(|slot| slot.unpack())
    }

    /// The children: the box of each in the tree's space, and its slot.
    pub(crate) fn children(&self) -> impl Iterator<Item = (Aabb, Slot)> {
        self.slots().enumerate().map(|(child, slot)| (self.child_box(child), slot))
    }

    /// The box of a child, in the tree's space.
    pub(crate) fn child_box(&self, child: usize) -> Aabb {
        let corner = |first: usize| {
            DVec3::from_array(std::array::from_fn(|axis| f64::from(self.bounds[first + axis][child])))
        };
        Aabb { min: corner(0), max: corner(3) }
    }
}

/// The space of a tree's boxes: `(p - center) * scale` for a point `p` of the group. The scale is a power of two.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct TreeSpace {
    pub(crate) center: DVec3,
    pub(crate) scale: f64,
}

impl TreeSpace {
    /// The space in which the half edges of `whole` are below 1.
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

    /// A box of the group in this space, rounded outwards.
    pub(crate) fn tree_box(&self, bounds: &Aabb) -> TreeBox {
        // Twice the rounding error of the subtraction, which is relative to its operands.
        let slack =
            4.0 * f64::EPSILON * (bounds.min.abs().max(bounds.max.abs()) + self.center.abs()) * self.scale;
        let min = (bounds.min - self.center) * self.scale - slack;
        let max = (bounds.max - self.center) * self.scale + slack;
        let [a, b, c, d, e, f] = below([min.x, min.y, min.z, -max.x, -max.y, -max.z]);
        TreeBox { min: [a, b, c], max: [-d, -e, -f] }
    }

    /// A box of the group around boxes of this space.
    pub(crate) fn bounds_of(&self, boxes: &[TreeBox]) -> Aabb {
        let whole = whole_box(boxes.iter());
        let corner = |c: [f32; 3]| DVec3::from_array(c.map(f64::from));
        self.group_box(&Aabb { min: corner(whole.min), max: corner(whole.max) })
    }

    /// A box of this space in the group's space, rounded outwards.
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

/// The limit of box coordinates. Rays that reach farther are traced in f64.
const FARTHEST: f32 = 1e18;

/// The largest f32 not above each number, the least one for NaN. Half of all numbers are rounded up, so it has no branches.
#[inline]
fn below<const N: usize>(numbers: [f64; N]) -> [f32; N] {
    let mut all = [0.0; N];
    for (below, x) in all.iter_mut().zip(numbers) {
        let nearest = x as f32;
        let bits = nearest.to_bits();
        // Bits count away from 0.
        let towards_zero = bits.wrapping_sub(((bits as i32) >> 31 | 1) as u32);
        let next_down = if bits == 0 { (-f32::from_bits(1)).to_bits() } else { towards_zero };
        let rounded = f32::from_bits(if f64::from(nearest) > x { next_down } else { bits });
        // NaN is less than nothing.
        *below = if rounded > -FARTHEST { rounded.min(FARTHEST) } else { -FARTHEST };
    }
    all
}

/// A box in a tree's space.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TreeBox {
    pub(crate) min: [f32; 3],
    pub(crate) max: [f32; 3],
}

impl TreeBox {
    /// A point at the center of the space.
    pub(crate) const POINT: Self = Self { min: [0.0; 3], max: [0.0; 3] };
    pub(super) const EMPTY: Self = Self { min: [f32::INFINITY; 3], max: [f32::NEG_INFINITY; 3] };

    pub(super) fn union(&self, other: &Self) -> Self {
        Self {
            min: std::array::from_fn(|axis| self.min[axis].min(other.min[axis])),
            max: std::array::from_fn(|axis| self.max[axis].max(other.max[axis])),
        }
    }

    pub(super) fn half_area(&self) -> f32 {
        let [x, y, z] = std::array::from_fn(|axis| (self.max[axis] - self.min[axis]).max(0.0));
        x * y + y * z + z * x
    }

    /// A test for boxes that come near the faces of this one.
    pub(crate) fn outer_test(&self) -> impl Fn(&Self) -> bool + use<> {
        /// More than tight boxes exceed the smallest ones, as a part of the edges of all.
        const MARGIN: f32 = 1e-4;
        let Self { min, max } = *self;
        move |other| {
            (0..3).any(|axis| {
                let margin = MARGIN * (max[axis] - min[axis]);
                other.min[axis] <= min[axis] + margin || other.max[axis] >= max[axis] - margin
            })
        }
    }

    pub(super) fn center(&self, axis: usize) -> f32 {
        0.5 * (self.min[axis] + self.max[axis])
    }
}

/// The box around boxes.
pub(crate) fn whole_box<'a>(boxes: impl Iterator<Item = &'a TreeBox>) -> TreeBox {
    boxes.fold(TreeBox::EMPTY, |whole, b| whole.union(b))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn boxes_are_rounded_outwards() {
        let space = TreeSpace { center: DVec3::new(0.1, 0.2, 0.3), scale: 1.0 / 64.0 };
        for i in 0..1000 {
            let at = DVec3::new((f64::from(i)).sin(), (1.7 * f64::from(i)).cos(), f64::from(i) * 0.01);
            let rounded = space.tree_box(&Aabb { min: at, max: at });
            let exact = (at - space.center) / 64.0;
            for axis in 0..3 {
                assert!(f64::from(rounded.min[axis]) <= exact[axis]);
                assert!(exact[axis] <= f64::from(rounded.max[axis]));
            }
        }
    }

    #[test]
    fn rounding_down_gives_the_largest_number_that_is_not_above() {
        let mut state = 5_u64;
        let mut numbers = vec![0.0, -0.0, 1e-60, -1e-60, 1e60, -1e60, f64::INFINITY, f64::NEG_INFINITY];
        for _ in 0..10_000 {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            let near_f32 =
                f64::from(f32::from_bits((state >> 32) as u32)) * (1.0 + (state >> 60) as f64 * 1e-9);
            numbers.extend([near_f32, (state >> 11) as f64 * 1e-16 - 0.5].iter().filter(|x| !x.is_nan()));
        }
        for x in numbers {
            let nearest = x as f32;
            let expected = if f64::from(nearest) > x { nearest.next_down() } else { nearest };
            assert_eq!(below([x])[0].to_bits(), expected.clamp(-FARTHEST, FARTHEST).to_bits(), "{x}");
        }
    }
}
