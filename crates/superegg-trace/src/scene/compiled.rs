//! The compiled scene: a graph of groups, and what is known about it.

use std::collections::HashMap;
use std::fmt;
use std::sync::Arc;

use num_bigint::BigUint;
use superegg_geom::Aabb;
use superegg_geom::glam::DAffine3;
use superegg_scene::Material;

use super::group::{Group, Instance, Leaf, Names};
use super::id::SceneId;
use super::path::InstancePath;
use super::primitive::{CompiledPrimitive, Primitives};

/// The number of instances of primitives: exact, however large.
///
/// A fractal of 64 levels has more instances than a `u128` holds. `Display` writes all digits.
#[derive(Clone, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Count(BigUint);

impl Count {
    pub(crate) fn new(count: BigUint) -> Self {
        Self(count)
    }

    /// The nearest f64, or infinity.
    pub fn to_f64(&self) -> f64 {
        // The decimal text is parsed to the nearest f64, and to infinity beyond the range.
        self.0.to_string().parse().unwrap_or(f64::INFINITY)
    }

    /// The exact value, if a `u64` holds it.
    pub fn to_u64(&self) -> Option<u64> {
        u64::try_from(&self.0).ok()
    }

    /// Whether there is no instance.
    pub fn is_zero(&self) -> bool {
        self.0 == BigUint::ZERO
    }
}

impl fmt::Display for Count {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

/// How much larger the boxes of groups would be if they were made from the corners of the child's box.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BoxInflation {
    /// The number of children that are groups.
    pub instances: u64,
    /// The mean, over these children, of the surface area of the box around the transformed corners as a multiple of the
    /// surface area of the box in use. At least 1.
    pub mean_ratio: f64,
}

/// A scene compiled for ray and point queries.
///
/// It is a graph of groups, one for each object and remaining depth. A group is shared wherever its object is opened to
/// that depth, so a self-referring object stays a small graph. The scene is immutable: any number of threads may query it,
/// and every query is deterministic.
///
/// ```
/// use superegg_geom::Ray;
/// use superegg_geom::glam::DVec3;
/// use superegg_scene::Scene;
/// use superegg_trace::CompiledScene;
///
/// let mut scene = Scene::default();
/// scene.ensure_primitive("ball")?;
/// let compiled = CompiledScene::compile(&scene, Some("ball"), 1);
/// assert_eq!(compiled.instance_count().to_string(), "1");
/// let ray = Ray::new(DVec3::new(0.0, 0.0, 5.0), DVec3::NEG_Z);
/// let hit = compiled.intersect_ray(&ray).expect("the ray points at the ball");
/// assert_eq!(hit.t, 4.0);
/// assert_eq!(compiled.path_name(&hit.path), "ball");
/// # Ok::<(), superegg_scene::SceneError>(())
/// ```
#[derive(Clone, Debug)]
pub struct CompiledScene {
    pub(crate) id: SceneId,
    pub(crate) primitives: Primitives,
    /// The name of each primitive that is no shape of a table.
    pub(crate) primitive_names: Names,
    /// The first primitive and the name of each table. Its shapes follow in their order.
    pub(crate) table_primitives: Vec<(u32, Box<str>)>,
    pub(crate) materials: Vec<Material>,
    pub(crate) root: Option<Arc<Group>>,
    pub(crate) root_name: String,
    /// The groups by object and remaining depth.
    pub(crate) opened: HashMap<(Box<str>, u32), Arc<Group>>,
    pub(crate) instance_count: Count,
    pub(crate) box_inflation: BoxInflation,
    pub(crate) reused_groups: usize,
    pub(crate) patched_groups: usize,
    pub(crate) reaches_depth: bool,
}

impl CompiledScene {
    /// The primitive of this index.
    ///
    /// # Panics
    ///
    /// If the index is not below [`CompiledScene::primitive_count`].
    pub fn primitive(&self, index: u32) -> CompiledPrimitive {
        self.primitives.get(index)
    }

    /// The number of primitives of the scene, whether or not the compiled object uses them.
    pub fn primitive_count(&self) -> usize {
        self.primitives.len()
    }

    /// The name of the primitive of this index, or of the table that has it; `None` if there is no such primitive.
    pub fn primitive_name(&self, index: u32) -> Option<&str> {
        if index as usize >= self.primitives.len() {
            return None;
        }
        let tables_before = self.table_primitives.partition_point(|(first, _)| *first <= index);
        match tables_before.checked_sub(1) {
            Some(table) => Some(&self.table_primitives[table].1),
            None => self.primitive_names.alias(index),
        }
    }

    /// The materials of all primitives, each once.
    pub fn materials(&self) -> &[Material] {
        &self.materials
    }

    /// The material of a primitive.
    pub fn material_of(&self, primitive: &CompiledPrimitive) -> &Material {
        &self.materials[primitive.material as usize]
    }

    /// The number of groups in the graph.
    pub fn group_count(&self) -> usize {
        self.opened.len()
    }

    /// The number of groups that [`CompiledScene::recompile`] took over unchanged.
    pub fn reused_group_count(&self) -> usize {
        self.reused_groups
    }

    /// The number of groups that [`CompiledScene::recompile`] took over with some leaves replaced.
    pub fn patched_group_count(&self) -> usize {
        self.patched_groups
    }

