//! The parts of groups: entities of the scene by index, and the children of a group before it is assembled.

use std::hint::black_box;
use std::sync::Arc;

use arrayvec::ArrayVec;
use num_bigint::BigUint;
use rayon::prelude::*;
use superegg_geom::glam::{DAffine3, DMat3, DVec3};
use superegg_geom::{Aabb, BOUND_SHAPES, Exponents, Superquadric, Transform};
use superegg_scene::{Child, Entity, InstanceTable, Object, Primitive, Scene, object_heights};

use crate::scene::group::{FoldedName, Group, NameList, NameRef, Names};
use crate::scene::primitive::CompiledPrimitive;

/// From this many items on, work is done in parallel.
pub(super) const LARGE: usize = 4096;

/// The map of a leaf whose transform is not invertible. No ray hits the leaf.
pub(super) const NO_MAP: DAffine3 = DAffine3::NAN;

/// A primitive or a container, by its index among those of its kind in the order of the scene.
#[derive(Clone, Copy)]
pub(super) enum EntityIndex {
    Primitive(u32),
    Container(u32),
}

/// An entity that becomes a group.
#[derive(Clone, Copy)]
pub(super) enum Container<'a> {
    Object(&'a Object),
    Table(&'a InstanceTable),
}

impl Container<'_> {
    pub(super) fn is_empty(self) -> bool {
        match self {
            Self::Object(object) => object.visible_children().next().is_none(),
            Self::Table(table) => table.is_empty(),
        }
    }
}

/// An optional [`EntityIndex`] in 32 bits. A child list has one for each child.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub(super) struct PackedEntity(u32);

impl PackedEntity {
    const CONTAINER: u32 = 1 << 31;
    /// A name without entity.
    pub(super) const NONE: Self = Self(u32::MAX);

    fn new(entity: EntityIndex) -> Self {
        match entity {
            EntityIndex::Primitive(i) => Self(i),
            EntityIndex::Container(i) => Self(i | Self::CONTAINER),
        }
    }

    pub(super) fn unpack(self) -> Option<EntityIndex> {
        match self.0 {
            u32::MAX => None,
            i if i & Self::CONTAINER != 0 => Some(EntityIndex::Container(i & !Self::CONTAINER)),
            i => Some(EntityIndex::Primitive(i)),
        }
    }
}

/// The entities of a scene.
pub(super) struct Index<'a> {
    scene: &'a Scene,
    /// The entity of each number in the scene.
    by_number: Vec<PackedEntity>,
    pub(super) containers: Vec<Container<'a>>,
    pub(super) container_names: Vec<&'a str>,
}

impl<'a> Index<'a> {
    /// The entities of a scene. `describe` gets each primitive with its name.
    pub(super) fn of(scene: &'a Scene, mut describe: impl FnMut(&'a str, &'a Primitive)) -> Self {
        /// Entities lie far apart. Some are loaded together, as memory has to be waited for only once then.
        const TOGETHER: usize = 32;
        let mut index = Self {
            scene,
            by_number: Vec::with_capacity(scene.entities().len()),
            containers: Vec::new(),
            container_names: Vec::new(),
        };
        let mut primitives = 0;
        let mut entities = scene.numbered_entities();
        loop {
            let some: ArrayVec<_, TOGETHER> = entities.by_ref().take(TOGETHER).collect();
            if some.is_empty() {
                return index;
            }
            black_box(some.iter().fold(0.0, |loaded, (_, _, entity)| loaded + load(entity)));
            for (number, name, entity) in some {
                let container = match entity {
                    Entity::Primitive(primitive) => {
                        index.set(number, EntityIndex::Primitive(primitives));
                        primitives += 1;
                        describe(name, primitive);
                        continue;
                    }
                    Entity::Object(object) => Container::Object(object),
                    Entity::Table(table) => Container::Table(table),
                };
                index.set(number, EntityIndex::Container(index.containers.len() as u32));
                index.containers.push(container);
                index.container_names.push(name);
            }
        }
    }

    fn set(&mut self, number: usize, entity: EntityIndex) {
        self.by_number.resize(number, PackedEntity::NONE);
        self.by_number.push(PackedEntity::new(entity));
    }

    /// The entity of a name.
    pub(super) fn find(&self, name: &str) -> Option<EntityIndex> {
        self.by_number.get(self.scene.entity_number(name, 0)?)?.unpack()
    }

    /// The children of a container.
    pub(super) fn children(&self, container: &Container<'a>) -> ChildList<'a> {
        let object = match container {
            Container::Object(object) => object,
            Container::Table(table) => {
                let names = Names::Rows(table.ids().cloned());
                return ChildList { children: Vec::new(), entities: Vec::new(), names };
            }
        };
        let count = object.children().len();
        let (mut children, mut entities) = (Vec::with_capacity(count), Vec::with_capacity(count));
        let mut names = NameList::with_capacity(count);
        // Children often refer to entities in the order of their creation.
        let mut guess = 0;
        for (alias, child) in object.visible_children() {
            names.push(alias);
            children.push(child);
            let number = self.scene.entity_number(child.target(), guess);
            guess = number.unwrap_or(guess) + 1;
            let entity = number.and_then(|number| self.by_number.get(number).copied());
            entities.push(entity.unwrap_or(PackedEntity::NONE));
        }
        ChildList { children, entities, names: names.finish() }
    }
}

/// The children of a container; only names for a table.
pub(super) struct ChildList<'a> {
    pub(super) children: Vec<&'a Child>,
    /// The entity of each.
    pub(super) entities: Vec<PackedEntity>,
    pub(super) names: Names,
}

/// A sum that loads all of a primitive.
fn load(entity: &Entity) -> f64 {
    let Entity::Primitive(Primitive { shape, material, .. }) = entity else { return 0.0 };
    shape.radii().x + material.color.x + material.index + material.absorb.x + material.metallic
}

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
    pub(super) fn maps(
        &self,
        &(child, primitive): &(u32, u32),
        primitives: &[CompiledPrimitive],
    ) -> Option<LeafMaps> {
        Some(LeafMaps::new(&self.transform(child)?, primitives[primitive as usize].radii))
    }

    /// The image of the unit shape of a plain leaf.
    pub(super) fn image(
        &self,
        &(child, primitive): &(u32, u32),
        primitives: &[CompiledPrimitive],
    ) -> Option<LeafImage> {
        Some(LeafImage::new(&self.transform(child)?, &primitives[primitive as usize]))
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
    pub(super) fn image(&self, primitive: &CompiledPrimitive) -> LeafImage {
        LeafImage { group_from_unit: self.group_from_unit, exponents: primitive.exponents }
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
    pub(super) fn new(group_from_local: &Transform, primitive: &CompiledPrimitive) -> Self {
        Self {
            group_from_unit: group_from_unit(group_from_local, primitive.radii),
            exponents: primitive.exponents,
        }
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

/// The number of levels of each container, as [`object_heights`] counts them.
pub(super) fn heights(children: &[Arc<Vec<PackedEntity>>]) -> Vec<u32> {
    let child_objects: Vec<Vec<u32>> = children
        .iter()
        .map(|children| {
            let objects = children.iter().filter_map(|child| match child.unpack() {
                Some(EntityIndex::Container(container)) => Some(container),
                Some(EntityIndex::Primitive(_)) | None => None,
            });
            let mut objects: Vec<u32> = objects.collect();
            objects.sort_unstable();
            objects.dedup();
            objects
        })
        .collect();
    object_heights(&child_objects)
}
