//! Rays through the graph of groups.

use superegg_geom::glam::DVec3;
use superegg_geom::{Ray, RayReciprocal, RayStart, scale_to_unit};

use crate::compiled::{CompiledScene, Target};
use crate::path::InstancePath;

/// The closest crossing of a ray: cheap to make, and enough to ask for the rest ([`CompiledScene::interaction`]).
#[derive(Clone, Debug, PartialEq)]
pub struct Hit {
    /// The place on the ray, in lengths of its direction.
    pub t: f64,
    /// Whether the ray leaves the primitive here.
    pub leaving: bool,
    /// The primitive, by its number among the scene's primitives.
    pub primitive: u32,
    /// The point in the primitive's own space.
    pub local_point: DVec3,
    /// Which instance of the primitive.
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

impl CompiledScene {
    /// The first crossing of any surface with t >= 0. Of two at the same t the one with the smaller path counts.
    pub fn intersect(&self, ray: &Ray, departure: Option<&Departure>) -> Option<Hit> {
        self.closest_hit(ray, departure, false)
    }

    /// The same by the f32 lanes where shapes are convex ([`superegg_geom::lanes`]), for comparing the two.
    pub fn intersect_fast(&self, ray: &Ray) -> Option<Hit> {
        self.closest_hit(ray, None, true)
    }

    fn closest_hit(&self, ray: &Ray, departure: Option<&Departure>, by_lanes: bool) -> Option<Hit> {
        // A direction of any length is brought to one that no transform of the scene takes out of range.
        let (direction, scale) = scale_to_unit(ray.direction)?;
        let mut traversal = Traversal { by_lanes, ..Traversal::new(self, departure, f64::INFINITY, false) };
        traversal.visit_root(&Ray { direction, ..*ray });
        traversal.best.map(|hit| Hit { t: hit.t * scale, ..hit })
    }

    /// Whether any surface is crossed with 0 <= t < `t_max`.
    pub fn occluded(&self, ray: &Ray, departure: Option<&Departure>, t_max: f64) -> bool {
        let mut traversal = Traversal::new(self, departure, t_max, true);
        traversal.visit_root(ray);
        traversal.is_occluded
    }
}

struct Traversal<'a> {
    scene: &'a CompiledScene,
    departure: Option<&'a Departure>,
    /// No crossing beyond this counts.
    t_max: f64,
    any_hit: bool,
    /// Set when any hit is found.
    is_occluded: bool,
    /// Whether convex shapes are met by the f32 lanes.
    by_lanes: bool,
    path: InstancePath,
    best: Option<Hit>,
    /// Nodes to visit with the t at which the ray enters them, shared by the groups that are open.
    pending: Vec<(u32, f64)>,
}

impl<'a> Traversal<'a> {
    fn new(scene: &'a CompiledScene, departure: Option<&'a Departure>, t_max: f64, any_hit: bool) -> Self {
        Self {
            scene,
            departure,
            t_max,
            any_hit,
            is_occluded: false,
            by_lanes: false,
            path: InstancePath::default(),
            best: None,
            pending: Vec::new(),
        }
    }

    fn visit_root(&mut self, ray: &Ray) {
        if let Some(target) = self.scene.root {
            self.visit(target, ray);
        }
    }

    fn visit(&mut self, target: Target, ray: &Ray) {
        match target {
            Target::Primitive(primitive) => self.visit_primitive(primitive, ray),
            Target::Group(group) => self.visit_group(group, ray),
        }
    }

    fn visit_group(&mut self, group: u32, ray: &Ray) {
        let group = &self.scene.groups[group as usize];
        let nodes = &group.bvh.nodes;
        let reciprocal = RayReciprocal::from(ray);
        let base = self.pending.len();
        if let Some(near) = nodes[0].bounds.clip(&reciprocal, self.t_max) {
            self.pending.push((0, near));
        }
        while self.pending.len() > base && !self.is_occluded {
            let Some((index, near)) = self.pending.pop() else { break };
            if near > self.t_max {
                continue;
            }
            let node = &nodes[index as usize];
            if node.count == 0 {
                let entry = |child: u32| {
                    nodes[child as usize].bounds.clip(&reciprocal, self.t_max).map(|near| (child, near))
                };
                match (entry(node.first), entry(node.first + 1)) {
                    (Some(a), Some(b)) if a.1 <= b.1 => self.pending.extend([b, a]),
                    (a, b) => self.pending.extend([a, b].into_iter().flatten()),
                }
                continue;
            }
            let items = &group.bvh.items[node.first as usize..(node.first + node.count) as usize];
            for &item in items {
                let instance = &group.instances[item as usize];
                if instance.bounds.clip(&reciprocal, self.t_max).is_some() {
                    self.path.push(item);
                    self.visit(instance.target, &ray.to_local(&instance.parent_from_child));
                    self.path.pop();
                }
            }
        }
        self.pending.truncate(base);
    }

    fn visit_primitive(&mut self, primitive: u32, ray: &Ray) {
        let start = match self.departure {
            Some(departure) if departure.path == self.path => match departure.side {
                Side::Outward => RayStart::SurfaceOutward,
                Side::Inward => RayStart::SurfaceInward,
            },
            _ => RayStart::Free,
        };
        let shape = &self.scene.primitives[primitive as usize].shape;
        if self.any_hit {
            self.is_occluded |= shape.occluded(ray, start, self.t_max);
            return;
        }
        let found =
            if self.by_lanes { shape.intersect_fast(ray, start) } else { shape.intersect(ray, start) };
        let Some(hit) = found else { return };
        let is_closer = hit.t < self.t_max
            || self.best.as_ref().is_some_and(|best| hit.t == best.t && self.path < best.path);
        if is_closer {
            self.t_max = hit.t;
            self.best = Some(Hit {
                t: hit.t,
                leaving: hit.leaving,
                primitive,
                local_point: hit.point,
                path: self.path.clone(),
            });
        }
    }
}