    /// The number of instances of primitives.
    pub fn instance_count(&self) -> &Count {
        &self.instance_count
    }

    /// Whether an object was left out because it lies deeper than the requested depth.
    pub fn reaches_depth(&self) -> bool {
        self.reaches_depth
    }

    /// The gain of the refined boxes of groups.
    pub fn box_inflation(&self) -> BoxInflation {
        self.box_inflation
    }

    /// The memory of primitives, groups and trees, in bytes.
    pub fn bytes(&self) -> usize {
        self.primitives.bytes()
            + self.materials.capacity() * size_of::<Material>()
            + self.opened.values().map(|group| group.bytes()).sum::<usize>()
    }

    /// The bounding box in world units; `None` for an empty scene.
    pub fn bounds(&self) -> Option<Aabb> {
        self.root.as_ref().map(|root| root.bounds)
    }

    /// The diameter of the bounding box; 0 for an empty scene.
    pub(crate) fn size(&self) -> f64 {
        self.root.as_ref().map_or(0.0, |root| root.size())
    }

    /// No surface is farther from a point in the box.
    pub(crate) fn reach_from(&self, origins: &Aabb) -> f64 {
        self.root.as_ref().map_or(0.0, |root| 2.0 * root.bounds.union(origins).half_extent().length())
    }

    /// The name of an instance: the root's name and the aliases down to the primitive, joined by `/`.
    pub fn path_name(&self, path: &InstancePath) -> String {
        let mut name = self.root_name.clone();
        self.for_each_level(path, |group, child| {
            if let Some(child) = child {
                name.push('/');
                name.push_str(&group.names.get(child));
            }
        });
        name
    }

    /// Whether the surface at the end of a path is refracting.
    pub fn lets_light_through(&self, path: &InstancePath) -> bool {
        let PathEnd::Leaf(_, leaf) = self.groups_along(path).1 else { return false };
        let material = self.primitives.get(leaf.primitive).material;
        self.materials[material as usize].refracted.is_some_and(|share| share > 0.0)
    }

    /// The indices of a path's children among the children of their objects. Paths are ordered by these lists,
    /// lexicographically.
    pub(crate) fn rank(&self, path: &InstancePath) -> Vec<u32> {
        let mut ranks = Vec::with_capacity(path.indices().len());
        self.for_each_level(path, |_, child| ranks.extend(child));
        ranks
    }

    /// The instance id of a picture: a hash of the path, greater than [`InstancePath::FLOOR_ID`].
    ///
    /// It depends on the order of children in their objects, not on the order of leaves in a tree, so it is the same each
    /// time the scene is compiled. Levels of a single child below the root are left out.
    pub fn instance_id(&self, path: &InstancePath) -> u32 {
        let mut hash = 0x811c_9dc5;
        let mut mix = |index: u32| hash = u32::wrapping_mul(hash ^ index, 0x0100_0193).rotate_left(15);
        let mut is_root = true;
        self.for_each_level(path, |group, child| {
            if is_root || !group.has_one_child {
                mix(child.unwrap_or(0));
            }
            is_root = false;
        });
        if path.is_proxy() {
            mix(InstancePath::INSTANCE);
        }
        (hash ^ (hash >> 16)).max(InstancePath::FLOOR_ID + 1)
    }

    /// Visits the levels of a path, as [`Group::for_each_level`].
    pub(crate) fn for_each_level(&self, path: &InstancePath, mut visit: impl FnMut(&Group, Option<u32>)) {
        let (passed, end) = self.groups_along(path);
        for (group, index) in &passed {
            group.for_each_level(group.instances[*index as usize].name, &mut visit);
        }
        match end {
            PathEnd::Leaf(group, leaf) => group.for_each_level(leaf.name, &mut visit),
            PathEnd::Proxy(group, instance) => group.for_each_level(instance.name, &mut visit),
            PathEnd::Nowhere => {}
        }
    }

    /// The groups along a path with the index of the instance to follow in each, and the end of the path.
    pub(crate) fn groups_along<'a>(&'a self, path: &InstancePath) -> (Vec<(&'a Group, u32)>, PathEnd<'a>) {
        let (Some(mut group), Some((&last, above))) = (self.root.as_deref(), path.indices().split_last())
        else {
            return (Vec::new(), PathEnd::Nowhere);
        };
        let mut passed = Vec::with_capacity(above.len());
        for &index in above {
            passed.push((group, index));
            group = &group.instances[index as usize].group;
        }
        let end = if last & InstancePath::INSTANCE == 0 {
            PathEnd::Leaf(group, &group.leaves[last as usize])
        } else {
            PathEnd::Proxy(group, &group.instances[(last & !InstancePath::INSTANCE) as usize])
        };
        (passed, end)
    }
}

/// The map from the world to the last of the groups along a path.
pub(crate) fn group_from_world(passed: &[(&Group, u32)]) -> DAffine3 {
    passed.iter().fold(DAffine3::IDENTITY, |map, (group, index)| {
        *group.instances[*index as usize].map().inverse() * map
    })
}

/// The end of a path.
pub(crate) enum PathEnd<'a> {
    /// A primitive of a group.
    Leaf(&'a Group, &'a Leaf),
    /// A child of a group that is hit as a whole.
    Proxy(&'a Group, &'a Instance),
    /// The path is empty.
    Nowhere,
}
