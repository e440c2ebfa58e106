//! Queries of one ray, in f64.
//!
//! This is the reference. Streams ([`crate::stream`]) and packets ([`crate::packet`]) are faster, give the same answers and
//! fall back to this path where f32 cannot decide.

use std::ops::ControlFlow;

use superegg_geom::glam::DVec3;
use superegg_geom::{Aabb, Ray, RayReciprocal, RayStart, ShapeHit, scale_to_unit};

use crate::ray::footprint::Footprint;
use crate::ray::lottery::Lottery;
use crate::ray::query::{Hit, SurfaceStart, TraceRay};
use crate::scene::compiled::CompiledScene;
use crate::scene::group::{Group, Instance};
use crate::scene::path::InstancePath;
use crate::scene::proxy::Proxy;
use crate::walk::Visitor;

impl CompiledScene {
    /// The closest hit of a ray with t >= 0.
    ///
    /// Of two hits at the same t the one that comes first in the order of children counts. A ray with a footprint hits
    /// groups much smaller than its width as a whole. `None` also for a direction that is zero or not finite.
    pub fn intersect(&self, ray: &TraceRay) -> Option<Hit> {
        let (mut traversal, ray, scale) = Traversal::closest(self, ray)?;
        traversal.visit_root(&ray);
        traversal.best.map(|hit| Hit { t: hit.t * scale, ..hit })
    }

    /// [`CompiledScene::intersect`] for a ray without width that starts on no surface.
    pub fn intersect_ray(&self, ray: &Ray) -> Option<Hit> {
        self.intersect(&TraceRay::new(*ray))
    }

    /// Whether a ray hits any surface with 0 <= t < `t_max`.
    pub fn occluded(&self, ray: &TraceRay, t_max: f64) -> bool {
        let mut traversal = Traversal { t_max, is_any_hit: true, ..Traversal::new(self, ray) };
        traversal.visit_root(&ray.ray);
        traversal.is_occluded
    }

    /// The number of boxes and shapes that [`CompiledScene::intersect`] tests.
    pub fn visited(&self, ray: &TraceRay) -> u64 {
        let Some((mut traversal, ray, _)) = Traversal::closest(self, ray) else { return 0 };
        traversal.visit_root(&ray);
        traversal.visited
    }
}

/// The state of one query.
struct Traversal<'a> {
    scene: &'a CompiledScene,
    start: Option<&'a SurfaceStart>,
    /// No hit beyond this counts.
    t_max: f64,
    footprint: Footprint,
    lottery: Lottery,
    /// Whether any hit ends the query.
    is_any_hit: bool,
    /// Whether a hit ended it.
    is_occluded: bool,
    path: InstancePath,
    best: Option<Hit>,
    /// The boxes and shapes tested so far.
    visited: u64,
}

impl<'a> Traversal<'a> {
    fn new(scene: &'a CompiledScene, ray: &'a TraceRay) -> Self {
        Self {
            scene,
            start: ray.start.as_ref(),
            t_max: f64::INFINITY,
            footprint: ray.footprint,
            lottery: Lottery::of(ray.ray.direction),
            is_any_hit: false,
            is_occluded: false,
            path: InstancePath::default(),
            best: None,
            visited: 0,
        }
    }

    /// A query for the closest hit, with the ray to trace and the factor that converts its t back. The direction is
    /// scaled by a power of two to the order of 1, so that no transform of the scene takes it out of the range of f64.
    fn closest(scene: &'a CompiledScene, ray: &'a TraceRay) -> Option<(Self, Ray, f64)> {
        let (direction, scale) = scale_to_unit(ray.ray.direction)?;
        let footprint = Footprint { spread: ray.footprint.spread * scale, ..ray.footprint };
        let traversal = Self { footprint, lottery: Lottery::of(direction), ..Self::new(scene, ray) };
        Some((traversal, Ray { direction, ..ray.ray }, scale))
    }

    fn visit_root(&mut self, ray: &Ray) {
        if let Some(root) = self.scene.root.as_deref() {
            // A break only ends the query early.
            let _ = self.visit_group(root, ray, 1.0);
        }
    }

