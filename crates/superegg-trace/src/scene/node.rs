//! The nodes of a bounding volume hierarchy and the space of their boxes.
//!
//! Nodes have up to eight children. Their boxes are rounded outwards, in a space of their own ([`TreeSpace`]) whose
//! coordinates are of the order of 1; so no scene is too large or too small for them.

use smallvec::SmallVec;
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
#[derive(Clone, Copy, Debug)]
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

/// A node in 128 bytes: the boxes of up to eight children, one column for each bound.
///
/// Bounds are counted in steps from an origin of the node, and rounded outwards to whole steps. The step of an axis is a power
/// of two, between 1/65536 and 1/32768 of the node's extent, or more where the numbers of f32 are farther apart. So every
/// bound is an f32 without rounding, in whatever order it is computed.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub(crate) struct Node {
    /// The least x, y and z of each child, then the largest, in steps from the origin.
    steps: [[u16; WIDTH]; 6],
    origin: [f32; 3],
    /// The index of the first child that is a node, a leaf and an instance. Those of one kind follow each other.
    first_of_kind: [u32; 3],
    /// The size of a step along each axis, as the biased exponent of an f32.
    step_exponents: [u8; 3],
    /// The number of children.
    pub(crate) count: u8,
    /// A bit for each child that is a leaf.
    pub(crate) leaves: u8,
    /// A bit for each child that is an instance.
    instances: u8,
}

impl Node {
    /// A node that is replaced later.
    pub(super) const EMPTY: Self = Self {
        steps: [[0; WIDTH]; 6],
        origin: [0.0; 3],
        first_of_kind: [0; 3],
        step_exponents: [0; 3],
        count: 0,
        leaves: 0,
        instances: 0,
    };

    /// A node with children, at most eight. Those of one kind have indices that follow each other.
    pub(super) fn new(boxes: &[TreeBox], slots: &[Slot]) -> Self {
        let mut node = Self::EMPTY;
        node.set_boxes(boxes);
        node.set_slots(slots);
        node
    }

    pub(super) fn set_boxes(&mut self, boxes: &[TreeBox]) {
        let whole = whole_box(boxes.iter());
        for axis in 0..3 {
            let steps = Steps::between(whole.min[axis], whole.max[axis]);
            (self.origin[axis], self.step_exponents[axis]) = (steps.origin, steps.exponent);
            for (child, held) in boxes.iter().enumerate() {
                self.steps[axis][child] = steps.below(held.min[axis]);
                self.steps[axis + 3][child] = steps.above(held.max[axis]);
            }
        }
    }

    fn set_slots(&mut self, slots: &[Slot]) {
        (self.count, self.leaves, self.instances) = (slots.len() as u8, 0, 0);
        for (child, slot) in slots.iter().enumerate().rev() {
            match *slot {
                Slot::Node(index) => self.first_of_kind[0] = index,
                Slot::Leaf(index) => {
                    self.first_of_kind[1] = index;
                    self.leaves |= 1 << child;
                }
                Slot::Instance(index) => {
                    self.first_of_kind[2] = index;
                    self.instances |= 1 << child;
                }
            }
        }
        debug_assert!(
            self.slots().eq(slots.iter().copied()),
            "children of one kind do not follow each other"
        );
    }

    /// The node in a tree where its nodes and leaves come behind so many others.
    pub(super) fn moved(&self, nodes: u32, leaves: u32) -> Self {
        let [node, leaf, instance] = self.first_of_kind;
        Self { first_of_kind: [node + nodes, leaf + leaves, instance], ..*self }
    }

    /// Replaces each child. Those of one kind have indices that follow each other.
    pub(crate) fn map_slots(&mut self, to: impl Fn(Slot) -> Slot) {
        let slots: SmallVec<[Slot; WIDTH]> = self.slots().map(to).collect();
        self.set_slots(&slots);
    }

    #[inline(always)]
    pub(crate) fn slot(&self, child: usize) -> Slot {
        let bit = 1 << child;
        if self.leaves & bit != 0 {
            Slot::Leaf(self.leaf(child))
        } else if self.instances & bit != 0 {
            Slot::Instance(self.first_of_kind[2] + ones_below(self.instances, child))
        } else {
            Slot::Node(self.first_of_kind[0] + ones_below(!(self.leaves | self.instances), child))
        }
    }

