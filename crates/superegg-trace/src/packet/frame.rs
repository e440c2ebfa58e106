//! A group that packets traverse, as the f32 kernels see it.

use superegg_geom::Superquadric;
use superegg_geom::glam::{DAffine3, DVec3};
use superegg_geom::kernels::packet::{
    PacketColumn, PacketIntervals, PacketKernels, PacketShape, PacketVectors,
};

use super::batch::TracedPackets;
use super::candidates::{PathId, TestShape, f32_columns};
use crate::scene::group::{Group, Instance, Target};
use crate::scene::path::InstancePath;
use crate::scene::proxy::Proxy;

/// The relative rounding error of a direction and a map in f32, with a margin.
const ROUNDING: f64 = 1.0 / (1 << 21) as f64;
/// The least tolerance of N in f32.
const LEAST_TOLERANCE: f64 = 1.5e-6;
/// At a larger tolerance the shape is left to f64.
const MOST_TOLERANCE: f64 = 0.03;

/// A group to open: how it is reached, and its map from the world.
#[derive(Clone, Copy)]
pub(super) struct Entry<'s> {
    pub(super) group: &'s Group,
    pub(super) path: PathId,
    pub(super) group_from_world: DAffine3,
    /// An upper bound on the factor from lengths of the group to the world's.
    pub(super) stretch: f64,
}

/// An open group.
#[derive(Debug)]
pub(super) struct Frame<'s> {
    pub(super) group: &'s Group,
    pub(super) path: PathId,
    pub(super) group_from_world: DAffine3,
    /// An upper bound on the factor from lengths of the group to the world's.
    pub(super) stretch: f64,
    /// The rays' origin in the group's space.
    pub(super) group_origin: DVec3,
    /// The rays' origin in the tree's space.
    pub(super) tree_origin: DVec3,
    /// Converts a t of the packets to the tree's.
    pub(super) t_scale: f32,
    /// The rounding error of box coordinates along each axis.
    pub(super) pad: [f32; 3],
    /// An upper bound on the packets' t inside the group.
    passed: f64,
    /// The length of the longest direction in the tree's space.
    pub(super) longest: f64,
    /// A direction in the middle of all, in the tree's space.
    pub(super) middle: DVec3,
    /// The intervals of reciprocal directions of each packet.
    pub(super) intervals: PacketIntervals,
    /// The first reciprocal direction of this group in the stack.
    pub(super) first_inverse: usize,
}

/// Why f32 kernels cannot test a shape.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum BeyondKernels {
    /// The origin is within the shape's box, or close to it.
    StartsInside,
    /// The origin is so far away, in sizes of the shape, that f32 does not resolve it.
    TooFar,
}

/// The reciprocals of directions in the spaces of open groups, one group after the other.
#[derive(Debug, Default)]
pub(super) struct InverseStack {
    pub(super) inverses: Vec<PacketVectors>,
    /// The number in use.
    pub(super) open: usize,
}

impl<'s> Frame<'s> {
    /// Opens a group for the packets of a mask. `None` if f32 cannot hold the map or the origin.
    pub(super) fn open(
        kernels: PacketKernels,
        batch: &TracedPackets,
        stack: &mut InverseStack,
        entry: Entry<'s>,
        mask: u32,
    ) -> Option<Self> {
        let Entry { group, path, group_from_world, stretch } = entry;
        let tree_from_world = group.space.tree_from_group() * group_from_world;
        let group_origin = group_from_world.transform_point3(batch.origin);
        let tree_origin = tree_from_world.transform_point3(batch.origin);
        let (columns, map_scale) = f32_columns(&tree_from_world.matrix3)?;
        if !tree_origin.is_finite() || tree_origin.abs().max_element() > 1e15 {
            return None;
        }
        let first_inverse = stack.open;
        let end = first_inverse + batch.directions.len();
        if stack.inverses.len() < end {
            stack.inverses.resize(end, [PacketColumn::splat(0.0); 3]);
        }
        let inverses = &mut stack.inverses[first_inverse..];
        let intervals =
            kernels.intervals(&columns, &batch.directions, &batch.direction_boxes, mask, inverses);
        stack.open = end;
        let [shortest, longest] = intervals.squares;
        // Half edges of the tree's boxes are below 1.
        let distance = tree_origin.length() + 2.0;
        let passed = (distance / f64::from(shortest.sqrt()) * map_scale).min(1e300);
        let largest = batch.largest();
        let rows = tree_from_world.matrix3.transpose();
        let reach = [rows.x_axis, rows.y_axis, rows.z_axis].map(|row| row.abs().dot(largest));
        let pad = std::array::from_fn(|axis| {
            (ROUNDING * (reach[axis] * passed + tree_origin[axis].abs() + 2.0)).min(1e18) as f32
        });
        Some(Self {
            group,
            path,
            group_from_world,
            stretch,
            group_origin,
            tree_origin,
            t_scale: (1.0 / map_scale) as f32,
            pad,
            passed,
            longest: f64::from(longest.sqrt()) / map_scale,
            middle: tree_from_world.matrix3 * batch.middle,
            intervals,
            first_inverse,
        })
    }

