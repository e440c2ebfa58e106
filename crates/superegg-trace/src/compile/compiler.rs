//! Compiling a scene: opens objects to their depth, shares equal groups, and reuses those of the scene before.

use std::collections::{HashMap, HashSet};
use std::sync::Arc;

use num_bigint::BigUint;
use superegg_geom::Transform;
use superegg_scene::{Child, MAX_DEPTH, Scene};

use super::assemble::{InflationSum, assemble};
use super::described::Described;
use super::index::{Container, EntityIndex, Index, PackedEntity, heights};
use super::parts::{FoldedLeaf, GroupItem, LeafMaps, Parts};
use super::patch::{Patchable, patched};
use super::signature::bits_of;
use super::survey::{Survey, SurveyWork, survey_object, survey_table};
use crate::scene::compiled::{CompiledScene, Count};
use crate::scene::group::{Group, NameRef, Names};
use crate::scene::id::SceneId;

/// In objects of more children only those that are objects are compared to find duplicates.
const MOST_COMPARED: usize = 1 << 16;

impl CompiledScene {
    /// Compiles the primitive or object named `root`. `None`, or a name that the scene does not have, makes an empty
    /// scene.
    ///
    /// Objects are opened `depth` levels deep, at most [`MAX_DEPTH`]. The root is level 1, and the primitives of the last
    /// level are included. Large objects are compiled in parallel, on the rayon pool of the calling thread.
    pub fn compile(scene: &Scene, root: Option<&str>, depth: u32) -> Self {
        Self::compile_after(scene, root, depth, None)
    }

    /// Compiles a changed version of the scene that `self` was compiled from.
    ///
    /// Groups without a change are reused. If only some children of a large object without objects have changed, only
    /// they are compiled. All answers are those of [`CompiledScene::compile`]; boxes may differ by the rounding of f32.
    #[must_use]
    pub fn recompile(&self, scene: &Scene, root: Option<&str>, depth: u32) -> Self {
        Self::compile_after(scene, root, depth, Some(self))
    }

    fn compile_after(scene: &Scene, root: Option<&str>, depth: u32, before: Option<&Self>) -> Self {
        let mut compiler = Compiler::new(scene, before);
        let root_group = match root.and_then(|name| compiler.index.find(name)) {
            None => None,
            Some(EntityIndex::Primitive(primitive)) => compiler.only_primitive(primitive),
            Some(EntityIndex::Container(container)) => compiler.open(container, depth.min(MAX_DEPTH)),
        };
        let names = &compiler.index.container_names;
        let opened = compiler
            .opened
            .into_iter()
            .filter_map(|((object, depth), group)| Some(((names[object as usize].into(), depth), group?)))
            .collect();
        let count = root_group.as_ref().map_or(BigUint::ZERO, |group| group.count.clone());
        Self {
            id: SceneId::next(),
            instance_count: Count::new(count),
            primitives: compiler.described.primitives,
            primitive_names: compiler.described.names,
            table_primitives: compiler.described.tables,
            materials: compiler.described.materials.all,
            root: root_group,
            root_name: root.unwrap_or_default().to_owned(),
            opened,
            box_inflation: compiler.inflation.mean(),
            reused_groups: compiler.reused,
            patched_groups: compiler.patched,
            reaches_depth: compiler.reaches_depth,
        }
    }
}

/// The state of compiling. Primitives and objects have indices in the order of the scene.
struct Compiler<'a> {
    before: Option<&'a CompiledScene>,
    index: Index<'a>,
    /// The children of each object; none for tables.
    children: Vec<Arc<Vec<&'a Child>>>,
    /// The entity of each child.
    child_entities: Vec<Arc<Vec<PackedEntity>>>,
    /// The number of levels of each container.
    heights: Vec<u32>,
    described: Described,
    /// The names of each container's children.
    names: Vec<Arc<Names>>,
    /// The group of each (object, remaining depth); `None` if it is empty.
    opened: HashMap<(u32, u32), Option<Arc<Group>>>,
    inflation: InflationSum,
    /// The number of folded items in all groups. It counts reused groups too, so that it does not depend on history.
    folded: usize,
    reused: usize,
    patched: usize,
    reaches_depth: bool,
}

impl<'a> Compiler<'a> {
    fn new(scene: &'a Scene, before: Option<&'a CompiledScene>) -> Self {
        let (index, described) = Described::of(scene);
        let (mut children, mut child_entities, mut names) = (Vec::new(), Vec::new(), Vec::new());
        for container in &index.containers {
            let list = index.children(container);
            children.push(Arc::new(list.children));
            child_entities.push(Arc::new(list.entities));
            names.push(Arc::new(list.names));
        }
        Self {
            before,
            heights: heights(&child_entities),
            names,
            index,
            children,
            child_entities,
            described,
            opened: HashMap::new(),
            inflation: InflationSum::default(),
            folded: 0,
            reused: 0,
            patched: 0,
            reaches_depth: false,
        }
    }