    /// The index of a child that is a leaf.
    #[inline(always)]
    pub(crate) fn leaf(&self, child: usize) -> u32 {
        self.first_of_kind[1] + ones_below(self.leaves, child)
    }

    pub(crate) fn slots(&self) -> impl Iterator<Item = Slot> {
        (0..self.count as usize).map(|child| self.slot(child))
    }

    /// The bounds of all boxes: the least x, y and z of each child, then the largest.
    #[inline(always)]
    pub(crate) fn bounds(&self) -> [[f32; WIDTH]; 6] {
        let mut bounds = [[0.0; WIDTH]; 6];
        for (row, (bounds, steps)) in bounds.iter_mut().zip(&self.steps).enumerate() {
            let (origin, size) = (self.origin[row % 3], step_size(self.step_exponents[row % 3]));
            for (bound, &count) in bounds.iter_mut().zip(steps) {
                *bound = origin + f32::from(count) * size;
            }
        }
        bounds
    }

    pub(super) fn tree_box(&self, child: usize) -> TreeBox {
        let corner = |first: usize| {
            std::array::from_fn(|axis| {
                let size = step_size(self.step_exponents[axis]);
                self.origin[axis] + f32::from(self.steps[first + axis][child]) * size
            })
        };
        TreeBox { min: corner(0), max: corner(3) }
    }

    /// The box of each child.
    pub(super) fn tree_boxes(&self) -> SmallVec<[TreeBox; WIDTH]> {
        (0..self.count as usize).map(|child| self.tree_box(child)).collect()
    }

    /// The box around all children.
    pub(super) fn whole_box(&self) -> TreeBox {
        whole_box(self.tree_boxes().iter())
    }

    /// The children: the box of each in the tree's space, and its slot.
    pub(crate) fn children(&self) -> impl Iterator<Item = (Aabb, Slot)> {
        self.slots().enumerate().map(|(child, slot)| (self.tree_box(child).into(), slot))
    }
}

/// The number of ones below a bit.
#[inline(always)]
fn ones_below(bits: u8, bit: usize) -> u32 {
    (bits & ((1 << bit) - 1)).count_ones()
}

/// The bits of the fraction of an f32.
const FRACTION_BITS: u32 = f32::MANTISSA_DIGITS - 1;

/// A step size from its biased exponent.
#[inline(always)]
fn step_size(exponent: u8) -> f32 {
    f32::from_bits(u32::from(exponent) << FRACTION_BITS)
}

/// The steps in which bounds along an axis are counted.
struct Steps {
    origin: f32,
    exponent: u8,
    size: f32,
    per_unit: f32,
}

impl Steps {
    /// Steps that count bounds from `least` to `largest` in 16 bits.
    fn between(least: f32, largest: f32) -> Self {
        let exponent_of = |x: f32| (x.to_bits() >> FRACTION_BITS) as u8;
        // The multiples of such a step are f32 up to the farthest bound.
        let by_distance = exponent_of(least.abs().max(largest.abs())).saturating_sub(FRACTION_BITS as u8);
        // Rounded outwards, an extent has up to two steps more.
        let by_extent = exponent_of(((largest - least) / f32::from(u16::MAX - 2)).abs()) + 1;
        let exponent = by_distance.max(by_extent);
        let size = step_size(exponent);
        let steps = Self { origin: 0.0, exponent, size, per_unit: size.recip() };
        let near = (least * steps.per_unit) as i32 as f32 * size;
        Self { origin: if near > least { near - size } else { near }, ..steps }
    }

    fn bound(&self, count: u16) -> f32 {
        self.origin + f32::from(count) * self.size
    }

    fn near(&self, x: f32) -> u16 {
        ((x - self.origin) * self.per_unit) as u16
    }

    /// The last step that is not above a bound.
    fn below(&self, x: f32) -> u16 {
        let near = self.near(x);
        near - u16::from(self.bound(near) > x)
    }

