//! Small numbers of instances and objects, and their names: the ids that other programs keep.

use std::collections::HashMap;
use std::sync::{Arc, OnceLock};

use smallvec::SmallVec;

use crate::scene::compiled::{CompiledScene, PathEnd};
use crate::scene::group::{Group, NameRef};
use crate::scene::path::InstancePath;

/// Numbers the instances and the objects of a compiled scene.
///
/// The numbers are whole and at most 2^24, so that 32-bit floats hold them exactly. 0 is free for nothing, and
/// [`InstancePath::FLOOR_ID`] for the floor. They follow the order of children and depend on it alone, so they are the same
/// in every frame of an animation of a scene whose children stay.
///
/// ```
/// use superegg_geom::Ray;
/// use superegg_geom::glam::DVec3;
/// use superegg_scene::Scene;
/// use superegg_trace::{CompiledScene, InstanceNumbers};
///
/// let mut scene = Scene::default();
/// scene.ensure_primitive("ball")?;
/// let compiled = CompiledScene::compile(&scene, Some("ball"), 1);
/// let hit = compiled.intersect_ray(&Ray::new(DVec3::new(0.0, 0.0, 5.0), DVec3::NEG_Z)).expect("a hit");
/// let numbers = InstanceNumbers::of(&compiled);
/// assert_eq!((numbers.instance(&hit.path), numbers.object(&hit.path)), (2, 2));
/// # Ok::<(), superegg_scene::SceneError>(())
/// ```
#[derive(Debug)]
pub struct InstanceNumbers<'a> {
    scene: &'a CompiledScene,
    /// The numbers within each group, by its signature, made when they are first needed. `None` if the scene has too many
    /// instances.
    groups: Option<HashMap<u64, OnceLock<GroupNumbers>>>,
}

/// For each leaf and each instance of a group the number of primitives that come before it.
#[derive(Debug)]
struct GroupNumbers {
    leaves: Box<[u32]>,
    instances: Box<[u32]>,
}

/// The first number of an instance.
const FIRST: u32 = InstancePath::FLOOR_ID + 1;

impl<'a> InstanceNumbers<'a> {
    /// The greatest number.
    pub const GREATEST: u32 = 1 << 24;

    /// The numbers of a scene. It takes time and memory for the groups of the graph, and for the children of those groups
    /// whose instances are numbered.
    pub fn of(scene: &'a CompiledScene) -> Self {
        let most = u64::from(Self::GREATEST - FIRST);
        let is_small = scene.instance_count().to_u64().is_some_and(|count| count <= most);
        let groups = is_small.then(|| {
            let mut groups = HashMap::new();
            let mut waiting: Vec<&Arc<Group>> = scene.root.iter().collect();
            while let Some(group) = waiting.pop() {
                if groups.insert(group.signature, OnceLock::new()).is_none() {
                    waiting.extend(group.instances.iter().map(|instance| &instance.group));
                }
            }
            groups
        });
        Self { scene, groups }
    }

    /// The number of an instance. No other instance has it, unless the scene has more than [`InstanceNumbers::GREATEST`]
    /// instances: then it is a hash of the path, and few of the instances in a picture share one. A group that is hit as a
    /// whole has the number of its first instance.
    pub fn instance(&self, path: &InstancePath) -> u32 {
        let Some(groups) = &self.groups else { return hashed(self.scene.instance_id(path)) };
        let (passed, end) = self.scene.groups_along(path);
        let within = |group: &Group| {
            groups.get(&group.signature).map(|numbers| numbers.get_or_init(|| GroupNumbers::of(group)))
        };
        let above: u32 = passed
            .iter()
            .filter_map(|(group, index)| within(group)?.instances.get(*index as usize).copied())
            .sum();
        let last = path.indices().last().map_or(0, |last| (last & !InstancePath::INSTANCE) as usize);
        let here = match end {
            PathEnd::Leaf(group, _) => within(group).map(|numbers| numbers.leaves[last]),
            PathEnd::Proxy(group, _) => within(group).map(|numbers| numbers.instances[last]),
            PathEnd::Nowhere => None,
        };
        FIRST + above + here.unwrap_or(0)
    }

    /// The number of the object that an instance belongs to: the child of the root, or, below objects of a single child, of
    /// the first object that has several. Children beyond [`InstanceNumbers::GREATEST`] have hashes.
    pub fn object(&self, path: &InstancePath) -> u32 {
        let mut found = None;
        self.scene.for_each_level(path, |group, child| {
            found = found.or(child.filter(|_| !group.has_one_child));
        });
        match found {
            Some(child) if child <= Self::GREATEST - FIRST => FIRST + child,
            Some(child) => hashed(child),
            None => FIRST,
        }
    }

    /// The name of that object: the root's name and the aliases down to it, joined by `/`.
    pub fn object_name(&self, path: &InstancePath) -> String {
        let mut name = self.scene.root_name.clone();
        let mut is_found = false;
        self.scene.for_each_level(path, |group, child| {
            if let Some(child) = child.filter(|_| !is_found) {
                name.push('/');
                name.push_str(&group.names.get(child));
                is_found = !group.has_one_child;
            }
        });
        name
    }
}

/// A number from a hash.
fn hashed(hash: u32) -> u32 {
    FIRST + hash % (InstanceNumbers::GREATEST - FIRST)
}

impl GroupNumbers {
    fn of(group: &Group) -> Self {
        let rank = |name: NameRef| {
            let mut rank = SmallVec::<[u32; 4]>::new();
            group.for_each_level(name, |_, child| rank.extend(child));
            rank
        };
        let count = |index: usize| match index.checked_sub(group.leaves.len()) {
            None => 1,
            // The scene has no more instances than fit.
            Some(index) => u32::try_from(&group.instances[index].group.count).unwrap_or(u32::MAX),
        };
        let names = group
            .leaves
            .iter()
            .map(|leaf| leaf.name)
            .chain(group.instances.iter().map(|instance| instance.name));
        let mut order: Vec<(SmallVec<[u32; 4]>, usize)> =
            names.enumerate().map(|(index, name)| (rank(name), index)).collect();
        order.sort_unstable();
        let mut before = vec![0; group.item_count()];
        let mut sum = 0u32;
        for (_, index) in order {
            before[index] = sum;
            sum = sum.saturating_add(count(index));
        }
        let instances = before.split_off(group.leaves.len());
        Self { leaves: before.into(), instances: instances.into() }
    }
}
