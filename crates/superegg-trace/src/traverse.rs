//! One ray through the graph of groups, in f64.
//!
//! This is the exact way. Beams ([`crate::beam`]) and flights of rays ([`crate::flight`]) find candidates faster and are held against it.

use superegg_geom::glam::DVec3;
use superegg_geom::{Aabb, Ray, RayReciprocal, RayStart, ShapeHit, Transform, scale_to_unit};

use crate::bvh::Slot;
use crate::compiled::{CompiledScene, Group, Instance};
use crate::footprint::{Footprint, chance};
use crate::path::InstancePath;
use crate::stand_in::StandIn;

/// The closest crossing of a ray: cheap to make, and enough to ask for the rest ([`CompiledScene::interaction`]).
#[derive(Clone, Debug, PartialEq)]
pub struct Hit {
    /// The place on the ray, in lengths of its direction.
    pub t: f64,
    /// Whether the ray leaves the primitive here.
    pub leaving: bool,
    /// The primitive, by its number among the scene's primitives.
    pub primitive: u32,
    /// The point in the space of the primitive's unit shape: the primitive's own, in which coordinates are divided by the radii.
    pub unit_point: DVec3,
    /// The gradient of N there, of any length, where it came with the crossing; else zero.
    pub(crate) unit_gradient: DVec3,
    /// Which instance of a primitive; for a ray with a footprint perhaps a group that stands in as a whole.
    pub path: InstancePath,
}

/// The side to which a ray goes from a surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// Away from the inside.
    Outward,
    /// Into the shape.
    Inward,
}

/// A ray's start on the surface of an instance. It settles by mathematics what an epsilon would guess: a ray that leaves a convex
/// shape outwards does not meet it again, one that goes in has one exit.
#[derive(Clone, Debug, PartialEq)]
pub struct Departure {
    /// The instance whose surface the ray starts on.
    pub path: InstancePath,
    /// Where it goes from there.
    pub side: Side,
}

impl Departure {
    /// What a start says of the shape at a path; nothing where it is free.
    pub fn of(path: InstancePath, start: RayStart) -> Option<Self> {
        match start {
            RayStart::Free => None,
            RayStart::SurfaceOutward => Some(Self { path, side: Side::Outward }),
            RayStart::SurfaceInward => Some(Self { path, side: Side::Inward }),
        }
    }

    /// What is known of the start for the shape that the ray starts on.
    pub(crate) fn start(&self) -> RayStart {
        match self.side {
            Side::Outward => RayStart::SurfaceOutward,
            Side::Inward => RayStart::SurfaceInward,
        }
    }

    /// What is known of the start for the shape at a path.
    pub(crate) fn start_at(departure: Option<&Self>, path: &InstancePath) -> RayStart {
        match departure {
            Some(departure) if departure.path == *path => departure.start(),
            _ => RayStart::Free,
        }
    }
}

impl CompiledScene {
    /// The first crossing of any surface with t >= 0. Of two at the same t the one with the smaller path counts, by the order of children.
    pub fn intersect(&self, ray: &Ray, departure: Option<&Departure>) -> Option<Hit> {
        self.closest_hit(ray, departure, Footprint::NONE, false)
    }

    /// The same by the f32 lanes where shapes are convex ([`superegg_geom::kernels`]), for comparing the two.
    pub fn intersect_fast(&self, ray: &Ray) -> Option<Hit> {
        self.closest_hit(ray, None, Footprint::NONE, true)
    }

    /// The first crossing for a ray of some width: groups that are much smaller are not opened.
    pub fn intersect_footprint(
        &self,
        ray: &Ray,
        departure: Option<&Departure>,
        footprint: Footprint,
    ) -> Option<Hit> {
        self.closest_hit(ray, departure, footprint, false)
    }

