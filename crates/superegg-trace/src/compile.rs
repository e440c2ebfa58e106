//! From the description of a scene to what rays hit.

use std::collections::{HashMap, HashSet};
use std::sync::{Arc, OnceLock};

use foldhash::fast::RandomState;
use num_bigint::BigUint;
use rayon::prelude::*;
use superegg_geom::glam::{DAffine3, DVec3};
use superegg_geom::{Aabb, Superquadric, Transform, inverse_of};
use superegg_scene::{Child, Entity, MAX_DEPTH, Material, Object, Pattern, Scene};

use crate::bvh::{PackedSlot, Slot, Tree, TreeSpace, UnitBox};
use crate::compiled::{
    Chain, CompiledPrimitive, CompiledScene, Group, Instance, Leaf, NameRef, Names, Swelling,
};
use crate::stream::Spare;
use crate::support;

mod patch;
use patch::Patchable;

/// Objects of more children are looked through for children in the same place only among those that are objects.
const MOST_COMPARED: usize = 1 << 16;

impl CompiledScene {
    /// Compiles what `root` names, or nothing for `None` or a name that the scene does not have. Objects are opened `depth` levels deep, at most
    /// [`MAX_DEPTH`]; the root is level 1, and primitives of the last level are included. Large objects are compiled on the threads of the
    /// pool in which this is called.
    pub fn compile(scene: &Scene, root: Option<&str>, depth: u32) -> Self {
        Self::compile_after(scene, root, depth, None)
    }

    /// Compiles a scene that has changed since this one was compiled. What depends on no change is taken over, and where only some children
    /// of a large object without objects have changed, they alone are compiled. All answers are those of [`CompiledScene::compile`]; the box of
    /// such an object may be another by the rounding of f32.
    #[must_use]
    pub fn recompile(&self, scene: &Scene, root: Option<&str>, depth: u32) -> Self {
        Self::compile_after(scene, root, depth, Some(self))
    }

    fn compile_after(scene: &Scene, root: Option<&str>, depth: u32, before: Option<&Self>) -> Self {
        let mut compiler = Compiler::new(scene, before);
        let place = root.and_then(|name| compiler.place_of(name));
        let root_group = match place {
            None => None,
            Some(Place::Primitive(primitive)) => compiler.only_primitive(primitive),
            Some(Place::Object(object)) => compiler.open(object, depth.min(MAX_DEPTH)),
        };
        let names = &compiler.object_names;
        let opened = compiler
            .opened
            .into_iter()
            .filter_map(|((object, depth), group)| Some(((names[object as usize].into(), depth), group?)))
            .collect();
        let swelling = compiler.swelling;
        Self {
            instance_count: root_group.as_ref().map_or(BigUint::ZERO, |group| group.count.clone()),
            primitives: compiler.primitives,
            materials: compiler.materials,
            root: root_group,
            root_name: root.unwrap_or_default().to_owned(),
            opened,
            swelling: Swelling {
                avoided: if swelling.instances == 0 {
                    1.0
                } else {
                    swelling.avoided / swelling.instances as f64
                },
                ..swelling
            },
            reused_groups: compiler.reused,
            patched_groups: compiler.patched_groups,
            reaches_depth: compiler.reaches_depth,
            spare: Spare::default(),
        }
    }
}

/// The number of a name among those of its kind.
#[derive(Clone, Copy)]
enum Place {
    Primitive(u32),
    Object(u32),
}

/// A [`Place`] in 32 bits; [`PackedPlace::NONE`] is none.
#[derive(Clone, Copy)]
struct PackedPlace(u32);

impl PackedPlace {
    const OBJECT: u32 = 1 << 31;
    const NONE: Self = Self(u32::MAX);

    fn new(place: Place) -> Self {
        match place {
            Place::Primitive(i) => Self(i),
            Place::Object(i) => Self(i | Self::OBJECT),
        }
    }

