//! Queries of points and boxes.

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, Ordering};

use superegg_geom::glam::DVec3;
use superegg_geom::{Aabb, Transform, inverse_of};

use crate::scene::compiled::CompiledScene;
use crate::scene::group::{Group, Leaf};
use crate::scene::path::InstancePath;
use crate::walk::Visitor;

/// The answer to a point query.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct PointAnswer {
    /// Whether the point is inside any primitive.
    pub inside: bool,
    /// The least value of the inside-outside function, and the instance that has it. `None` if no box holds the point.
    ///
    /// The function is evaluated in each primitive's own space, over the primitives whose smallest axis-aligned world box
    /// holds the point. At equal values the instance that comes first in the order of children counts.
    pub least: Option<(f64, InstancePath)>,
}

/// A primitive at a point.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct PrimitiveAtPoint {
    /// The inside-outside value at the point.
    pub value: f64,
    /// The instance.
    pub path: InstancePath,
}

/// The bounds on the work for one point. Only a deep fractal whose parts overlap reaches them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct PointLimits {
    /// The most boxes that are tested for whether they hold the point.
    pub boxes: u64,
    /// The most boxes that wait in the order of their distances.
    pub queued: usize,
}

impl Default for PointLimits {
    /// 4,000,000 boxes, of which 250,000 in order: less than half a second and 100 MB.
    fn default() -> Self {
        Self { boxes: 4_000_000, queued: 250_000 }
    }
}

impl CompiledScene {
    /// Tests a point of world space against all primitives.
    ///
    /// ```
    /// use superegg_geom::glam::DVec3;
    /// use superegg_scene::Scene;
    /// use superegg_trace::CompiledScene;
    ///
    /// let mut scene = Scene::default();
    /// scene.ensure_primitive("ball")?;
    /// let compiled = CompiledScene::compile(&scene, Some("ball"), 1);
    /// assert!(compiled.query_point(DVec3::splat(0.1)).inside);
    /// assert!(!compiled.query_point(DVec3::splat(3.0)).inside);
    /// # Ok::<(), superegg_scene::SceneError>(())
    /// ```
    pub fn query_point(&self, point: DVec3) -> PointAnswer {
        let never = AtomicBool::new(false);
        self.query_point_unless(point, &never).unwrap_or(PointAnswer { inside: false, least: None })
    }

    /// [`CompiledScene::query_point`] that stops with `None` once `cancel` is true. Where the parts of a deep fractal
    /// overlap, a point may lie in the boxes of more instances than can ever be tested.
    pub fn query_point_unless(&self, point: DVec3, cancel: &AtomicBool) -> Option<PointAnswer> {
        let (answer, _) = self.run_point_query(point, u64::MAX, cancel);
        (!cancel.load(Ordering::Relaxed)).then_some(answer)
    }

    /// [`CompiledScene::query_point`] within limits, and whether it was complete.
    pub(crate) fn query_point_within(&self, point: DVec3, limits: &PointLimits) -> (PointAnswer, bool) {
        self.run_point_query(point, limits.boxes, &AtomicBool::new(false))
    }

    fn run_point_query(&self, point: DVec3, boxes: u64, cancel: &AtomicBool) -> (PointAnswer, bool) {
        let path = InstancePath::default();
        let mut query = PointQuery { scene: self, point, path, least: None, cancel, boxes_left: boxes };
        if let Some(root) = self.root.as_deref() {
            // A break only ends the query early; `cancel` and `boxes_left` tell why.
            let _ = query.visit_group(root, &Transform::IDENTITY, point);
        }
        let inside = query.least.as_ref().is_some_and(|(value, _)| *value < 0.0);
        (PointAnswer { inside, least: query.least }, query.boxes_left > 0)
    }

    /// The primitives that hold a point of world space, in the order of children, and whether these are all: not where
    /// there are more than `most` or the search reaches its limits.
    pub fn primitives_holding(
        &self,
        point: DVec3,
        most: usize,
        limits: &PointLimits,
    ) -> (Vec<PrimitiveAtPoint>, bool) {
        let mut query = Holders {
            scene: self,
            path: InstancePath::default(),
            most,
            boxes_left: limits.boxes,
            found: Vec::new(),
            is_complete: true,
        };
        if let Some(root) = self.root.as_deref() {
            // A break only ends the query early, at its limits.
            let _ = query.visit_group(root, point);
        }
        let Holders { mut found, is_complete, .. } = query;
        found.sort_by_cached_key(|holder| self.rank(&holder.path));
        (found, is_complete)
    }

    /// Whether a point of world space is inside any primitive: [`PointAnswer::inside`], up to rounding.
    ///
    /// The query ends at the first primitive that holds the point. `None` if `cancel` turns true before.
    pub fn contains_point_unless(&self, point: DVec3, cancel: &AtomicBool) -> Option<bool> {
        let mut query = Containment { scene: self, cancel, is_inside: false, is_cancelled: false };
        if let Some(root) = self.root.as_deref() {
            // A break only ends the query early; the flags tell why.
            let _ = query.visit_group(root, point);
        }
        (!query.is_cancelled).then_some(query.is_inside)
    }