    /// The first step that is not below a bound.
    fn above(&self, x: f32) -> u16 {
        let near = self.near(x);
        near + u16::from(self.bound(near) < x)
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
        self.group_box(&whole_box(boxes.iter()).into())
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

impl From<TreeBox> for Aabb {
    fn from(tree_box: TreeBox) -> Self {
        let corner = |c: [f32; 3]| DVec3::from_array(c.map(f64::from));
        Self { min: corner(tree_box.min), max: corner(tree_box.max) }
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
    fn nodes_have_boxes_around_those_of_their_children() {
        assert_eq!(size_of::<Node>(), 128);
        let mut state = 7_u64;
        let mut random = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (state >> 40) as f32 / (1 << 24) as f32
        };
        for round in 0..20_000 {
            let count = 1 + round % WIDTH;
            // Boxes of all sizes at all distances, and points.
            let size = [1.0, 1e-3, 1e-6, 1e-30, 1e-44, 0.0, FARTHEST][(7.0 * random()) as usize];
            let (middle, flat) = (2.0 * random() - 1.0, if random() < 0.1 { 0.0 } else { 1.0 });
            let boxes: Vec<TreeBox> = (0..count)
                .map(|_| {
                    let min: [f32; 3] = std::array::from_fn(|_| {
                        (middle + size * (random() - 0.5)).clamp(-FARTHEST, FARTHEST)
                    });
                    TreeBox { min, max: min.map(|x| (x + flat * size * random() * random()).min(FARTHEST)) }
                })
                .collect();
            let node = Node::new(&boxes, &(0..count as u32).map(Slot::Leaf).collect::<Vec<_>>());
            let (whole, bounds) = (whole_box(boxes.iter()), node.bounds());
            for (child, held) in boxes.iter().enumerate() {
                let decoded = node.tree_box(child);
                for axis in 0..3 {
                    let (least, largest) = (decoded.min[axis], decoded.max[axis]);
                    assert!(least <= held.min[axis] && held.max[axis] <= largest, "{decoded:?} {held:?}");
                    assert_eq!((least, largest), (bounds[axis][child], bounds[axis + 3][child]));
                    // Fused and in f64 the bounds are the same.
                    let (origin, step) = (node.origin[axis], step_size(node.step_exponents[axis]));
                    let steps = f32::from(node.steps[axis][child]);
                    assert_eq!(least, steps.mul_add(step, origin));
                    assert_eq!(f64::from(least), f64::from(steps) * f64::from(step) + f64::from(origin));
                    let extent = whole.max[axis] - whole.min[axis];
                    let far = whole.max[axis].abs().max(whole.min[axis].abs());
                    let slack = (extent / 32_000.0).max(far * f32::EPSILON).max(2.0 * f32::MIN_POSITIVE);
                    assert!(held.min[axis] - least <= slack && largest - held.max[axis] <= slack);
                }
            }
            // A node keeps its boxes when they are set again.
            let mut again = node;
            again.set_boxes(&node.tree_boxes());
            for child in 0..count {
                let (before, after) = (node.tree_box(child), again.tree_box(child));
                assert_eq!((before.min, before.max), (after.min, after.max));
            }
        }
    }

    #[test]
    fn children_keep_their_slots() {
        let slots = [
            Slot::Leaf(7),
            Slot::Node(3),
            Slot::Instance(1),
            Slot::Leaf(8),
            Slot::Instance(2),
            Slot::Instance(3),
            Slot::Node(4),
            Slot::Leaf(9),
        ];
        let mut node = Node::new(&[TreeBox::POINT; WIDTH], &slots);
        assert!(node.slots().eq(slots));
        assert_eq!((node.leaves, node.count, node.leaf(7)), (0b1000_1001, 8, 9));
        node.map_slots(|slot| match slot {
            Slot::Leaf(leaf) => Slot::Node(leaf - 2),
            Slot::Node(node) => Slot::Leaf(node),
            Slot::Instance(_) => slot,
        });
        let kinds = [Slot::Node(5), Slot::Leaf(3), Slot::Instance(1), Slot::Node(6), Slot::Instance(2)];
        assert!(node.slots().take(5).eq(kinds));
    }

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
