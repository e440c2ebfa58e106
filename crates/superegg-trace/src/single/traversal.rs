//! The depth-first traversal of one ray, in f64.

use std::ops::ControlFlow;

use superegg_geom::glam::DVec3;
use superegg_geom::{Aabb, Ray, RayReciprocal, RayStart, ShapeHit, scale_to_unit};

use crate::ray::footprint::Footprint;
use crate::ray::limits::RayLimits;
use crate::ray::lottery::{Lottery, PathHash};
use crate::ray::query::{Hit, SurfaceStart, TraceRay};
use crate::scene::compiled::CompiledScene;
use crate::scene::group::{Group, Instance};
use crate::scene::path::InstancePath;
use crate::scene::proxy::{Proxy, stops_light};
use crate::walk::Visitor;

/// The bound of a usual ray. Few rays through scenes without overlaps need so many.
const MOST_BOXES: u64 = 1 << 12;
/// The bound of a ray that is widened already.
const MOST_BOXES_WIDENED: u64 = 1 << 8;

/// How the work of a query is bounded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Bound {
    /// Not at all.
    None,
    /// Groups are hit as proxies at ever larger sizes.
    Proxies,
    /// The query ends without an answer after this many boxes.
    Boxes(u64),
}

/// The state of one query.
pub(super) struct Traversal<'a> {
    pub(super) scene: &'a CompiledScene,
    pub(super) start: Option<&'a SurfaceStart>,
    /// No hit beyond this counts.
    pub(super) t_max: f64,
    pub(super) footprint: Footprint,
    lottery: Lottery,
    /// Whether any hit ends the query.
    pub(super) is_any_hit: bool,
    /// Whether a hit ended it.
    pub(super) is_occluded: bool,
    pub(super) path: InstancePath,
    pub(super) best: Option<Hit>,
    /// The boxes and shapes tested so far.
    pub(super) visited: u64,
    pub(super) bound: Bound,
    /// Whether the ray was widened before, because too many parts overlap around it.
    pub(super) is_widened: bool,
    /// Whether a group was hit as its proxy to bound the work.
    pub(super) is_coarsened: bool,
}

