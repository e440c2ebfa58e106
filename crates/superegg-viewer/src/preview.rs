//! What the preview draws of a scene: instances of primitives, opened from the graph of objects as far as it can be seen and paid for.

use std::collections::{BinaryHeap, HashMap};

use superegg_geom::glam::{DAffine3, DMat3, DVec3};
use superegg_geom::{Aabb, Exponents, Transform};
use superegg_scene::{Camera, Entity, MAX_DEPTH, Material, Patches, Scene};

/// A primitive as the preview takes it: the shape is the unit one, its radii are part of each instance's map.
#[derive(Clone, Debug, PartialEq)]
pub struct PreviewShape {
    /// Its exponents.
    pub exponents: Exponents,
    /// How it is cut.
    pub patches: Patches,
    /// Its surface.
    pub material: Material,
}

/// One instance of a primitive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PreviewInstance {
    /// The place of its shape among [`Preview::shapes`].
    pub shape: u32,
    /// World from the unit shape's space.
    pub world_from_unit: DAffine3,
    /// A ball around it has this radius.
    pub radius: f64,
}

/// What is to be drawn.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Preview {
    /// The primitives of the scene in its order, then stand-ins.
    pub shapes: Vec<PreviewShape>,
    /// Their instances.
    pub instances: Vec<PreviewInstance>,
    /// Around all of the scene, what is not opened too. Empty for nothing.
    pub bounds: Option<Aabb>,
    /// Branches that were not opened because they are smaller than a pixel; a dot stands for each.
    pub small_branches: usize,
    /// Branches that were not opened because the budget was spent.
    pub unpaid_branches: usize,
}

/// How far objects are opened.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PreviewBudget {
    /// Instances, at most about this many.
    pub instances: usize,
    /// The height of the picture, for what a pixel is.
    pub height_px: u32,
}

/// A scene in an order that is quick to open: names as numbers, maps composed. It does not depend on the view.
#[derive(Debug, Default)]
pub struct SceneIndex {
    entities: Vec<Indexed>,
    numbers: HashMap<String, u32>,
    shapes: Vec<PreviewShape>,
    depth: u32,
    heights: Vec<u32>,
}

#[derive(Debug)]
enum Indexed {
    /// The place of the shape, and the radii.
    Primitive(u32, DVec3),
    /// Children: maps and targets.
    Object(Vec<(Transform, u32)>),
}

impl SceneIndex {
    /// Indexes a scene.
    pub fn new(scene: &Scene) -> Self {
        let numbers: HashMap<String, u32> =
            scene.entities().enumerate().map(|(i, (name, _))| (name.to_owned(), i as u32)).collect();
        let mut shapes = Vec::new();
        let mut entities = Vec::with_capacity(numbers.len());
        for (_, entity) in scene.entities() {
            entities.push(match entity {
                Entity::Primitive(primitive) => {
                    shapes.push(PreviewShape {
                        exponents: primitive.shape.exponents(),
                        patches: primitive.patches,
                        material: primitive.material,
                    });
                    Indexed::Primitive(shapes.len() as u32 - 1, primitive.shape.radii())
                }
                Entity::Object(object) => {
                    let child = |(_, child): (&str, &superegg_scene::Child)| {
                        let map = object.parent_from_child(child).ok()?;
                        Some((map, *numbers.get(child.target())?))
                    };
                    Indexed::Object(object.children().filter_map(child).collect())
                }
            });
        }
        let heights = heights(&entities);
        Self { entities, numbers, shapes, depth: scene.depth.min(MAX_DEPTH), heights }
    }

    /// Opens what a name stands for, the largest on the screen first, until all is open that is larger than a pixel or the budget is spent. For
    /// each branch smaller than a pixel a dot of its size stands in.
    pub fn open(&self, root: Option<&str>, camera: &Camera, budget: &PreviewBudget) -> Preview {
        let mut opening = Opening::new(self, camera, budget);
        if let Some(&root) = root.and_then(|name| self.numbers.get(name)) {
            opening.run(root);
        }
        opening.preview
    }