    fn unpack(self) -> Option<Place> {
        match self.0 {
            u32::MAX => None,
            i if i & Self::OBJECT != 0 => Some(Place::Object(i & !Self::OBJECT)),
            i => Some(Place::Primitive(i)),
        }
    }
}

/// Compiling as it goes on. Primitives and objects are each numbered in the order of the scene.
struct Compiler<'a> {
    scene: &'a Scene,
    before: Option<&'a CompiledScene>,
    objects: Vec<&'a Object>,
    object_names: Vec<&'a str>,
    /// Each object's children.
    children: Vec<Arc<Vec<&'a Child>>>,
    /// What they are.
    child_places: Vec<Arc<Vec<PackedPlace>>>,
    /// How many levels an object has: 1 for one without objects, [`MAX_DEPTH`] for one that holds itself.
    heights: Vec<u32>,
    primitives: Vec<CompiledPrimitive>,
    materials: Vec<Material>,
    aliases: Vec<Option<Arc<Names>>>,
    /// The group of (object, remaining depth); `None` where it comes to nothing.
    opened: HashMap<(u32, u32), Option<Arc<Group>>>,
    swelling: Swelling,
    reused: usize,
    patched_groups: usize,
    reaches_depth: bool,
}

/// A child of a group that is a group.
struct GroupItem {
    child: u32,
    parent_from_child: Transform,
    group: Arc<Group>,
    /// Aliases of folded levels, the child's own first; empty where none was folded.
    chain: Chain,
}

/// A child of a group that is a primitive below folded levels, or the root.
struct FoldedLeaf {
    child: u32,
    primitive: u32,
    maps: LeafMaps,
    chain: Chain,
}

impl<'a> Compiler<'a> {
    fn new(scene: &'a Scene, before: Option<&'a CompiledScene>) -> Self {
        let ((places, objects, object_names), (primitives, materials)) =
            rayon::join(|| named(scene), || described(scene));
        let children_of = |object: &&'a Object| Arc::new(object.children().map(|(_, child)| child).collect());
        let children: Vec<Arc<Vec<&Child>>> = objects.iter().map(children_of).collect();
        let place = |child: &&Child| places.get(child.target()).copied().unwrap_or(PackedPlace::NONE);
        let child_places: Vec<Arc<Vec<PackedPlace>>> =
            children.iter().map(|children| Arc::new(each(children, place).collect())).collect();
        Self {
            scene,
            before,
            heights: heights(&child_places),
            aliases: vec![None; objects.len()],
            objects,
            object_names,
            children,
            child_places,
            primitives,
            materials: materials.all,
            opened: HashMap::new(),
            swelling: Swelling::default(),
            reused: 0,
            patched_groups: 0,
            reaches_depth: false,
        }
    }

    fn place_of(&self, name: &str) -> Option<Place> {
        match self.scene.get(name)? {
            Entity::Object(_) => {
                self.object_names.iter().position(|other| *other == name).map(|i| Place::Object(i as u32))
            }
            Entity::Primitive(_) => self
                .scene
                .primitives()
                .position(|(other, _)| other == name)
                .map(|i| Place::Primitive(i as u32)),
        }
    }

    /// The aliases of an object's children.
    fn names(&mut self, object: u32) -> Arc<Names> {
        let description = self.objects[object as usize];
        let make = || {
            let mut names = Names::with_capacity(description.children().len());
            description.children().for_each(|(alias, _)| names.push(alias));
            names.shrink();
            Arc::new(names)
        };
        self.aliases[object as usize].get_or_insert_with(make).clone()
    }

    /// A group for a root that is a primitive.
    fn only_primitive(&mut self, primitive: u32) -> Option<Arc<Group>> {
        let maps = LeafMaps::new(&Transform::IDENTITY, self.primitives[primitive as usize].radii);
        let leaf = FoldedLeaf { child: 0, primitive, maps, chain: Vec::new() };
        let parts = Parts { folded: vec![leaf], primitive_count: 1, ..Parts::default() };
        self.assemble(parts, Arc::default(), 0, Aabb::EMPTY).map(Arc::new)
    }