    fn closest_hit(
        &self,
        ray: &Ray,
        departure: Option<&Departure>,
        footprint: Footprint,
        by_lanes: bool,
    ) -> Option<Hit> {
        // A direction of any length is brought to one that no transform of the scene takes out of range.
        let (direction, scale) = scale_to_unit(ray.direction)?;
        let footprint = Footprint { spread: footprint.spread * scale, ..footprint };
        let ray = Ray { direction, ..*ray };
        let mut traversal =
            Traversal { by_lanes, ..Traversal::new(self, &ray, departure, f64::INFINITY, footprint, false) };
        traversal.visit_root(&ray);
        traversal.best.map(|hit| Hit { t: hit.t * scale, ..hit })
    }

    /// Whether any surface is crossed with 0 <= t < `t_max`.
    pub fn occluded(&self, ray: &Ray, departure: Option<&Departure>, t_max: f64) -> bool {
        self.occluded_footprint(ray, departure, t_max, Footprint::NONE)
    }

    /// The same for a ray of some width.
    pub fn occluded_footprint(
        &self,
        ray: &Ray,
        departure: Option<&Departure>,
        t_max: f64,
        footprint: Footprint,
    ) -> bool {
        let mut traversal = Traversal::new(self, ray, departure, t_max, footprint, true);
        traversal.visit_root(ray);
        traversal.is_occluded
    }

    /// How many boxes and shapes are asked for the first crossing of a ray of some width.
    pub fn steps(&self, ray: &Ray, footprint: Footprint) -> u64 {
        let Some((direction, scale)) = scale_to_unit(ray.direction) else { return 0 };
        let footprint = Footprint { spread: footprint.spread * scale, ..footprint };
        let ray = Ray { direction, ..*ray };
        let mut traversal = Traversal::new(self, &ray, None, f64::INFINITY, footprint, false);
        traversal.visit_root(&ray);
        traversal.steps
    }
}

struct Traversal<'a> {
    scene: &'a CompiledScene,
    departure: Option<&'a Departure>,
    /// No crossing beyond this counts.
    t_max: f64,
    footprint: Footprint,
    /// The bits of the ray, by which stand-ins draw lots.
    ray_bits: [u64; 3],
    any_hit: bool,
    /// Set when any hit is found.
    is_occluded: bool,
    /// Whether convex shapes are met by the f32 lanes.
    by_lanes: bool,
    path: InstancePath,
    best: Option<Hit>,
    /// Slots to visit with the t at which the ray enters their boxes, shared by the groups that are open.
    pending: Vec<(Slot, f64)>,
    /// Boxes and shapes asked so far.
    steps: u64,
}

impl<'a> Traversal<'a> {
    fn new(
        scene: &'a CompiledScene,
        ray: &Ray,
        departure: Option<&'a Departure>,
        t_max: f64,
        footprint: Footprint,
        any_hit: bool,
    ) -> Self {
        Self {
            scene,
            departure,
            t_max,
            footprint,
            ray_bits: ray.direction.to_array().map(f64::to_bits),
            any_hit,
            is_occluded: false,
            by_lanes: false,
            path: InstancePath::default(),
            best: None,
            pending: Vec::new(),
            steps: 0,
        }
    }

    fn visit_root(&mut self, ray: &Ray) {
        if let Some(root) = self.scene.root.as_deref() {
            self.visit_group(root, ray, 1.0);
        }
    }