    /// The place among [`Preview::shapes`] of a primitive.
    pub fn shape_of(&self, name: &str) -> Option<u32> {
        match self.entities.get(*self.numbers.get(name)? as usize)? {
            Indexed::Primitive(shape, _) => Some(*shape),
            Indexed::Object(_) => None,
        }
    }
}

/// Levels of each entity, 0 for a primitive, [`MAX_DEPTH`] on or above a circle: from there on more depth changes nothing.
fn heights(entities: &[Indexed]) -> Vec<u32> {
    let mut heights: Vec<u32> =
        entities.iter().map(|entity| u32::from(matches!(entity, Indexed::Object(_)))).collect();
    for _ in 1..MAX_DEPTH {
        let mut has_changed = false;
        for (i, entity) in entities.iter().enumerate() {
            let Indexed::Object(children) = entity else { continue };
            let below = children.iter().map(|(_, child)| heights[*child as usize]).max().unwrap_or(0);
            let height = (below + 1).min(MAX_DEPTH);
            has_changed |= height != heights[i];
            heights[i] = height;
        }
        if !has_changed {
            break;
        }
    }
    heights
}

/// A branch to be opened.
struct Branch {
    /// Its radius on the screen, in pixels.
    size_px: f64,
    entity: u32,
    remaining: u32,
    world: DAffine3,
}

impl PartialEq for Branch {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Branch {}

impl PartialOrd for Branch {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Branch {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.size_px.total_cmp(&other.size_px)
    }
}

/// An object of so many children is opened in part where it cannot be paid for as a whole; one ellipsoid would say too little of it.
const WIDE: usize = 1000;

struct Opening<'a> {
    index: &'a SceneIndex,
    budget: &'a PreviewBudget,
    eye: DVec3,
    /// Pixels that a length of 1 covers at a distance of 1.
    pixels: f64,
    bounds: HashMap<(u32, u32), Aabb>,
    /// The first primitive of an entity opened so deep.
    firsts: HashMap<(u32, u32), Option<u32>>,
    /// The ellipsoid with the surface of a shape.
    stand_ins: HashMap<u32, u32>,
    preview: Preview,
}