    /// The group of a root that is a primitive.
    fn only_primitive(&mut self, primitive: u32) -> Option<Arc<Group>> {
        let maps = LeafMaps::new(&Transform::IDENTITY, self.described.radii[primitive as usize]);
        let leaf = FoldedLeaf { name: NameRef::ROOT, primitive, maps };
        let parts = Parts { folded: vec![leaf], primitive_count: 1, ..Parts::default() };
        self.assemble(parts, Arc::default(), Survey::NOTHING)
    }

    fn assemble(&mut self, parts: Parts<'a>, names: Arc<Names>, survey: Survey) -> Option<Arc<Group>> {
        let group = assemble(parts, names, survey, &self.described, &mut self.inflation, self.folded);
        group.map(Arc::new)
    }

    /// The group of a container opened to a remaining depth. Beyond its number of levels the group stays the same.
    fn open(&mut self, container: u32, remaining: u32) -> Option<Arc<Group>> {
        let remaining = remaining.min(self.heights[container as usize]);
        if remaining == 0 {
            return None;
        }
        if let Some(group) = self.opened.get(&(container, remaining)) {
            return group.clone();
        }
        let names = self.names[container as usize].clone();
        let parts = self.parts(container, remaining);
        // The lookup needs an owned key. Groups are few.
        let key = (Box::from(self.index.container_names[container as usize]), remaining);
        let before = self.before.and_then(|before| before.opened.get(&key));
        let table = match parts.container {
            Some(Container::Table(table)) => Some(table),
            Some(Container::Object(_)) | None => None,
        };
        let patchable = before
            .filter(|_| table.is_none())
            .zip(self.before)
            .and_then(|(group, scene)| Patchable::new(group, &scene.primitives, &parts));
        let survey = match table {
            Some(table) => survey_table(&parts, table),
            None => {
                let work = SurveyWork { keeps_boxes: before.is_none(), before: patchable.as_ref() };
                survey_object(&parts, &names, &self.described, work)
            }
        };
        let reused = before.filter(|group| group.signature == survey.signature).cloned();
        let group = if reused.is_some() {
            self.reused += 1;
            reused
        } else {
            let group = patchable.and_then(|patchable| {
                let Survey { changed, signature, .. } = &survey;
                patched(&patchable, &parts, &self.described, changed, &names, *signature).map(Arc::new)
            });
            self.patched += usize::from(group.is_some());
            group.or_else(|| self.assemble(parts, names, survey))
        };
        self.folded += group.as_ref().map_or(0, |group| group.folded.len());
        self.opened.insert((container, remaining), group.clone());
        group
    }

    /// The content of a group, with the groups of its children opened.
    fn parts(&mut self, container: u32, remaining: u32) -> Parts<'a> {
        let description = match self.index.containers[container as usize] {
            Container::Object(object) => object,
            Container::Table(_) => return self.rows(container),
        };
        let mut parts = Parts {
            children: self.children[container as usize].clone(),
            container: Some(Container::Object(description)),
            ..Parts::default()
        };
        let compares_all = parts.children.len() <= MOST_COMPARED;
        let mut seen = HashSet::new();
        let entities = self.child_entities[container as usize].clone();
        let is_primitive =
            |entity: &&PackedEntity| matches!(entity.unpack(), Some(EntityIndex::Primitive(_)));
        parts.leaves.reserve_exact(entities.iter().filter(is_primitive).count());
        for (child, entity) in entities.iter().enumerate() {
            let description_of_child = parts.children[child];
            let transform = || description.parent_from_child(description_of_child).ok();
            let child = child as u32;
            match entity.unpack() {
                None => {}
                Some(EntityIndex::Primitive(primitive)) => {
                    parts.primitive_count += 1;
                    // Only the first of equal children with equal transforms can be hit. All of them count.
                    let is_new =
                        !compares_all || transform().is_some_and(|map| seen.insert((*entity, bits_of(&map))));
                    if is_new {
                        parts.leaves.push((child, primitive));
                    }
                }
                Some(EntityIndex::Container(target)) => {
                    let Some(group) = self.open(target, remaining - 1) else {
                        self.reaches_depth |=
                            remaining == 1 && !self.index.containers[target as usize].is_empty();
                        continue;
                    };
                    let Some(parent_from_child) = transform() else { continue };
                    parts.group_count += &group.count;
                    if seen.insert((*entity, bits_of(&parent_from_child))) {
                        let name = NameRef::child(child);
                        parts.groups.push(GroupItem { name, parent_from_child, group });
                    }
                }
            }
        }
        parts
    }

    /// The rows of a table as the content of a group.
    fn rows(&self, container: u32) -> Parts<'a> {
        let description = self.index.containers[container as usize];
        let Container::Table(table) = description else { return Parts::default() };
        let name = self.index.container_names[container as usize];
        let first =
            self.described.tables.iter().find(|(_, held)| **held == *name).map_or(0, |(first, _)| *first);
        let leaf = |row: usize| (row as u32, first + table.shape_index(row));
        Parts {
            container: Some(description),
            leaves: (0..table.len()).map(leaf).collect(),
            primitive_count: table.len() as u64,
            ..Parts::default()
        }
    }
}