    /// A lower bound on the packets' t at which any ray reaches the ball around a child.
    pub(super) fn least_t(&self, instance: &Instance) -> f64 {
        let center = instance.map().forward().transform_point3(instance.group.bounds.center());
        let radius = 0.5 * instance.size() * instance.stretch;
        let distance = (center - self.group_origin).length() - radius;
        let speed = self.longest / self.group.space.scale;
        (distance / speed).max(0.0)
    }

    /// The primitive of a leaf, by its shape.
    pub(super) fn leaf(&self, index: u32, shape: Superquadric) -> TestShape {
        let leaf = &self.group.leaves[index as usize];
        let target = Target::Primitive(leaf.primitive);
        TestShape { shape, ..self.test_sphere(leaf.unit_from_group, index, target) }
    }

    /// The proxy of a child.
    pub(super) fn proxy(&self, index: u32, instance: &Instance, proxy: &Proxy) -> TestShape {
        let unit_from_group = proxy.unit_from_group * *instance.map().inverse();
        let index = index | InstancePath::INSTANCE;
        TestShape { opacity: proxy.opacity, ..self.test_sphere(unit_from_group, index, Target::Proxy) }
    }

    /// An opaque ellipsoid.
    fn test_sphere(&self, unit_from_group: DAffine3, index: u32, target: Target) -> TestShape {
        TestShape {
            unit_from_world: unit_from_group * self.group_from_world,
            origin: unit_from_group.transform_point3(self.group_origin),
            shape: Proxy::unit_shape(),
            opacity: 1.0,
            index,
            target,
        }
    }

    /// A shape as the f32 kernels see it: the shape itself, or a convex one around it if it is not convex.
    pub(super) fn packet_shape(
        &self,
        batch: &TracedPackets,
        tested: &TestShape,
    ) -> Result<PacketShape, BeyondKernels> {
        let linear = &tested.unit_from_world.matrix3;
        let rows = linear.transpose();
        let rows = [rows.x_axis, rows.y_axis, rows.z_axis];
        let origin_size = tested.origin.abs().max_element();
        // At this t every ray has left the group, or the slab of the shape's box along some axis.
        let passed = (0..3).fold(self.passed, |passed, axis| {
            passed.min((tested.origin[axis].abs() + 1.1) / batch.least_along(rows[axis]))
        });
        let largest = batch.largest();
        let reach = rows.into_iter().map(|row| row.abs().dot(largest)).fold(0.0, f64::max) * passed;
        let tolerance = LEAST_TOLERANCE + ROUNDING * (reach.min(1e30) + origin_size);
        if origin_size <= 1.01 + 4.0 * tolerance.min(MOST_TOLERANCE) {
            return Err(BeyondKernels::StartsInside);
        }
        let columns = f32_columns(linear).filter(|_| tolerance < MOST_TOLERANCE);
        let around = Superquadric::unit(tested.shape.exponents().convexified()).as_convex();
        let ((columns, map_scale), around) = columns.zip(around).ok_or(BeyondKernels::TooFar)?;
        let origin = tested.origin.as_vec3().to_array();
        Ok(PacketShape::new(&around, columns, origin, tolerance as f32, map_scale as f32))
    }
}