impl<'a> Traversal<'a> {
    fn new(scene: &'a CompiledScene, ray: &'a TraceRay) -> Self {
        let bound = if ray.footprint == Footprint::NONE { Bound::None } else { Bound::Proxies };
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
            bound,
            is_widened: false,
            is_coarsened: false,
        }
    }

    /// A query for any hit before `t_max`.
    pub(super) fn any_hit(scene: &'a CompiledScene, ray: &'a TraceRay, t_max: f64) -> Self {
        Self { t_max, is_any_hit: true, ..Self::new(scene, ray) }
    }

    /// A query for the closest hit, with the ray to trace and the factor that converts its t back. The direction is
    /// scaled by a power of two to the order of 1, so that no transform of the scene takes it out of the range of f64.
    pub(super) fn closest(scene: &'a CompiledScene, ray: &'a TraceRay) -> Option<(Self, Ray, f64)> {
        let (direction, scale) = scale_to_unit(ray.ray.direction)?;
        let footprint = Footprint { spread: ray.footprint.spread * scale, ..ray.footprint };
        let traversal = Self { footprint, lottery: Lottery::of(direction), ..Self::new(scene, ray) };
        Some((traversal, Ray { direction, ..ray.ray }, scale))
    }

    /// Answers with an exact hit or none.
    pub(super) fn bound_exactly(&mut self, limits: &RayLimits) {
        self.bound = Bound::Boxes(limits.boxes);
    }

    /// A depth-first traversal that tests more boxes begins again in order.
    pub(super) fn most_boxes(&self) -> u64 {
        if self.is_widened { MOST_BOXES_WIDENED } else { MOST_BOXES }
    }

    /// Whether the query has ended without an answer.
    pub(super) fn is_over(&self) -> bool {
        matches!(self.bound, Bound::Boxes(most) if self.visited > most)
    }

    /// Traces the ray through the scene.
    pub(super) fn run(&mut self, ray: &Ray) {
        let Some(root) = self.scene.root.as_deref() else { return };
        // A break only ends the query early.
        let _ = self.visit_group(root, ray, 1.0);
        if self.has_given_up() {
            self.path.clear();
            self.run_in_order(root, ray);
        }
    }

    /// Whether the depth-first traversal tests too many boxes.
    fn has_given_up(&self) -> bool {
        self.bound != Bound::None && self.visited > self.most_boxes()
    }

    /// Visits a group with the ray in its space. `stretch` bounds the factor from lengths of the group to the world's.
    fn visit_group(&mut self, group: &Group, ray: &Ray, stretch: f64) -> ControlFlow<()> {
        let boxes = BoxTest::new(group, ray);
        group.walk(&mut InGroup { traversal: self, group, ray, boxes, stretch })
    }

    /// Tests a primitive of the group that the path leads to.
    pub(super) fn visit_leaf(&mut self, group: &Group, index: u32, ray: &Ray) {
        self.visited += 1;
        let leaf = &group.leaves[index as usize];
        self.path.push(index);
        let start = SurfaceStart::at(self.start, &self.path);
        let ray = ray.through(&leaf.unit_from_group);
        let shape = self.scene.primitives.unit_shape(leaf.primitive);
        if self.is_any_hit {
            self.is_occluded |= shape.occluded(&ray, start, self.t_max);
        } else if let Some(hit) = shape.intersect(&ray, start) {
            self.take(&hit, leaf.primitive);
        }
        self.path.pop();
    }

    /// Tests the proxy of a child of the group that the path leads to.
    pub(super) fn visit_proxy(&mut self, instance: &Instance, index: u32, ray: &Ray) {
        self.visited += 1;
        let proxy = instance.group.proxy(&self.scene.primitives);
        self.path.push(index | InstancePath::INSTANCE);
        // A ray that starts on a proxy does not hit it again.
        let is_own = SurfaceStart::at(self.start, &self.path) != RayStart::Free;
        let draw = self.lottery.draw(PathHash::of(self.path.indices()));
        if !is_own && draw < proxy.opacity {
            let ray = ray.to_local(instance.map()).through(&proxy.unit_from_group);
            if self.is_any_hit {
                self.is_occluded |= stops_light(proxy.opacity, &ray, self.t_max, draw);
            } else {
                let hit = Proxy::unit_shape().intersect(&ray, RayStart::Free);
                if let Some(hit) = hit.filter(|hit| !hit.leaving && hit.t < self.t_max) {
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

/// A ray against the boxes of a group's tree.
pub(super) struct BoxTest {
    /// The ray in the tree's space.
    reciprocal: RayReciprocal,
    slack: DVec3,
}

impl BoxTest {
    /// For a ray in the group's space.
    pub(super) fn new(group: &Group, ray: &Ray) -> Self {
        let tree_ray = ray.through(&group.space.tree_from_group());
        // The rounding error of the map into the tree's space.
        let slack = DVec3::splat(8.0 * f64::EPSILON * (1.0 + tree_ray.origin.abs().max_element()));
        Self { reciprocal: RayReciprocal::from(&tree_ray), slack }
    }

    /// The t at which the ray enters a box, if it does before `t_max`.
    pub(super) fn clip(&self, bounds: &Aabb, t_max: f64) -> Option<f64> {
        let bounds = Aabb { min: bounds.min - self.slack, max: bounds.max + self.slack };
        bounds.clip(&self.reciprocal, t_max)
    }
}

/// A query within one group.
struct InGroup<'t, 'a> {
    traversal: &'t mut Traversal<'a>,
    group: &'t Group,
    /// The ray in the group's space.
    ray: &'t Ray,
    boxes: BoxTest,
    stretch: f64,
}

impl Visitor for InGroup<'_, '_> {
    const IS_ORDERED: bool = true;

    fn enter(&mut self, bounds: &Aabb) -> Option<f64> {
        self.traversal.visited += 1;
        self.boxes.clip(bounds, self.traversal.t_max)
    }

    fn is_behind(&self, near: f64) -> bool {
        near > self.traversal.t_max
    }

    fn leaf(&mut self, index: u32) -> ControlFlow<()> {
        self.traversal.visit_leaf(self.group, index, self.ray);
        self.traversal.flow()
    }

    fn instance(&mut self, index: u32, near: f64) -> ControlFlow<()> {
        let Self { traversal, group, ray, stretch, .. } = self;
        if traversal.has_given_up() {
            return ControlFlow::Break(());
        }
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
