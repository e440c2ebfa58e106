//! The entities of a scene by index.

use std::hint::black_box;
use std::sync::Arc;

use arrayvec::ArrayVec;
use superegg_scene::{Child, Entity, InstanceTable, Object, Primitive, Scene, object_heights};

use crate::scene::group::{NameList, Names};

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