    /// The group of an object opened to a remaining depth. An object of few levels is the same group from its height on.
    fn open(&mut self, object: u32, remaining: u32) -> Option<Arc<Group>> {
        let remaining = remaining.min(self.heights[object as usize]);
        if remaining == 0 {
            return None;
        }
        if let Some(group) = self.opened.get(&(object, remaining)) {
            return group.clone();
        }
        let description = self.objects[object as usize];
        let names = self.names(object);
        let mut parts = Parts {
            children: self.children[object as usize].clone(),
            object: Some(description),
            ..Parts::default()
        };
        let compares_all = parts.children.len() <= MOST_COMPARED;
        let mut seen = HashSet::new();
        let places = self.child_places[object as usize].clone();
        parts
            .leaves
            .reserve_exact(places.iter().filter(|p| matches!(p.unpack(), Some(Place::Primitive(_)))).count());
        for (child, place) in places.iter().enumerate() {
            let description_of_child = parts.children[child];
            let transform = || description.parent_from_child(description_of_child).ok();
            let child = child as u32;
            match place.unpack() {
                None => {}
                Some(Place::Primitive(primitive)) => {
                    parts.primitive_count += 1;
                    // The same thing in the same place is met as the first of them; it counts, but need not be traversed again.
                    let is_new =
                        !compares_all || transform().is_some_and(|map| seen.insert((place.0, bits_of(&map))));
                    if is_new {
                        parts.leaves.push((child, primitive));
                    }
                }
                Some(Place::Object(target)) => {
                    let Some(group) = self.open(target, remaining - 1) else {
                        self.reaches_depth |=
                            remaining == 1 && self.objects[target as usize].children().len() > 0;
                        continue;
                    };
                    let Some(parent_from_child) = transform() else { continue };
                    parts.group_count += &group.count;
                    if !seen.insert((place.0, bits_of(&parent_from_child))) {
                        continue;
                    }
                    self.push_group(&mut parts, child, parent_from_child, group, &names);
                }
            }
        }
        drop(seen);
        let key = (self.object_names[object as usize], remaining);
        // Hashing of borrowed pairs needs an owned key; groups are few.
        let before = self.before.and_then(|before| before.opened.get(&(Box::from(key.0), key.1)));
        let patchable = before.and_then(|group| Patchable::new(group, &parts));
        let Survey { signature, leaf_box, changed } = self.survey(&parts, &names, patchable.as_ref());
        let group = match (before, &patchable) {
            (Some(group), _) if group.signature == signature => {
                self.reused += 1;
                Some(group.clone())
            }
            (_, Some(patchable)) => match self.patched(patchable, &parts, &changed, &names, signature) {
                Some(group) => {
                    self.patched_groups += 1;
                    Some(Arc::new(group))
                }
                None => self.assemble(parts, names, signature, leaf_box).map(Arc::new),
            },
            _ => self.assemble(parts, names, signature, leaf_box).map(Arc::new),
        };
        self.opened.insert((object, remaining), group.clone());
        group
    }

    /// Takes a group as a child; one that has a single child itself is no level.
    fn push_group(
        &self,
        parts: &mut Parts<'a>,
        child: u32,
        parent_from_child: Transform,
        group: Arc<Group>,
        names: &Arc<Names>,
    ) {
        let chain_of = |name: NameRef| {
            let mut chain = vec![(names.clone(), child)];
            group.extend_chain(name, &mut chain);
            chain
        };
        match (&group.leaves[..], &group.instances[..]) {
            ([leaf], []) => {
                let maps = LeafMaps {
                    unit_from_group: leaf.unit_from_group * *parent_from_child.inverse(),
                    group_from_unit: *parent_from_child.forward() * inverse_of(&leaf.unit_from_group),
                };
                parts.folded.push(FoldedLeaf {
                    child,
                    primitive: leaf.primitive,
                    maps,
                    chain: chain_of(leaf.name),
                });
                return;
            }
            ([], [instance]) => {
                if let Ok(folded) = parent_from_child.after(&instance.parent_from_child) {
                    let (group, chain) = (instance.group.clone(), chain_of(instance.name));
                    parts.groups.push(GroupItem { child, parent_from_child: folded, group, chain });
                    return;
                }
            }
            _ => {}
        }
        parts.groups.push(GroupItem { child, parent_from_child, group, chain: Vec::new() });
    }