    /// Everything in a group, by the ray in its space, in which lengths are at least a `stretch`-th of the world's.
    fn visit_group(&mut self, group: &Group, ray: &Ray, stretch: f64) {
        let tree_ray = ray.through(&group.space.tree_from_group());
        let reciprocal = RayReciprocal::from(&tree_ray);
        // The rounding of the ray's way into the tree's space.
        let slack = DVec3::splat(8.0 * f64::EPSILON * (1.0 + tree_ray.origin.abs().max_element()));
        let base = self.pending.len();
        self.pending.push((Slot::Node(0), 0.0));
        while self.pending.len() > base && !self.is_occluded {
            let Some((slot, near)) = self.pending.pop() else { break };
            if near > self.t_max {
                continue;
            }
            match slot {
                Slot::Node(node) => {
                    let node = &group.nodes[node as usize];
                    let first = self.pending.len();
                    for (place, slot) in node.slots().enumerate() {
                        self.steps += 1;
                        let bounds = node.child_box(place);
                        let bounds = Aabb { min: bounds.min - slack, max: bounds.max + slack };
                        if let Some(near) = bounds.clip(&reciprocal, self.t_max) {
                            self.pending.push((slot, near));
                        }
                    }
                    // The nearest on top.
                    self.pending[first..].sort_by(|a, b| b.1.total_cmp(&a.1));
                }
                Slot::Leaf(leaf) => {
                    self.steps += 1;
                    self.path.push(leaf);
                    self.visit_leaf(group, leaf, ray);
                    self.path.pop();
                }
                Slot::Instance(place) => {
                    let instance = &group.instances[place as usize];
                    let stretch = stretch * instance.stretch;
                    if self.footprint.hides(instance.size() * stretch, near) {
                        self.visit_stand_in(instance, place, ray);
                        continue;
                    }
                    self.path.push(place);
                    self.visit_group(&instance.group, &ray.to_local(&instance.parent_from_child), stretch);
                    self.path.pop();
                }
            }
        }
        self.pending.truncate(base);
    }

    fn visit_leaf(&mut self, group: &Group, leaf: u32, ray: &Ray) {
        let leaf = &group.leaves[leaf as usize];
        let start = Departure::start_at(self.departure, &self.path);
        let ray = ray.through(&leaf.unit_from_group);
        let shape = self.scene.primitives[leaf.primitive as usize].unit_shape();
        if self.any_hit {
            self.is_occluded |= shape.occluded(&ray, start, self.t_max);
            return;
        }
        let found =
            if self.by_lanes { shape.intersect_fast(&ray, start) } else { shape.intersect(&ray, start) };
        if let Some(hit) = found {
            self.take(&hit, leaf.primitive);
        }
    }

    /// A group too small to be opened, as an ellipsoid that stops its part of the light.
    fn visit_stand_in(&mut self, instance: &Instance, place: u32, ray: &Ray) {
        self.steps += 1;
        let stand_in = instance.group.stand_in(&self.scene.primitives);
        self.path.push(place | InstancePath::INSTANCE);
        // A ray that starts on a stand-in does not meet it again.
        let is_own = Departure::start_at(self.departure, &self.path) != RayStart::Free;
        if !is_own && chance(self.ray_bits, self.path.places()) < stand_in.opacity {
            let ray = ray.to_local(&instance.parent_from_child).through(&stand_in.unit_from_group);
            let hit = StandIn::unit_shape().intersect(&ray, RayStart::Free);
            if let Some(hit) = hit.filter(|hit| !hit.leaving && hit.t < self.t_max) {
                if self.any_hit {
                    self.is_occluded = true;
                } else {
                    self.take(&hit, stand_in.main_primitive());
                }
            }
        }
        self.path.pop();
    }

    /// Takes a crossing at the present path, if it is closer than the best.
    fn take(&mut self, hit: &ShapeHit, primitive: u32) {
        let ShapeHit { t, leaving, point: unit_point } = *hit;
        let is_closer = t < self.t_max
            || self
                .best
                .as_ref()
                .is_some_and(|best| t == best.t && self.scene.rank(&self.path) < self.scene.rank(&best.path));
        if is_closer {
            self.t_max = t;
            let unit_gradient = DVec3::ZERO;
            self.best =
                Some(Hit { t, leaving, primitive, unit_point, unit_gradient, path: self.path.clone() });
        }
    }
}

impl Instance {
    /// The diameter of the child's box, in the child's space.
    pub(crate) fn size(&self) -> f64 {
        2.0 * self.group.bounds.half_extent().length()
    }

    /// Parent from child.
    pub(crate) fn map(&self) -> &Transform {
        &self.parent_from_child
    }
}