    /// The instances of primitives whose smallest axis-aligned world box meets `query`, a box in world space.
    ///
    /// Boxes are rounded outwards, so no such instance is missed. The order is unspecified. At most `limit` instances are
    /// returned, since a fractal may have more than can be listed.
    pub fn query_box(&self, query: &Aabb, limit: usize) -> Vec<InstancePath> {
        let mut answer =
            BoxQuery { scene: self, query, limit, path: InstancePath::default(), found: Vec::new() };
        if let Some(root) = self.root.as_deref() {
            // A break only ends the query early, at the limit.
            let _ = answer.visit_group(root, &Transform::IDENTITY);
        }
        answer.found
    }
}

/// The smallest axis-aligned box around a leaf in the world, rounded outwards.
fn leaf_bounds(scene: &CompiledScene, leaf: &Leaf, world_from_group: &Transform) -> Aabb {
    let shape = scene.primitives.unit_shape(leaf.primitive);
    let world_from_unit = *world_from_group.forward() * inverse_of(&leaf.unit_from_group);
    let half = shape.half_extent_under(&world_from_unit.matrix3);
    Aabb::around(world_from_unit.translation, half).rounded_outward()
}

/// The world box around a box of a group's tree.
fn world_box(group: &Group, tree_box: &Aabb, world_from_group: &Transform) -> Aabb {
    group.space.group_box(tree_box).transformed(world_from_group).rounded_outward()
}

/// Whether any primitive holds a point.
struct Containment<'a> {
    scene: &'a CompiledScene,
    cancel: &'a AtomicBool,
    is_inside: bool,
    is_cancelled: bool,
}

impl Containment<'_> {
    /// Visits a group with the point in its space.
    fn visit_group(&mut self, group: &Group, local: DVec3) -> ControlFlow<()> {
        if self.cancel.load(Ordering::Relaxed) {
            self.is_cancelled = true;
            return ControlFlow::Break(());
        }
        group.walk(&mut ContainmentInGroup { query: self, group, local })
    }
}

struct ContainmentInGroup<'q, 'a> {
    query: &'q mut Containment<'a>,
    group: &'q Group,
    local: DVec3,
}

impl Visitor for ContainmentInGroup<'_, '_> {
    const IS_ORDERED: bool = false;

    fn enter(&mut self, bounds: &Aabb) -> Option<f64> {
        self.group.space.group_box(bounds).contains(self.local).then_some(0.0)
    }

    fn leaf(&mut self, index: u32) -> ControlFlow<()> {
        let leaf = &self.group.leaves[index as usize];
        let shape = self.query.scene.primitives.unit_shape(leaf.primitive);
        if shape.inside_outside(leaf.unit_from_group.transform_point3(self.local)) < 0.0 {
            self.query.is_inside = true;
            return ControlFlow::Break(());
        }
        ControlFlow::Continue(())
    }

    fn instance(&mut self, index: u32, _: f64) -> ControlFlow<()> {
        let instance = &self.group.instances[index as usize];
        self.query.visit_group(&instance.group, instance.map().inverse().transform_point3(self.local))
    }
}

/// The primitives that hold a point.
struct Holders<'a> {
    scene: &'a CompiledScene,
    path: InstancePath,
    most: usize,
    boxes_left: u64,
    found: Vec<PrimitiveAtPoint>,
    is_complete: bool,
}

impl Holders<'_> {
    /// Visits a group with the point in its space.
    fn visit_group(&mut self, group: &Group, local: DVec3) -> ControlFlow<()> {
        group.walk(&mut HoldersInGroup { query: self, group, local })
    }

    fn stop(&mut self) -> ControlFlow<()> {
        self.is_complete = false;
        ControlFlow::Break(())
    }
}

struct HoldersInGroup<'q, 'a> {
    query: &'q mut Holders<'a>,
    group: &'q Group,
    local: DVec3,
}

impl Visitor for HoldersInGroup<'_, '_> {
    const IS_ORDERED: bool = false;

    fn enter(&mut self, bounds: &Aabb) -> Option<f64> {
        self.query.boxes_left = self.query.boxes_left.saturating_sub(1);
        self.group.space.group_box(bounds).contains(self.local).then_some(0.0)
    }

    fn leaf(&mut self, index: u32) -> ControlFlow<()> {
        let leaf = &self.group.leaves[index as usize];
        let query = &mut *self.query;
        let shape = query.scene.primitives.unit_shape(leaf.primitive);
        let value = shape.inside_outside(leaf.unit_from_group.transform_point3(self.local));
        if value < 0.0 {
            if query.found.len() >= query.most {
                return query.stop();
            }
            let mut path = query.path.clone();
            path.push(index);
            query.found.push(PrimitiveAtPoint { value, path });
        }
        ControlFlow::Continue(())
    }