    /// Goes through what a group is made of, and says which leaves are others than before.
    fn survey(&self, parts: &Parts<'a>, names: &Names, before: Option<&Patchable<'_>>) -> Survey {
        let exponents_before = |leaf: &Leaf| {
            let before = self.before.and_then(|before| before.primitives.get(leaf.primitive as usize))?;
            Some(before.exponents)
        };
        let leaf = |&(child, primitive): &(u32, u32)| {
            let mut hash = Mixer::new(u64::from(child) << 32 | u64::from(primitive));
            let described = &self.primitives[primitive as usize];
            hash.shape(described);
            let maps = parts.transform(child).map(|map| {
                hash.words(bits_of(&map));
                LeafMaps::new(&map, described.radii)
            });
            let is_as_before = |before: &Patchable<'_>| {
                maps.as_ref().zip(before.leaf_before(child)).is_some_and(|(maps, leaf)| {
                    leaf.primitive == primitive
                        && leaf.unit_from_group == maps.unit_from_group
                        && exponents_before(leaf) == Some(described.exponents)
                })
            };
            let is_changed = before.is_some_and(|before| !is_as_before(before));
            Survey {
                signature: hash.0,
                leaf_box: maps.as_ref().map_or(Aabb::EMPTY, LeafMaps::loose_box),
                changed: if is_changed { vec![(child, primitive)] } else { Vec::new() },
            }
        };
        let mut survey = if parts.leaves.len() < LARGE {
            parts.leaves.iter().map(leaf).fold(Survey::NOTHING, Survey::join)
        } else {
            parts.leaves.par_iter().map(leaf).reduce(|| Survey::NOTHING, Survey::join)
        };
        let mut hash = Mixer::new(survey.signature);
        for folded in &parts.folded {
            hash.words([u64::from(folded.child), u64::from(folded.primitive)]);
            hash.shape(&self.primitives[folded.primitive as usize]);
            hash.words(folded.maps.unit_from_group.to_cols_array().map(f64::to_bits));
            folded.chain.iter().for_each(|(names, place)| hash.text(names.get(*place)));
        }
        for item in &parts.groups {
            hash.words([u64::from(item.child), item.group.signature]);
            hash.words(bits_of(&item.parent_from_child));
            item.chain.iter().for_each(|(names, place)| hash.text(names.get(*place)));
        }
        hash.text(names.text());
        hash.words([parts.primitive_count]);
        survey.signature = hash.0;
        survey
    }

    /// A group of its parts: loose bounds give the space of the tree, tight boxes the tree, and its order that of the leaves.
    fn assemble(
        &mut self,
        parts: Parts<'a>,
        names: Arc<Names>,
        signature: u64,
        leaf_box: Aabb,
    ) -> Option<Group> {
        let primitives = &self.primitives;
        let mut whole = leaf_box;
        whole = parts.folded.iter().fold(whole, |whole, leaf| whole.union(&leaf.maps.loose_box()));
        let group_boxes: Vec<Aabb> = parts
            .groups
            .iter()
            .map(|item| {
                let corners = item.group.bounds.transformed(&item.parent_from_child);
                let refined =
                    support::image_box(&item.group, primitives, &item.parent_from_child).rounded_outward();
                self.swelling.instances += 1;
                self.swelling.avoided += (corners.half_area() / refined.half_area()).max(1.0);
                refined
            })
            .collect();
        whole = group_boxes.iter().fold(whole, |whole, b| whole.union(b));
        if parts.leaves.is_empty() && parts.folded.is_empty() && parts.groups.is_empty() {
            return None;
        }
        let space = TreeSpace::of(&whole);
        let tight = |maps: &LeafMaps, primitive: u32| {
            space.unit_box(&maps.tight_box(&primitives[primitive as usize]))
        };
        let mut boxes: Vec<UnitBox> = each(&parts.leaves, |leaf| {
            parts.maps(leaf, primitives).map_or(UnitBox::POINT, |maps| tight(&maps, leaf.1))
        })
        .collect();
        boxes.extend(parts.folded.iter().map(|leaf| tight(&leaf.maps, leaf.primitive)));
        boxes.extend(group_boxes.iter().map(|b| space.unit_box(b)));
        let bounds = space.bounds_of(&boxes);
        let Tree { mut nodes, order } = Tree::build(&boxes);
        drop(boxes);

        let leaf_count = parts.leaves.len() + parts.folded.len();
        let mut chains: Vec<Chain> = Vec::new();
        let mut name_of = |child: u32, chain: Chain| {
            if chain.is_empty() {
                return NameRef::child(child);
            }
            chains.push(chain);
            NameRef::chain(chains.len() as u32 - 1)
        };
        let mut folded: Vec<Option<Leaf>> = Vec::with_capacity(parts.folded.len());
        for FoldedLeaf { child, primitive, maps, chain } in parts.folded {
            let name = if parts.object.is_none() { NameRef::ROOT } else { name_of(child, chain) };
            folded.push(Some(Leaf::new(maps.unit_from_group, primitive, name, primitives)));
        }
        let mut groups: Vec<Option<Instance>> = Vec::with_capacity(parts.groups.len());
        for GroupItem { child, parent_from_child, group, chain } in parts.groups {
            let name = name_of(child, chain);
            let stretch = stretch_of(&parent_from_child);
            groups.push(Some(Instance { parent_from_child, group, name, stretch }));
        }
        let (plain, object, children) = (&parts.leaves, parts.object, &parts.children);
        let make_plain = |item: u32| {
            let (child, primitive) = plain[item as usize];
            let map = object.and_then(|object| object.parent_from_child(children[child as usize]).ok());
            let radii = primitives[primitive as usize].radii;
            let unit_from_group = map.map_or(NOWHERE, |map| LeafMaps::new(&map, radii).unit_from_group);
            Leaf::new(unit_from_group, primitive, NameRef::child(child), primitives)
        };
        let mut instances = Vec::with_capacity(groups.len());
        let leaves = if leaf_count == plain.len() && groups.is_empty() {
            in_order(&order, make_plain)
        } else {
            // Leaves and groups are numbered apart, in the order of the tree.
            let mut leaves = Vec::with_capacity(leaf_count);
            let mut slot_of = Vec::with_capacity(order.len());
            for &item in &order {
                let place = item as usize;
                if place < leaf_count {
                    slot_of.push(PackedSlot::new(Slot::Leaf(leaves.len() as u32)));
                    let leaf = if place < plain.len() {
                        Some(make_plain(item))
                    } else {
                        folded[place - plain.len()].take()
                    };
                    leaves.extend(leaf);
                } else {
                    slot_of.push(PackedSlot::new(Slot::Instance(instances.len() as u32)));
                    instances.extend(groups[place - leaf_count].take());
                }
            }
            for node in &mut nodes {
                for slot in &mut node.slots[..node.count as usize] {
                    if let Slot::Leaf(place) = slot.unpack() {
                        *slot = slot_of[place as usize];
                    }
                }
            }
            leaves
        };
        let count = parts.group_count + parts.primitive_count;
        Some(Group {
            leaves,
            instances,
            nodes,
            space,
            bounds,
            names,
            chains,
            count,
            signature,
            growth: 1.0,
            stand_in: OnceLock::new(),
        })
    }
}

