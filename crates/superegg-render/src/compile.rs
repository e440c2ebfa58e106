//! From the description of a scene to what rays hit.

use std::collections::{HashMap, HashSet};

use num_bigint::BigUint;
use superegg_geom::{Aabb, Superquadric, Transform};
use superegg_scene::{Entity, MAX_DEPTH, Object, Scene};

use crate::bvh::Bvh;
use crate::compiled::{CompiledPrimitive, CompiledScene, Group, Instance, Target};

impl CompiledScene {
    /// Compiles what `root` names, or nothing for `None` or a name that the scene does not have. Objects are opened `depth` levels deep, at most
    /// [`MAX_DEPTH`]; the root is level 1, and primitives of the last level are included.
    pub fn compile(scene: &Scene, root: Option<&str>, depth: u32) -> Self {
        let mut compiler = Compiler::new(scene);
        let target = root.and_then(|name| compiler.target_of(name, depth.min(MAX_DEPTH)));
        let instance_count = target.map_or(BigUint::ZERO, |target| compiler.instances_of(target));
        Self {
            primitives: compiler.primitives,
            groups: compiler.groups,
            root: target,
            root_name: root.unwrap_or_default().to_owned(),
            aliases: compiler.aliases,
            instance_count,
        }
    }
}

/// The number of a name among those of its kind.
#[derive(Clone, Copy)]
enum Place {
    Primitive(u32),
    Object(u32),
}

/// Compiling as it goes on. Primitives and objects are each numbered in the order of the scene.
struct Compiler<'a> {
    places: HashMap<&'a str, Place>,
    objects: Vec<&'a Object>,
    /// How many levels an object has: 1 for one without objects, [`MAX_DEPTH`] for one that holds itself.
    heights: Vec<u32>,
    primitives: Vec<CompiledPrimitive>,
    aliases: Vec<Vec<Box<str>>>,
    groups: Vec<Group>,
    /// How many primitives each group stands for.
    counts: Vec<BigUint>,
    /// The group of (object, remaining depth); `None` where it comes to nothing.
    opened: HashMap<(u32, u32), Option<u32>>,
}

impl<'a> Compiler<'a> {
    fn new(scene: &'a Scene) -> Self {
        let mut places = HashMap::new();
        let mut objects = Vec::new();
        let mut primitives = Vec::new();
        for (name, entity) in scene.entities() {
            match entity {
                Entity::Primitive(primitive) => {
                    places.insert(name, Place::Primitive(primitives.len() as u32));
                    primitives
                        .push(CompiledPrimitive { shape: primitive.shape, material: primitive.material });
                }
                Entity::Object(object) => {
                    places.insert(name, Place::Object(objects.len() as u32));
                    objects.push(object);
                }
            }
        }
        let object_among = |target: &str| match places.get(target) {
            Some(Place::Object(object)) => Some(*object),
            _ => None,
        };
        let child_objects: Vec<Vec<u32>> = objects
            .iter()
            .map(|object: &&Object| object.children().filter_map(|(_, c)| object_among(c.target())).collect())
            .collect();
        let aliases =
            objects.iter().map(|object| object.children().map(|(alias, _)| alias.into()).collect()).collect();
        Self {
            places,
            objects,
            heights: heights(&child_objects),
            primitives,
            aliases,
            groups: Vec::new(),
            counts: Vec::new(),
            opened: HashMap::new(),
        }
    }

    /// What a name stands for when objects may be opened `remaining` levels deep; `None` where that is nothing.
    fn target_of(&mut self, name: &str, remaining: u32) -> Option<Target> {
        match *self.places.get(name)? {
            Place::Primitive(primitive) => Some(Target::Primitive(primitive)),
            Place::Object(object) => self.open(object, remaining).map(Target::Group),
        }
    }

    /// The group of an object opened to a remaining depth. An object of few levels is the same group from its height on.
    fn open(&mut self, object: u32, remaining: u32) -> Option<u32> {
        let remaining = remaining.min(self.heights[object as usize]);
        if remaining == 0 {
            return None;
        }
        if let Some(&group) = self.opened.get(&(object, remaining)) {
            return group;
        }
        let description = self.objects[object as usize];
        let mut instances: Vec<Instance> = Vec::new();
        let mut seen = HashSet::new();
        let mut count = BigUint::ZERO;
        for (place, (_, child)) in description.children().enumerate() {
            let Ok(parent_from_child) = description.parent_from_child(child) else { continue };
            let Some(target) = self.target_of(child.target(), remaining - 1) else { continue };
            count += self.instances_of(target);
            // The same thing in the same place is met as the first of them; it counts, but need not be traversed again.
            if !seen.insert((target, bits_of(&parent_from_child))) {
                continue;
            }
            let bounds = self.bounds_of(target, &parent_from_child).rounded_outward();
            instances.push(Instance { parent_from_child, bounds, target, child: place as u32 });
        }
        let group = if instances.is_empty() { None } else { Some(self.push_group(object, instances, count)) };
        self.opened.insert((object, remaining), group);
        group
    }

    fn push_group(&mut self, object: u32, instances: Vec<Instance>, count: BigUint) -> u32 {
        let boxes: Vec<Aabb> = instances.iter().map(|instance| instance.bounds).collect();
        self.counts.push(count);
        self.groups.push(Group { object, instances, bvh: Bvh::build(&boxes) });
        self.groups.len() as u32 - 1
    }

    fn instances_of(&self, target: Target) -> BigUint {
        match target {
            Target::Primitive(_) => BigUint::from(1u32),
            Target::Group(group) => self.counts[group as usize].clone(),
        }
    }

    fn bounds_of(&self, target: Target, parent_from_child: &Transform) -> Aabb {
        match target {
            Target::Primitive(primitive) => {
                world_bounds(&self.primitives[primitive as usize].shape, parent_from_child)
            }
            Target::Group(group) => self.groups[group as usize].bvh.bounds().transformed(parent_from_child),
        }
    }
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
fn heights(child_objects: &[Vec<u32>]) -> Vec<u32> {
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
