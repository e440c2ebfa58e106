//! Expansion of the graph of objects into instances, as far as they are visible and within the
//! budget.

use std::cmp::Ordering;
use std::collections::{BinaryHeap, HashMap};

use superegg_geom::glam::{DAffine3, DMat3, DVec3};
use superegg_geom::{Aabb, Exponents, Transform};
use superegg_scene::{Camera, Material, Patches, Pattern};

use super::data::{Preview, PreviewBudget, PreviewInstance, PreviewShape};
use super::index::{IndexedEntity, SceneIndex};

impl SceneIndex {
    /// Expands an entity into instances, the largest on the screen first, until everything larger
    /// than a pixel is expanded or the budget is spent. A proxy stands for each branch smaller than
    /// a pixel. An unknown name gives an empty preview.
    pub fn open(&self, root: Option<&str>, camera: &Camera, budget: &PreviewBudget) -> Preview {
        let mut expansion = Expansion::new(self, camera, budget);
        if let Some(&root) = root.and_then(|name| self.numbers.get(name)) {
            expansion.run(root);
        }
        expansion.preview
    }
}

/// A node of the graph of objects that is to be expanded, with its map to the world.
struct Branch {
    /// Radius on the screen, in pixels.
    size_px: f64,
    entity: u32,
    /// Remaining recursion depth.
    remaining: u32,
    world_from_entity: DAffine3,
    /// Index of the root's child that it is or belongs to; `None` for the root.
    child: Option<u32>,
}

impl PartialEq for Branch {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Branch {}

impl PartialOrd for Branch {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Branch {
    fn cmp(&self, other: &Self) -> Ordering {
        self.size_px.total_cmp(&other.size_px)
    }
}

/// An object with at least this many children is expanded in part if it exceeds the budget; one
/// proxy would show too little of it.
const WIDE: usize = 1000;

/// The state of one expansion.
struct Expansion<'a> {
    index: &'a SceneIndex,
    budget: &'a PreviewBudget,
    eye: DVec3,
    /// Size in pixels of a unit length at unit distance, or for parallel rays at any.
    pixels: f64,
    is_parallel: bool,
    /// Bounding boxes by entity and remaining depth.
    bounds: HashMap<(u32, u32), Aabb>,
    /// Shape of the first primitive by entity and remaining depth.
    firsts: HashMap<(u32, u32), Option<u32>>,
    /// The proxy ellipsoid with the material of a shape.
    proxies: HashMap<u32, u32>,
    preview: Preview,
}

impl<'a> Expansion<'a> {
    fn new(index: &'a SceneIndex, camera: &Camera, budget: &'a PreviewBudget) -> Self {
        let half_height = match camera.ortho_height {
            Some(height) => 0.5 * height,
            None => (0.5 * camera.fov_deg.to_radians()).tan(),
        };
        Self {
            index,
            budget,
            eye: camera.position,
            pixels: 0.5 * f64::from(budget.height_px.max(1)) / half_height,
            is_parallel: camera.ortho_height.is_some(),
            bounds: HashMap::new(),
            firsts: HashMap::new(),
            proxies: HashMap::new(),
            preview: Preview { shapes: index.shapes.clone(), ..Preview::default() },
        }
    }

    fn run(&mut self, root: u32) {
        let depth = self.index.depth;
        let bounds = self.bounds_of(root, depth);
        self.preview.bounds = Some(bounds).filter(|bounds| !bounds.is_empty());
        if bounds.is_empty() {
            return;
        }
        let mut pending = BinaryHeap::new();
        pending.push(Branch {
            size_px: f64::INFINITY,
            entity: root,
            remaining: depth,
            world_from_entity: DAffine3::IDENTITY,
            child: None,
        });
        while let Some(branch) = pending.pop() {
            let children = match &self.index.entities[branch.entity as usize] {
                IndexedEntity::Primitive(shape, radii) => {
                    let world_from_unit = branch.world_from_entity * DAffine3::from_scale(*radii);
                    self.push_instance(*shape, world_from_unit, branch.child);
                    continue;
                }
                IndexedEntity::Object(children) => children,
            };
            if branch.remaining == 0 {
                continue;
            }
            let used = self.preview.instances.len() + pending.len();
            let room = self.budget.instances.max(1).saturating_sub(used);
            if children.len() > room {
                self.preview.unpaid_branches += 1;
                if children.len() < WIDE {
                    self.push_proxy(&branch);
                    continue;
                }
            }
            for (i, (map, target)) in children.iter().take(room).enumerate() {
                let child = branch.child.unwrap_or(i as u32);
                self.push_branch(&mut pending, &branch, map, *target, child);
            }
        }
    }