/// What each name of a scene stands for, and the objects with their names.
fn named(scene: &Scene) -> (HashMap<&str, PackedPlace, RandomState>, Vec<&Object>, Vec<&str>) {
    let mut places = HashMap::with_capacity_and_hasher(scene.entities().len(), RandomState::default());
    let (mut objects, mut object_names) = (Vec::new(), Vec::new());
    let mut primitives = 0;
    for (name, entity) in scene.entities() {
        match entity {
            Entity::Primitive(_) => {
                places.insert(name, PackedPlace::new(Place::Primitive(primitives)));
                primitives += 1;
            }
            Entity::Object(object) => {
                places.insert(name, PackedPlace::new(Place::Object(objects.len() as u32)));
                objects.push(object);
                object_names.push(name);
            }
        }
    }
    (places, objects, object_names)
}

/// The primitives of a scene, and their materials.
fn described(scene: &Scene) -> (Vec<CompiledPrimitive>, Materials) {
    let mut materials = Materials::default();
    // Room that is not used is not resident.
    let mut primitives = Vec::with_capacity(scene.entities().len());
    primitives.extend(scene.primitives().map(|(_, primitive)| CompiledPrimitive {
        radii: primitive.shape.radii(),
        exponents: primitive.shape.exponents(),
        material: materials.place_of(&primitive.material),
    }));
    primitives.shrink_to_fit();
    (primitives, materials)
}