    fn instance(&mut self, index: u32, _: f64) -> ControlFlow<()> {
        let query = &mut *self.query;
        if query.boxes_left == 0 {
            return query.stop();
        }
        let instance = &self.group.instances[index as usize];
        query.path.push(index);
        let local = instance.map().inverse().transform_point3(self.local);
        let flow = query.visit_group(&instance.group, local);
        query.path.pop();
        flow
    }
}

/// The instances in a box.
struct BoxQuery<'a> {
    scene: &'a CompiledScene,
    query: &'a Aabb,
    limit: usize,
    path: InstancePath,
    found: Vec<InstancePath>,
}

impl BoxQuery<'_> {
    fn visit_group(&mut self, group: &Group, world_from_group: &Transform) -> ControlFlow<()> {
        if self.found.len() >= self.limit {
            return ControlFlow::Break(());
        }
        group.walk(&mut BoxInGroup { query: self, group, world_from_group })
    }
}

struct BoxInGroup<'q, 'a> {
    query: &'q mut BoxQuery<'a>,
    group: &'q Group,
    world_from_group: &'q Transform,
}

impl Visitor for BoxInGroup<'_, '_> {
    const IS_ORDERED: bool = false;

    fn enter(&mut self, bounds: &Aabb) -> Option<f64> {
        world_box(self.group, bounds, self.world_from_group).intersects(self.query.query).then_some(0.0)
    }

    fn leaf(&mut self, index: u32) -> ControlFlow<()> {
        let leaf = &self.group.leaves[index as usize];
        let query = &mut *self.query;
        if leaf_bounds(query.scene, leaf, self.world_from_group).intersects(query.query) {
            query.path.push(index);
            query.found.push(query.path.clone());
            query.path.pop();
            if query.found.len() >= query.limit {
                return ControlFlow::Break(());
            }
        }
        ControlFlow::Continue(())
    }

    fn instance(&mut self, index: u32, _: f64) -> ControlFlow<()> {
        let instance = &self.group.instances[index as usize];
        let Ok(world_from_child) = self.world_from_group.after(instance.map()) else {
            return ControlFlow::Continue(());
        };
        self.query.path.push(index);
        let flow = self.query.visit_group(&instance.group, &world_from_child);
        self.query.path.pop();
        flow
    }
}

/// The least value of the inside-outside function at a point.
struct PointQuery<'a> {
    scene: &'a CompiledScene,
    point: DVec3,
    path: InstancePath,
    least: Option<(f64, InstancePath)>,
    cancel: &'a AtomicBool,
    boxes_left: u64,
}

impl PointQuery<'_> {
    /// Visits a group; `local` is the point in its space.
    fn visit_group(&mut self, group: &Group, world_from_group: &Transform, local: DVec3) -> ControlFlow<()> {
        if self.cancel.load(Ordering::Relaxed) || self.boxes_left == 0 {
            return ControlFlow::Break(());
        }
        group.walk(&mut PointInGroup { query: self, group, world_from_group, local })
    }

    fn visit_leaf(&mut self, leaf: &Leaf, world_from_group: &Transform, local: DVec3) {
        if !leaf_bounds(self.scene, leaf, world_from_group).contains(self.point) {
            return;
        }
        let shape = self.scene.primitives.unit_shape(leaf.primitive);
        // A local point beyond the range of f64 is outside.
        let value = shape.inside_outside(leaf.unit_from_group.transform_point3(local));
        let value = if value.is_nan() { f64::INFINITY } else { value };
        let is_less = self.least.as_ref().is_none_or(|(least, path)| {
            value < *least || (value == *least && self.scene.rank(&self.path) < self.scene.rank(path))
        });
        if is_less {
            self.least = Some((value, self.path.clone()));
        }
    }
}

struct PointInGroup<'q, 'a> {
    query: &'q mut PointQuery<'a>,
    group: &'q Group,
    world_from_group: &'q Transform,
    local: DVec3,
}

impl Visitor for PointInGroup<'_, '_> {
    const IS_ORDERED: bool = false;

    fn enter(&mut self, bounds: &Aabb) -> Option<f64> {
        self.query.boxes_left = self.query.boxes_left.saturating_sub(1);
        // World boxes decide: a primitive's world box lies within that of any box around the primitive.
        world_box(self.group, bounds, self.world_from_group).contains(self.query.point).then_some(0.0)
    }

    fn leaf(&mut self, index: u32) -> ControlFlow<()> {
        self.query.path.push(index);
        self.query.visit_leaf(&self.group.leaves[index as usize], self.world_from_group, self.local);
        self.query.path.pop();
        ControlFlow::Continue(())
    }

    fn instance(&mut self, index: u32, _: f64) -> ControlFlow<()> {
        let instance = &self.group.instances[index as usize];
        let Ok(world_from_child) = self.world_from_group.after(instance.map()) else {
            return ControlFlow::Continue(());
        };
        let local = instance.map().inverse().transform_point3(self.local);
        self.query.path.push(index);
        let flow = self.query.visit_group(&instance.group, &world_from_child, local);
        self.query.path.pop();
        flow
    }
}