    fn push_branch(
        &mut self,
        pending: &mut BinaryHeap<Branch>,
        parent: &Branch,
        map: &Transform,
        target: u32,
        child: u32,
    ) {
        let world_from_entity = parent.world_from_entity * *map.forward();
        if !world_from_entity.is_finite() {
            return;
        }
        let remaining = (parent.remaining - 1).min(self.index.heights[target as usize]);
        let local = self.bounds_of(target, remaining);
        if local.is_empty() {
            return;
        }
        let (center, radius) = bounding_sphere(&world_from_entity, &local);
        let distance =
            if self.is_parallel { 1.0 } else { ((center - self.eye).length() - radius).max(1e-3 * radius) };
        let size_px = self.pixels * radius / distance;
        let branch = Branch { size_px, entity: target, remaining, world_from_entity, child: Some(child) };
        if size_px < 0.5 && matches!(self.index.entities[target as usize], IndexedEntity::Object(_)) {
            self.preview.small_branches += 1;
            self.push_proxy(&branch);
        } else {
            pending.push(branch);
        }
    }

    fn push_instance(&mut self, shape: u32, world_from_unit: DAffine3, child: Option<u32>) {
        let half = half_extent(&world_from_unit.matrix3, DVec3::ONE);
        if world_from_unit.is_finite() && half.is_finite() {
            let (child, radius) = (child.unwrap_or(0), half.length());
            self.preview.instances.push(PreviewInstance { shape, world_from_unit, child, radius });
        }
    }

    /// Adds an ellipsoid of the size of the branch's box with the material of its first primitive.
    fn push_proxy(&mut self, branch: &Branch) {
        let Some(first) = self.first_shape(branch.entity, branch.remaining) else { return };
        let local = self.bounds_of(branch.entity, branch.remaining);
        let local_from_unit = DAffine3::from_translation(local.center())
            * DAffine3::from_scale(local.half_extent().max(DVec3::splat(1e-300)));
        let shapes = &mut self.preview.shapes;
        let shape = *self.proxies.entry(first).or_insert_with(|| {
            let PreviewShape { material, .. } = shapes[first as usize];
            let material = Material { pattern: Pattern::None, ..material };
            shapes.push(PreviewShape {
                exponents: Exponents::ROUND,
                radii: DVec3::ONE,
                patches: Patches { u: 8, v: 4 },
                material,
            });
            shapes.len() as u32 - 1
        });
        self.push_instance(shape, branch.world_from_entity * local_from_unit, branch.child);
    }

    fn first_shape(&mut self, entity: u32, remaining: u32) -> Option<u32> {
        let index = self.index;
        let remaining = remaining.min(index.heights[entity as usize]);
        let children = match &index.entities[entity as usize] {
            IndexedEntity::Primitive(shape, _) => return Some(*shape),
            IndexedEntity::Object(_) if remaining == 0 => return None,
            IndexedEntity::Object(children) => children,
        };
        if let Some(first) = self.firsts.get(&(entity, remaining)) {
            return *first;
        }
        let first = children.iter().find_map(|(_, child)| self.first_shape(*child, remaining - 1));
        self.firsts.insert((entity, remaining), first);
        first
    }

    /// The bounding box of an entity at a remaining depth, in its own space.
    fn bounds_of(&mut self, entity: u32, remaining: u32) -> Aabb {
        let remaining = remaining.min(self.index.heights[entity as usize]);
        let index = self.index;
        let children = match &index.entities[entity as usize] {
            IndexedEntity::Primitive(_, radii) => return Aabb::around(DVec3::ZERO, *radii),
            IndexedEntity::Object(_) if remaining == 0 => return Aabb::EMPTY,
            IndexedEntity::Object(children) => children,
        };
        if let Some(bounds) = self.bounds.get(&(entity, remaining)) {
            return *bounds;
        }
        let bounds = children.iter().fold(Aabb::EMPTY, |all, (map, child)| {
            all.union(&self.bounds_of(*child, remaining - 1).transformed(map))
        });
        self.bounds.insert((entity, remaining), bounds);
        bounds
    }
}

/// Centre and radius of a bounding sphere of the image of a box.
fn bounding_sphere(world: &DAffine3, local: &Aabb) -> (DVec3, f64) {
    (world.transform_point3(local.center()), half_extent(&world.matrix3, local.half_extent()).length())
}

/// Half extent of the bounding box of the image of a box.
fn half_extent(linear: &DMat3, half: DVec3) -> DVec3 {
    linear.x_axis.abs() * half.x + linear.y_axis.abs() * half.y + linear.z_axis.abs() * half.z
}

#[cfg(test)]
mod tests {
    use superegg_lang::Session;