/// From this many items on the threads share the work.
const LARGE: usize = 4096;

/// The map of a leaf that is nowhere: no ray meets it.
const NOWHERE: DAffine3 = DAffine3::NAN;

/// What is known of the content of a group before it is assembled.
struct Survey {
    /// What the content comes from, as one number: equal for equal content, and different for different content but by a chance of 1 in 2^64.
    signature: u64,
    /// Around all leaves that are no group's.
    leaf_box: Aabb,
    /// Child and primitive of those leaves that are others than in the group before.
    changed: Vec<(u32, u32)>,
}

impl Survey {
    const NOTHING: Self = Self { signature: 0, leaf_box: Aabb::EMPTY, changed: Vec::new() };

    fn join(mut self, other: Self) -> Self {
        self.changed.extend(other.changed);
        Self {
            signature: self.signature.wrapping_add(other.signature),
            leaf_box: self.leaf_box.union(&other.leaf_box),
            changed: self.changed,
        }
    }
}

/// What a group is made of.
#[derive(Default)]
struct Parts<'a> {
    /// `None` where the root is a primitive.
    object: Option<&'a Object>,
    children: Arc<Vec<&'a Child>>,
    /// Child and primitive.
    leaves: Vec<(u32, u32)>,
    folded: Vec<FoldedLeaf>,
    groups: Vec<GroupItem>,
    /// How many primitives it stands for: its own, those of children included that are met as another, and those of its groups.
    primitive_count: u64,
    group_count: BigUint,
}

impl Parts<'_> {
    fn transform(&self, child: u32) -> Option<Transform> {
        self.object?.parent_from_child(self.children[child as usize]).ok()
    }

    fn maps(&self, &(child, primitive): &(u32, u32), primitives: &[CompiledPrimitive]) -> Option<LeafMaps> {
        Some(LeafMaps::new(&self.transform(child)?, primitives[primitive as usize].radii))
    }
}

/// The two maps between a group and the unit shape of a leaf.
struct LeafMaps {
    unit_from_group: DAffine3,
    group_from_unit: DAffine3,
}

impl LeafMaps {
    fn new(group_from_local: &Transform, radii: DVec3) -> Self {
        Self {
            unit_from_group: DAffine3::from_scale(radii.recip()) * *group_from_local.inverse(),
            group_from_unit: *group_from_local.forward() * DAffine3::from_scale(radii),
        }
    }