    /// Visits a group with the ray in its space. `stretch` bounds the factor from lengths of the group to the world's.
    fn visit_group(&mut self, group: &Group, ray: &Ray, stretch: f64) -> ControlFlow<()> {
        let tree_ray = ray.through(&group.space.tree_from_group());
        // The rounding error of the map into the tree's space.
        let slack = DVec3::splat(8.0 * f64::EPSILON * (1.0 + tree_ray.origin.abs().max_element()));
        let reciprocal = RayReciprocal::from(&tree_ray);
        group.walk(&mut InGroup { traversal: self, group, ray, reciprocal, slack, stretch })
    }

    fn visit_proxy(&mut self, instance: &Instance, index: u32, ray: &Ray) {
        self.visited += 1;
        let proxy = instance.group.proxy(&self.scene.primitives);
        self.path.push(index | InstancePath::INSTANCE);
        // A ray that starts on a proxy does not hit it again.
        let is_own = SurfaceStart::at(self.start, &self.path) != RayStart::Free;
        if !is_own && self.lottery.hits(self.path.indices(), proxy.opacity) {
            let ray = ray.to_local(instance.map()).through(&proxy.unit_from_group);
            let hit = Proxy::unit_shape().intersect(&ray, RayStart::Free);
            if let Some(hit) = hit.filter(|hit| !hit.leaving && hit.t < self.t_max) {
                if self.is_any_hit {
                    self.is_occluded = true;
                } else {
                    self.take(&hit, proxy.main_primitive());
                }
            }
        }
        self.path.pop();
    }

    /// Takes a hit at the current path if it is closer than the best.
    fn take(&mut self, hit: &ShapeHit, primitive: u32) {
        let ShapeHit { t, leaving, point: unit_point } = *hit;
        let is_first = |best: &Hit| self.scene.rank(&self.path) < self.scene.rank(&best.path);
        if t < self.t_max || self.best.as_ref().is_some_and(|best| t == best.t && is_first(best)) {
            self.t_max = t;
            let (path, scene) = (self.path.clone(), self.scene.id);
            self.best = Some(Hit { t, leaving, primitive, unit_point, unit_gradient: None, path, scene });
        }
    }

    /// Breaks once a hit has ended the query.
    fn flow(&self) -> ControlFlow<()> {
        if self.is_occluded { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }
}

/// A query within one group.
struct InGroup<'t, 'a> {
    traversal: &'t mut Traversal<'a>,
    group: &'t Group,
    /// The ray in the group's space.
    ray: &'t Ray,
    /// The ray in the tree's space.
    reciprocal: RayReciprocal,
    slack: DVec3,
    stretch: f64,
}

impl Visitor for InGroup<'_, '_> {
    const IS_ORDERED: bool = true;

    fn enter(&mut self, bounds: &Aabb) -> Option<f64> {
        self.traversal.visited += 1;
        let bounds = Aabb { min: bounds.min - self.slack, max: bounds.max + self.slack };
        bounds.clip(&self.reciprocal, self.traversal.t_max)
    }

    fn is_behind(&self, near: f64) -> bool {
        near > self.traversal.t_max
    }

    fn leaf(&mut self, index: u32) -> ControlFlow<()> {
        let Self { traversal, group, ray, .. } = self;
        traversal.visited += 1;
        let leaf = &group.leaves[index as usize];
        traversal.path.push(index);
        let start = SurfaceStart::at(traversal.start, &traversal.path);
        let ray = ray.through(&leaf.unit_from_group);
        let shape = traversal.scene.primitives[leaf.primitive as usize].unit_shape();
        if traversal.is_any_hit {
            traversal.is_occluded |= shape.occluded(&ray, start, traversal.t_max);
        } else if let Some(hit) = shape.intersect(&ray, start) {
            traversal.take(&hit, leaf.primitive);
        }
        traversal.path.pop();
        traversal.flow()
    }

    fn instance(&mut self, index: u32, near: f64) -> ControlFlow<()> {
        let Self { traversal, group, ray, stretch, .. } = self;
        let instance = &group.instances[index as usize];
        let stretch = *stretch * instance.stretch;
        if traversal.footprint.hides(instance.size() * stretch, near) {
            traversal.visit_proxy(instance, index, ray);
            return traversal.flow();
        }
        traversal.path.push(index);
        let flow = traversal.visit_group(&instance.group, &ray.to_local(instance.map()), stretch);
        traversal.path.pop();
        flow
    }
}