    use super::*;

    const BUDGET: PreviewBudget = PreviewBudget { instances: 10_000, height_px: 1000 };

    fn open(lines: &str, budget: PreviewBudget) -> Preview {
        let mut session = Session::default();
        for line in lines.split(';') {
            session.run_line(line.trim()).unwrap_or_else(|fault| panic!("{line}: {fault:?}"));
        }
        let scene = session.scene();
        SceneIndex::new(scene).open(session.selected(), &scene.camera, &budget)
    }

    #[test]
    fn instances_follow_the_transforms() {
        let preview = open(
            "prm a; coeff 1 2 3; obj o; ap a; xs 1 0 0; obj p; ao o; rs 0 0 1 90; ao o two; xs 0 0 5",
            BUDGET,
        );
        let mut centers: Vec<[i64; 3]> = preview
            .instances
            .iter()
            .map(|i| i.world_from_unit.translation.to_array().map(|x| x.round() as i64))
            .collect();
        centers.sort_unstable();
        assert_eq!(centers, [[0, 1, 0], [1, 0, 5]]);
        let bounds = preview.bounds.unwrap();
        assert!((bounds.min - DVec3::new(-2.0, -2.0, -3.0)).length() < 1e-9, "{bounds:?}");
        assert!((bounds.max - DVec3::new(2.0, 2.0, 8.0)).length() < 1e-9, "{bounds:?}");
    }

    #[test]
    fn instances_know_the_child_of_the_root_that_they_belong_to() {
        let preview = open(
            "prm a; obj o; ap a; ap a b; xs 9 0 0; obj p; ap a; xs 0 5 0; ao o; ao o two; xs 0 0 5",
            BUDGET,
        );
        let mut children: Vec<(u32, [i64; 3])> = preview
            .instances
            .iter()
            .map(|i| (i.child, i.world_from_unit.translation.to_array().map(|x| x.round() as i64)))
            .collect();
        children.sort_unstable();
        assert_eq!(
            children,
            [(0, [0, 5, 0]), (1, [0, 0, 0]), (1, [9, 0, 0]), (2, [0, 0, 5]), (2, [9, 0, 5])]
        );
    }

    #[test]
    fn a_fractal_is_expanded_to_the_recursion_depth() {
        for depth in 0..6 {
            let lines = format!("depth {depth}; prm a; obj o; ap a; ao o; ss .9 .9 .9; xs 0 1 0");
            let preview = open(&lines, BUDGET);
            assert_eq!(preview.instances.len(), depth as usize);
            assert_eq!((preview.small_branches, preview.unpaid_branches), (0, 0));
        }
    }

    #[test]
    fn a_branch_smaller_than_a_pixel_is_a_proxy() {
        let lines =
            "depth 64; prm a; obj o; ap a; ao o; ss .5 .5 .5; xs 1 0 0; ao o two; ss .5 .5 .5; xs -1 0 0";
        let preview = open(lines, PreviewBudget { instances: 1_000_000, height_px: 100 });
        assert!(preview.small_branches > 10 && preview.unpaid_branches == 0);
        assert!(preview.instances.len() < 2000, "{}", preview.instances.len());
    }

    #[test]
    fn the_budget_is_kept() {
        let lines = "depth 64; prm a; obj o; ap a; ao o; xs 1 0 0; ao o two; xs -1 0 0; ao o three; xs 0 1 0";
        for instances in [0, 1, 10, 1000] {
            let preview = open(lines, PreviewBudget { instances, ..BUDGET });
            assert!(
                preview.instances.len() <= instances.max(1) + 3,
                "{instances}: {}",
                preview.instances.len()
            );
            assert!(preview.unpaid_branches > 0);
        }
    }

    #[test]
    fn an_empty_scene_has_no_instances_and_no_bounds() {
        for lines in ["deselect", "obj o", "obj o; ao o; ao o two", "depth 0; prm a; obj o; ap a"] {
            let preview = open(lines, BUDGET);
            assert!(preview.instances.is_empty() && preview.bounds.is_none(), "{lines}");
        }
    }

    #[test]
    fn extreme_transforms_do_no_harm() {
        let preview = open("prm a; obj o; ap a; ss 1e-300 1 1e300; obj p; ao o; ss 1e20 1 1e300", BUDGET);
        assert!(preview.instances.iter().all(|instance| instance.world_from_unit.is_finite()));
    }
}