    /// A box that holds the image of [-1, 1]^3.
    fn loose_box(&self) -> Aabb {
        let columns = self.group_from_unit.matrix3;
        Aabb::around(
            self.group_from_unit.translation,
            columns.x_axis.abs() + columns.y_axis.abs() + columns.z_axis.abs(),
        )
    }

    /// The smallest box around the shape, but for rounding.
    fn tight_box(&self, primitive: &CompiledPrimitive) -> Aabb {
        let linear = &self.group_from_unit.matrix3;
        Aabb::around(self.group_from_unit.translation, primitive.unit_shape().half_extent_under(linear))
            .rounded_outward()
    }
}

/// Work on each of some items, by many threads where there are many.
struct Each<'a, T, F> {
    items: &'a [T],
    work: F,
}

fn each<T: Sync, R: Send, F: Fn(&T) -> R + Send + Sync>(items: &[T], work: F) -> Each<'_, T, F> {
    Each { items, work }
}

impl<T: Sync, F> Each<'_, T, F> {
    fn collect<R: Send>(self) -> Vec<R>
    where
        F: Fn(&T) -> R + Send + Sync,
    {
        if self.items.len() < LARGE {
            self.items.iter().map(self.work).collect()
        } else {
            self.items.par_iter().map(self.work).collect()
        }
    }
}

/// Leaves in the order of a tree. Many are made in their own order, each thread those of its part: what they are made of lies in memory in that
/// order, and waiting for it costs more than all else.
fn in_order(order: &[u32], make: impl Fn(u32) -> Leaf + Sync) -> Vec<Leaf> {
    if order.len() < LARGE {
        return order.iter().map(|&item| make(item)).collect();
    }
    let mut place_of = vec![0u32; order.len()];
    (0..).zip(order).for_each(|(place, &item)| place_of[item as usize] = place);
    let nobody = Leaf { unit_from_group: NOWHERE, primitive: 0, name: NameRef::ROOT, lane_powers: None };
    let mut leaves: Vec<Leaf> = order.par_iter().map(|_| nobody).collect();
    let part = order.len().div_ceil(rayon::current_num_threads());
    leaves.par_chunks_mut(part).enumerate().for_each(|(number, leaves)| {
        for (item, &place) in place_of.iter().enumerate() {
            let place = (place as usize).checked_sub(number * part);
            if let Some(leaf) = place.and_then(|place| leaves.get_mut(place)) {
                *leaf = make(item as u32);
            }
        }
    });
    leaves
}

/// Materials, each once.
#[derive(Default)]
struct Materials {
    all: Vec<Material>,
    places: HashMap<[u64; 23], u32, RandomState>,
}

impl Materials {
    fn place_of(&mut self, material: &Material) -> u32 {
        *self.places.entry(material_bits(material)).or_insert_with(|| {
            self.all.push(*material);
            self.all.len() as u32 - 1
        })
    }
}

fn material_bits(material: &Material) -> [u64; 23] {
    let Material {
        color,
        ambient,
        reflected,
        refracted,
        gloss,
        diffuse,
        specular,
        index,
        shininess,
        fresnel,
        absorb,
        pattern,
    } = material;
    // No share is negative, so -1 can stand for one that is not set.
    let optional = |share: &Option<f64>| share.unwrap_or(-1.0);
    let (kind, second, detail) = match *pattern {
        Pattern::None => (0.0, DVec3::ZERO, DVec3::ZERO),
        Pattern::Checker { color, size } => (1.0, color, DVec3::splat(size)),
        Pattern::Gradient { color, direction } => (2.0, color, direction),
    };
    let numbers = [
        color.x,
        color.y,
        color.z,
        *ambient,
        optional(reflected),
        optional(refracted),
        *gloss,
        *diffuse,
        *specular,
        *index,
        optional(shininess),
        f64::from(u8::from(*fresnel)),
        absorb.x,
        absorb.y,
        absorb.z,
        kind,
        second.x,
        second.y,
        second.z,
        detail.x,
        detail.y,
        detail.z,
        0.0,
    ];
    numbers.map(f64::to_bits)
}