impl<'a> Opening<'a> {
    fn new(index: &'a SceneIndex, camera: &Camera, budget: &'a PreviewBudget) -> Self {
        let half_height = (0.5 * camera.fov_deg.to_radians()).tan();
        Self {
            index,
            budget,
            eye: camera.position,
            pixels: 0.5 * f64::from(budget.height_px.max(1)) / half_height,
            bounds: HashMap::new(),
            firsts: HashMap::new(),
            stand_ins: HashMap::new(),
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
            world: DAffine3::IDENTITY,
        });
        while let Some(branch) = pending.pop() {
            let children = match &self.index.entities[branch.entity as usize] {
                Indexed::Primitive(shape, radii) => {
                    self.push_instance(*shape, branch.world * DAffine3::from_scale(*radii));
                    continue;
                }
                Indexed::Object(children) => children,
            };
            if branch.remaining == 0 {
                continue;
            }
            let paid = self.preview.instances.len() + pending.len();
            let room = self.budget.instances.max(1).saturating_sub(paid);
            if children.len() > room {
                self.preview.unpaid_branches += 1;
                if children.len() < WIDE {
                    self.push_stand_in(&branch);
                    continue;
                }
            }
            for (map, target) in children.iter().take(room) {
                self.push_branch(&mut pending, &branch, map, *target);
            }
        }
    }

    fn push_branch(
        &mut self,
        pending: &mut BinaryHeap<Branch>,
        parent: &Branch,
        map: &Transform,
        target: u32,
    ) {
        let world = parent.world * *map.forward();
        if !world.is_finite() {
            return;
        }
        let remaining = (parent.remaining - 1).min(self.index.heights[target as usize]);
        let local = self.bounds_of(target, remaining);
        if local.is_empty() {
            return;
        }
        let (center, radius) = ball(&world, &local);
        let distance = ((center - self.eye).length() - radius).max(1e-3 * radius);
        let size_px = self.pixels * radius / distance;
        let branch = Branch { size_px, entity: target, remaining, world };
        if size_px < 0.5 && matches!(self.index.entities[target as usize], Indexed::Object(_)) {
            self.preview.small_branches += 1;
            self.push_stand_in(&branch);
        } else {
            pending.push(branch);
        }
    }

    fn push_instance(&mut self, shape: u32, world_from_unit: DAffine3) {
        let half = half_extent(&world_from_unit.matrix3, DVec3::ONE);
        if world_from_unit.is_finite() && half.is_finite() {
            self.preview.instances.push(PreviewInstance { shape, world_from_unit, radius: half.length() });
        }
    }

    /// An ellipsoid as large as the branch's box, with the surface of its first primitive.
    fn push_stand_in(&mut self, branch: &Branch) {
        let Some(first) = self.first_shape(branch.entity, branch.remaining) else { return };
        let local = self.bounds_of(branch.entity, branch.remaining);
        let place = DAffine3::from_translation(local.center())
            * DAffine3::from_scale(local.half_extent().max(DVec3::splat(1e-300)));
        let shapes = &mut self.preview.shapes;
        let shape = *self.stand_ins.entry(first).or_insert_with(|| {
            let PreviewShape { material, .. } = shapes[first as usize];
            shapes.push(PreviewShape {
                exponents: Exponents::ROUND,
                patches: Patches { u: 8, v: 4 },
                material,
            });
            shapes.len() as u32 - 1
        });
        self.push_instance(shape, branch.world * place);
    }

    fn first_shape(&mut self, entity: u32, remaining: u32) -> Option<u32> {
        let index = self.index;
        let remaining = remaining.min(index.heights[entity as usize]);
        let children = match &index.entities[entity as usize] {
            Indexed::Primitive(shape, _) => return Some(*shape),
            Indexed::Object(_) if remaining == 0 => return None,
            Indexed::Object(children) => children,
        };
        if let Some(first) = self.firsts.get(&(entity, remaining)) {
            return *first;
        }
        let first = children.iter().find_map(|(_, child)| self.first_shape(*child, remaining - 1));
        self.firsts.insert((entity, remaining), first);
        first
    }

    /// The box of an entity opened so deep, in its own space.
    fn bounds_of(&mut self, entity: u32, remaining: u32) -> Aabb {
        let remaining = remaining.min(self.index.heights[entity as usize]);
        let index = self.index;
        let children = match &index.entities[entity as usize] {
            Indexed::Primitive(_, radii) => return Aabb::around(DVec3::ZERO, *radii),
            Indexed::Object(_) if remaining == 0 => return Aabb::EMPTY,
            Indexed::Object(children) => children,
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

/// The ball around the image of a box.
fn ball(world: &DAffine3, local: &Aabb) -> (DVec3, f64) {
    (world.transform_point3(local.center()), half_extent(&world.matrix3, local.half_extent()).length())
}

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
    fn instances_are_where_the_transforms_put_them() {
        let preview = open(
            "prm a; coeff 1 2 3; obj o; ap a; xs 1 0 0; obj p; ao o; rs 0 0 1 90; ao o two; xs 0 0 5",
            BUDGET,
        );
        let mut places: Vec<[i64; 3]> = preview
            .instances
            .iter()
            .map(|i| i.world_from_unit.translation.to_array().map(|x| x.round() as i64))
            .collect();
        places.sort_unstable();
        assert_eq!(places, [[0, 1, 0], [1, 0, 5]]);
        let bounds = preview.bounds.unwrap();
        assert!((bounds.min - DVec3::new(-2.0, -2.0, -3.0)).length() < 1e-9, "{bounds:?}");
        assert!((bounds.max - DVec3::new(2.0, 2.0, 8.0)).length() < 1e-9, "{bounds:?}");
    }

    #[test]
    fn a_fractal_is_opened_as_deep_as_depth_says() {
        for depth in 0..6 {
            let lines = format!("depth {depth}; prm a; obj o; ap a; ao o; ss .9 .9 .9; xs 0 1 0");
            let preview = open(&lines, BUDGET);
            assert_eq!(preview.instances.len(), depth as usize);
            assert_eq!((preview.small_branches, preview.unpaid_branches), (0, 0));
        }
    }

    #[test]
    fn what_is_smaller_than_a_pixel_is_a_dot() {
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
    fn nothing_is_nothing() {
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
