//! The parts of groups: the children of a group before it is assembled.

use std::sync::Arc;

use num_bigint::BigUint;
use rayon::prelude::*;
use superegg_geom::glam::{DAffine3, DMat3, DVec3};
use superegg_geom::{Aabb, BOUND_SHAPES, Exponents, Superquadric, Transform};
use superegg_scene::Child;

use super::described::Described;
use super::index::Container;
use crate::scene::group::{FoldedName, Group, NameRef};

/// From this many items on, work is done in parallel.
pub(super) const LARGE: usize = 4096;

/// The map of a leaf whose transform is not invertible. No ray hits the leaf.
pub(super) const NO_MAP: DAffine3 = DAffine3::NAN;

/// A child that is a group.
pub(super) struct GroupItem {
    pub(super) name: NameRef,
    pub(super) parent_from_child: Transform,
    pub(super) group: Arc<Group>,
}

/// A primitive of a child that is folded, or the root.
pub(super) struct FoldedLeaf {
    pub(super) name: NameRef,
    pub(super) primitive: u32,
    pub(super) maps: LeafMaps,
}

/// The content of a group.
#[derive(Default)]
pub(super) struct Parts<'a> {
    /// `None` if the root is a primitive.
    pub(super) container: Option<Container<'a>>,
    /// The children of an object; none for a table.
    pub(super) children: Arc<Vec<&'a Child>>,
    /// Children that are primitives: the indices of child, or of the row of a table, and primitive.
    pub(super) leaves: Vec<(u32, u32)>,
    /// The primitives of folded children.
    pub(super) folded: Vec<FoldedLeaf>,
    pub(super) groups: Vec<GroupItem>,
    /// The names of what comes from folded children.
    pub(super) folded_names: Vec<FoldedName>,
    /// The number of children that are primitives, including duplicates.
    pub(super) primitive_count: u64,
    /// The number of instances of primitives in all groups.
    pub(super) group_count: BigUint,
}

impl Parts<'_> {
    #[inline]
    pub(super) fn transform(&self, child: u32) -> Option<Transform> {
        match self.container? {
            Container::Object(object) => object.parent_from_child(self.children[child as usize]).ok(),
            Container::Table(table) => Some(table.transform(child as usize)),
        }
    }

    /// The number of leaves and instances.
    pub(super) fn item_count(&self) -> usize {
        self.leaves.len() + self.folded.len() + self.groups.len()
    }

    /// The number of children, or of the rows of a table.
    pub(super) fn child_count(&self) -> usize {
        match self.container {
            Some(Container::Table(table)) => table.len(),
            Some(Container::Object(_)) | None => self.children.len(),
        }
    }

    /// The maps of a plain leaf (child, primitive).
    pub(super) fn maps(&self, &(child, primitive): &(u32, u32), described: &Described) -> Option<LeafMaps> {
        Some(LeafMaps::new(&self.transform(child)?, described.radii[primitive as usize]))
    }

    /// The image of the unit shape of a plain leaf.
    pub(super) fn image(&self, &(child, primitive): &(u32, u32), described: &Described) -> Option<LeafImage> {
        Some(LeafImage::new(&self.transform(child)?, described.shape(primitive)))
    }
}

/// The maps between a group and the unit shape of a leaf.
pub(super) struct LeafMaps {
    pub(super) unit_from_group: DAffine3,
    pub(super) group_from_unit: DAffine3,
}

impl LeafMaps {
    pub(super) fn new(group_from_local: &Transform, radii: DVec3) -> Self {
        Self {
            unit_from_group: unit_from_group(group_from_local, radii),
            group_from_unit: group_from_unit(group_from_local, radii),
        }
    }

    /// The image of the unit shape of a primitive.
    pub(super) fn image(&self, exponents: Exponents) -> LeafImage {
        LeafImage { group_from_unit: self.group_from_unit, exponents }
    }
}

pub(super) fn unit_from_group(group_from_local: &Transform, radii: DVec3) -> DAffine3 {
    let (inverse, to_unit) = (group_from_local.inverse(), radii.recip());
    let rows = &inverse.matrix3;
    DAffine3 {
        matrix3: DMat3::from_cols(to_unit * rows.x_axis, to_unit * rows.y_axis, to_unit * rows.z_axis),
        translation: to_unit * inverse.translation,
    }
}

fn group_from_unit(group_from_local: &Transform, radii: DVec3) -> DAffine3 {
    let forward = group_from_local.forward();
    let columns = &forward.matrix3;
    DAffine3 {
        matrix3: DMat3::from_cols(
            columns.x_axis * radii.x,
            columns.y_axis * radii.y,
            columns.z_axis * radii.z,
        ),
        translation: forward.translation,
    }
}

/// A unit shape with its map to a group.
pub(super) struct LeafImage {
    group_from_unit: DAffine3,
    exponents: Exponents,
}

impl LeafImage {
    pub(super) fn new(group_from_local: &Transform, (radii, exponents): (DVec3, Exponents)) -> Self {
        Self { group_from_unit: group_from_unit(group_from_local, radii), exponents }
    }

    /// A box around the image of [-1, 1]^3.
    pub(super) fn loose_box(&self) -> Aabb {
        let columns = self.group_from_unit.matrix3;
        self.box_of(columns.x_axis.abs() + columns.y_axis.abs() + columns.z_axis.abs())
    }

    /// The smallest box around the shape, rounded outwards.
    pub(super) fn exact_box(&self) -> Aabb {
        let shape = Superquadric::unit(self.exponents);
        self.box_of(shape.half_extent_under(&self.group_from_unit.matrix3)).rounded_outward()
    }

    /// Nearly the smallest box around each shape, rounded outwards.
    pub(super) fn tight_boxes(images: &[Option<Self>; BOUND_SHAPES]) -> [Option<Aabb>; BOUND_SHAPES] {
        let exponents =
            images.each_ref().map(|image| image.as_ref().map_or(Exponents::ROUND, |image| image.exponents));
        let linear = images.each_ref().map(|image| match image {
            Some(image) => &image.group_from_unit.matrix3,
            None => &DMat3::IDENTITY,
        });
        let half_extents = Superquadric::unit_half_extent_bounds(&exponents, linear);
        std::array::from_fn(|i| Some(images[i].as_ref()?.box_of(half_extents[i]).rounded_outward()))
    }

    /// As [`LeafImage::tight_boxes`], of one shape.
    pub(super) fn tight_box(&self) -> Aabb {
        let linear = &self.group_from_unit.matrix3;
        let exponents = [self.exponents; BOUND_SHAPES];
        let [half_extent, ..] = Superquadric::unit_half_extent_bounds(&exponents, [linear; BOUND_SHAPES]);
        self.box_of(half_extent).rounded_outward()
    }

    fn box_of(&self, half_extent: DVec3) -> Aabb {
        Aabb::around(self.group_from_unit.translation, half_extent)
    }
}

/// Maps items, in parallel if there are many.
pub(super) fn map_all<T: Sync, R: Send>(items: &[T], work: impl Fn(&T) -> R + Send + Sync) -> Vec<R> {
    if items.len() < LARGE { items.iter().map(work).collect() } else { items.par_iter().map(work).collect() }
}
