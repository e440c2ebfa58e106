//! The ids of surfaces, each found once for many hits.

use std::collections::{BTreeMap, HashMap};

use foldhash::fast::RandomState;
use superegg_trace::{CompiledScene, InstanceNumbers, InstancePath};

use crate::film::first::SurfaceIds;
use crate::film::matte::matte_id;

/// The ids of the surfaces that a thread meets.
pub(crate) struct SurfaceIdTable<'a> {
    scene: &'a CompiledScene,
    /// The small numbers; `None` if they are not wanted.
    numbers: Option<&'a InstanceNumbers<'a>>,
    by_path: HashMap<InstancePath, SurfaceIds, RandomState>,
    /// The names by their Cryptomatte ids; `None` if they are not wanted.
    names: Option<BTreeMap<u32, String>>,
}

/// More surfaces than this are forgotten: fractals have any number.
const MOST_SURFACES: usize = 1 << 12;
/// The name of the floor in mattes.
const FLOOR: &str = "floor";

impl<'a> SurfaceIdTable<'a> {
    /// The ids of a scene, with numbers and names if they are wanted.
    pub(crate) fn new(
        scene: &'a CompiledScene,
        numbers: Option<&'a InstanceNumbers<'a>>,
        with_names: bool,
    ) -> Self {
        Self { scene, numbers, by_path: HashMap::default(), names: with_names.then(BTreeMap::new) }
    }

    /// Forgets all surfaces and names, before another tile.
    pub(crate) fn clear(&mut self) {
        self.by_path.clear();
        if let Some(names) = &mut self.names {
            names.clear();
        }
    }

    /// The names that were found since the table was cleared, by their ids.
    pub(crate) fn names(&self) -> impl Iterator<Item = (u32, &str)> {
        self.names.iter().flatten().map(|(id, name)| (*id, name.as_str()))
    }

    /// The ids of an instance.
    pub(crate) fn of(&mut self, path: &InstancePath) -> SurfaceIds {
        if let Some(found) = self.by_path.get(path) {
            return *found;
        }
        let Self { scene, numbers, .. } = *self;
        let mut ids = SurfaceIds {
            id: scene.instance_id(path),
            instance: numbers.map_or(0, |numbers| numbers.instance(path)),
            object: numbers.map_or(0, |numbers| numbers.object(path)),
            names: [0; 2],
        };
        if let Some(numbers) = numbers.filter(|_| self.names.is_some()) {
            ids.names = [self.name(scene.path_name(path)), self.name(numbers.object_name(path))];
        }
        if self.by_path.len() >= MOST_SURFACES {
            self.by_path.clear();
        }
        self.by_path.insert(path.clone(), ids);
        ids
    }

    /// The ids of the floor.
    pub(crate) fn of_floor(&mut self) -> SurfaceIds {
        let id = InstancePath::FLOOR_ID;
        let name = if self.names.is_some() { self.name(FLOOR.to_owned()) } else { 0 };
        SurfaceIds { id, instance: id, object: id, names: [name; 2] }
    }

    /// Keeps a name. Returns its id.
    fn name(&mut self, name: String) -> u32 {
        /// A tile keeps no more names, which may be long.
        const MOST_NAMES: usize = 1 << 12;
        let id = matte_id(&name);
        if let Some(names) = self.names.as_mut().filter(|names| names.len() < MOST_NAMES) {
            let known = names.entry(id).or_insert_with(|| name.clone());
            if name < *known {
                *known = name;
            }
        }
        id
    }
}