/// A hash of words by folded multiplication.
struct Mixer(u64);

impl Mixer {
    fn new(first: u64) -> Self {
        let mut mixer = Self(0x9e37_79b9_7f4a_7c15);
        mixer.words([first]);
        mixer
    }

    fn words<const N: usize>(&mut self, words: [u64; N]) {
        for word in words {
            let product = u128::from(self.0 ^ word ^ 0xa076_1d64_78bd_642f)
                * u128::from(word.rotate_left(32) ^ 0xe703_7ed1_a0b4_28db);
            self.0 = (product as u64 ^ (product >> 64) as u64).wrapping_add(self.0.rotate_left(23));
        }
    }

    fn shape(&mut self, primitive: &CompiledPrimitive) {
        let CompiledPrimitive { radii, exponents, .. } = primitive;
        self.words([radii.x, radii.y, radii.z, exponents.e(), exponents.n()].map(f64::to_bits));
    }

    fn text(&mut self, text: &str) {
        self.words([text.len() as u64]);
        for chunk in text.as_bytes().chunks(8) {
            let mut word = [0; 8];
            word[..chunk.len()].copy_from_slice(chunk);
            self.words([u64::from_le_bytes(word)]);
        }
    }
}

/// At most by so much does a map stretch a length (its Frobenius norm).
fn stretch_of(map: &Transform) -> f64 {
    let columns = map.forward().matrix3;
    let largest =
        columns.x_axis.length_squared() + columns.y_axis.length_squared() + columns.z_axis.length_squared();
    // A rotation with one scale has three times the square of that scale.
    let bound = largest.sqrt();
    let by_lengths = columns.x_axis.length().max(columns.y_axis.length()).max(columns.z_axis.length());
    let skew = columns
        .x_axis
        .dot(columns.y_axis)
        .abs()
        .max(columns.x_axis.dot(columns.z_axis).abs())
        .max(columns.y_axis.dot(columns.z_axis).abs());
    if skew <= 1e-9 * by_lengths * by_lengths { by_lengths } else { bound }
}

/// The smallest axis-aligned box around the image of a shape.
pub(crate) fn world_bounds(shape: &Superquadric, world_from_local: &Transform) -> Aabb {
    let forward = world_from_local.forward();
    Aabb::around(forward.translation, shape.half_extent_under(&forward.matrix3))
}

/// The bits of a transform, to tell whether two are the same.
fn bits_of(transform: &Transform) -> [u64; 12] {
    transform.forward().to_cols_array().map(f64::to_bits)
}

/// How many levels each object has, at most [`MAX_DEPTH`], from the objects among its children.
fn heights(child_places: &[Arc<Vec<PackedPlace>>]) -> Vec<u32> {
    let child_objects: Vec<Vec<u32>> = child_places
        .iter()
        .map(|places| {
            let objects = places.iter().filter_map(|place| match place.unpack() {
                Some(Place::Object(object)) => Some(object),
                _ => None,
            });
            let mut objects: Vec<u32> = objects.collect();
            objects.sort_unstable();
            objects.dedup();
            objects
        })
        .collect();
    let mut heights = vec![1; child_objects.len()];
    // Each round gets one more level right; those on or above a circle go up to the limit.
    for _ in 1..MAX_DEPTH {
        let mut changed = false;
        for (object, children) in child_objects.iter().enumerate() {
            let below = children.iter().map(|&child| heights[child as usize]).max().unwrap_or(0);
            let height = (below + 1).min(MAX_DEPTH);
            changed |= height != heights[object];
            heights[object] = height;
        }
        if !changed {
            break;
        }
    }
    heights
}
