//! The primitive nearest to a point, wherever the point is, and the signed distance to the surface.
//!
//! Best-first search: parts of the graph are opened in the order of a lower bound on their distance. A leaf is first
//! bounded by two evaluations of N, and its distance is computed only where bounds leave a choice.

use std::collections::BinaryHeap;

use superegg_geom::glam::{DAffine3, DMat3, DVec3};
use superegg_geom::{Aabb, SearchLimits, Superquadric, Transform, inverse_of, unit_vector};

use crate::point::{PointAnswer, PointLimits, PrimitiveAtPoint};
use crate::ranked::Ranked;
use crate::scene::compiled::CompiledScene;
use crate::scene::group::{Group, Leaf, Target};
use crate::scene::node::Slot;
use crate::scene::path::InstancePath;

/// The primitive that answers for a point, and its value there.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct NearestPrimitive {
    /// Whether the point is inside any primitive.
    pub inside: bool,
    /// The inside-outside value of the primitive at the point.
    pub value: f64,
    /// The instance of the primitive.
    pub path: InstancePath,
    /// Whether all of the scene was searched within the limits. Otherwise it is the best answer found.
    pub is_complete: bool,
}

/// The signed distance from a point to the surface of a scene.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct SceneDistance {
    /// The distance, negative inside.
    ///
    /// Outside of all primitives: the distance to the nearest surface. Inside: minus the greatest depth in any one
    /// primitive. Where primitives overlap the surface of the union is at least that far.
    pub distance: f64,
    /// The proven error of the distance.
    pub error: f64,
    /// The instance whose surface it is.
    pub path: InstancePath,
    /// Whether all of the scene was searched within the limits. Otherwise it is the best answer found.
    pub is_complete: bool,
}

impl CompiledScene {
    /// The primitive that answers for a point of world space; `None` for a scene without primitives and a point that is
    /// not finite.
    ///
    /// Where boxes hold the point it is that of [`CompiledScene::query_point`]: the least value among the primitives
    /// whose smallest axis-aligned world box holds the point. Elsewhere it is the primitive whose surface is nearest, by
    /// Euclidean distance. Among equal ones the first in the order of children counts.
    pub fn nearest_primitive(&self, point: DVec3, limits: &PointLimits) -> Option<NearestPrimitive> {
        let (PointAnswer { inside, least }, is_complete) = self.query_point_within(point, limits);
        if let Some((value, path)) = least {
            return Some(NearestPrimitive { inside, value, path, is_complete });
        }
        let mut search = Search::new(self, point, limits)?;
        let leaf = search.nearest()?;
        let Candidate { value, .. } = search.leaves[leaf];
        let path = search.path(leaf);
        Some(NearestPrimitive { inside: false, value, path, is_complete: is_complete && search.is_complete })
    }

    /// The signed distance from a point of world space to the surface; `None` for a scene without primitives and a point
    /// that is not finite.
    pub fn signed_distance(&self, point: DVec3, limits: &PointLimits) -> Option<SceneDistance> {
        let (holders, is_complete) = self.primitives_holding(point, MOST_HOLDERS, limits);
        if !holders.is_empty() {
            return self.greatest_depth(point, &holders, is_complete);
        }
        let mut search = Search::new(self, point, limits)?;
        let leaf = search.nearest()?;
        search.refine_to_the_end(leaf);
        let Bounds { lower, upper } = search.leaves[leaf].bounds;
        let is_complete = is_complete && search.is_complete;
        let error = upper - lower.min(search.unopened);
        Some(SceneDistance { distance: upper, error, path: search.path(leaf), is_complete })
    }

    /// The greatest depth of a point in the primitives that hold it.
    fn greatest_depth(
        &self,
        point: DVec3,
        holders: &[PrimitiveAtPoint],
        is_complete: bool,
    ) -> Option<SceneDistance> {
        // The surface point towards the centre bounds the depth, and the deepest are tried first.
        let mut bounded: Vec<(f64, &InstancePath)> =
            holders.iter().map(|holder| (self.depth_bound(point, &holder.path), &holder.path)).collect();
        bounded.sort_by(|a, b| b.0.total_cmp(&a.0));
        let mut deepest: Option<SceneDistance> = None;
        for (bound, path) in bounded {
            if deepest.as_ref().is_some_and(|deepest| bound < -deepest.distance) {
                break;
            }
            let (unit_from_world, target) = self.unit_from_world(path);
            let Target::Primitive(primitive) = target else { continue };
            let (shape, map) = (self.primitive(primitive).unit_shape(), inverse_of(&unit_from_world));
            let closest = shape.closest_point_under(&map, point, &SearchLimits::default());
            let Some(closest) = closest else { continue };
            if deepest.as_ref().is_none_or(|deepest| closest.distance < deepest.distance) {
                let (distance, error) = (closest.distance.min(0.0), closest.error);
                deepest = Some(SceneDistance { distance, error, path: path.clone(), is_complete });
            }
        }
        deepest
    }

    /// An upper bound on the depth of a point in a primitive: the way out along the ray from the centre.
    fn depth_bound(&self, point: DVec3, path: &InstancePath) -> f64 {
        let (unit_from_world, target) = self.unit_from_world(path);
        let Target::Primitive(primitive) = target else { return 0.0 };
        let from_center = point - inverse_of(&unit_from_world).translation;
        let norm =
            self.primitive(primitive).unit_shape().norm().value(unit_from_world.transform_point3(point));
        let bound = from_center.length() * (1.0 / norm - 1.0);
        if bound.is_nan() { f64::INFINITY } else { bound }
    }
}

/// The most primitives that hold one point for which depths are computed.
const MOST_HOLDERS: usize = 1000;

/// Bounds on the distance to a primitive.
#[derive(Clone, Copy, Debug)]
struct Bounds {
    lower: f64,
    upper: f64,
}

/// How much work the bounds of a leaf have had.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Level {
    /// Two evaluations of N.
    Quick,
    /// A search to a twentieth of the gap that quick bounds leave.
    Coarse,
    /// A search to the last digits that it can find.
    Fine,
}

/// A leaf that the search has reached.
struct Candidate<'a> {
    leaf: &'a Leaf,
    index: u32,
    frame: usize,
    world_from_unit: DAffine3,
    /// The inside-outside value at the point.
    value: f64,
    bounds: Bounds,
    level: Level,
}

/// A group on the way to a leaf.
struct Frame<'a> {
    group: &'a Group,
    world_from_group: Transform,
    /// The point in the group's space.
    local: DVec3,
    path: InstancePath,
}

/// A part of the graph that waits to be opened.
#[derive(Clone, Copy, Debug)]
enum Part {
    /// A node of the group of a frame.
    Node { frame: usize, node: u32 },
    /// A child of the group of a frame that is a group.
    Instance { frame: usize, instance: u32 },
    /// A leaf of the group of a frame, not bounded yet.
    Leaf { frame: usize, leaf: u32 },
    /// A leaf with bounds, by its index among the candidates.
    Bounded(usize),
}

/// A part with a lower bound on its distance, and the number of levels above. At equal bounds the deepest part comes first,
/// so that a leaf is soon reached where many boxes hold the point.
type Pending = Ranked<usize, Part>;

fn pending(bound: f64, depth: usize, part: Part) -> Pending {
    Ranked { priority: -bound, rank: depth, item: part }
}

struct Search<'a> {
    scene: &'a CompiledScene,
    point: DVec3,
    frames: Vec<Frame<'a>>,
    leaves: Vec<Candidate<'a>>,
    pending: BinaryHeap<Pending>,
    /// The candidate of the least upper bound.
    best: Option<usize>,
    queue_left: usize,
    /// The least lower bound of the parts that were given up; infinite where there are none.
    unopened: f64,
    is_complete: bool,
}

impl<'a> Search<'a> {
    fn new(scene: &'a CompiledScene, point: DVec3, limits: &PointLimits) -> Option<Self> {
        let group = scene.root.as_deref().filter(|_| point.is_finite())?;
        let root = Frame {
            group,
            world_from_group: Transform::IDENTITY,
            local: point,
            path: InstancePath::default(),
        };
        let pending = BinaryHeap::from([pending(0.0, 0, Part::Node { frame: 0, node: 0 })]);
        let (frames, leaves) = (vec![root], Vec::new());
        let queue_left = limits.queued;
        Some(Self {
            scene,
            point,
            frames,
            leaves,
            pending,
            best: None,
            queue_left,
            unopened: f64::INFINITY,
            is_complete: true,
        })
    }

    /// The index of the nearest candidate.
    fn nearest(&mut self) -> Option<usize> {
        while let Some(Ranked { priority, item: part, .. }) = self.pending.pop() {
            let bound = -priority;
            if bound > self.enough() {
                break;
            }
            if self.queue_left == 0 {
                // The best answer so far, or else the first one on the way down from here.
                self.unopened = self.unopened.min(bound);
                self.pending.clear();
                if self.best.is_some() {
                    break;
                }
            }
            match part {
                Part::Node { frame, node } => self.open_node(frame, node),
                Part::Instance { frame, instance } => self.open_instance(frame, instance, bound),
                Part::Leaf { frame, leaf } => self.bound_leaf(frame, leaf, bound),
                Part::Bounded(leaf) if self.is_decided(leaf) => return Some(leaf),
                Part::Bounded(leaf) => self.refine(leaf),
            }
        }
        // A part that was given up matters only if it may be nearer by more than the error of a distance.
        self.is_complete = self.unopened >= self.enough() * (1.0 - DISTANCE_ERROR);
        self.first_of_the_nearest()
    }

    /// A distance beyond which no part can be the answer: the least upper bound, with room for rounding.
    fn enough(&self) -> f64 {
        self.best.map_or(f64::INFINITY, |best| self.leaves[best].bounds.upper * (1.0 + TIE))
    }

    /// Whether no other part can be nearer than this one, whose bound is the least.
    fn is_decided(&self, leaf: usize) -> bool {
        let enough = self.enough();
        let is_rival = |(other, rival): (usize, &Candidate<'_>)| {
            other != leaf && rival.level == Level::Fine && rival.bounds.lower <= enough
        };
        self.best == Some(leaf)
            && self.pending.peek().is_none_or(|next| -next.priority > enough)
            && !self.leaves.iter().enumerate().any(is_rival)
    }

    fn open_node(&mut self, frame: usize, node: u32) {
        let Frame { group, world_from_group, path, .. } = &self.frames[frame];
        for (bounds, slot) in group.nodes[node as usize].children() {
            self.queue_left = self.queue_left.saturating_sub(1);
            let in_group = group.space.group_box(&bounds);
            let is_root = path.indices().is_empty();
            let world =
                if is_root { in_group } else { in_group.transformed(world_from_group).rounded_outward() };
            let part = match slot {
                Slot::Node(node) => Part::Node { frame, node },
                Slot::Leaf(leaf) => Part::Leaf { frame, leaf },
                Slot::Instance(instance) => Part::Instance { frame, instance },
            };
            let bound = distance_to_box(self.point, &world);
            self.pending.push(pending(bound, path.indices().len(), part));
        }
    }

    fn open_instance(&mut self, frame: usize, instance: u32, bound: f64) {
        let Frame { group, world_from_group, local, path } = &self.frames[frame];
        let child = &group.instances[instance as usize];
        let Ok(world_from_group) = world_from_group.after(child.map()) else { return };
        let mut path = path.clone();
        path.push(instance);
        let depth = path.indices().len();
        let local = child.map().inverse().transform_point3(*local);
        self.frames.push(Frame { group: &child.group, world_from_group, local, path });
        let part = Part::Node { frame: self.frames.len() - 1, node: 0 };
        self.pending.push(pending(bound, depth, part));
    }

    /// Bounds the distance to a leaf; `bound` is that to its box.
    fn bound_leaf(&mut self, frame: usize, index: u32, bound: f64) {
        let Frame { group, world_from_group, local, .. } = &self.frames[frame];
        let leaf = &group.leaves[index as usize];
        let unit_point = leaf.unit_from_group.transform_point3(*local);
        let world_from_unit = *world_from_group.forward() * inverse_of(&leaf.unit_from_group);
        let shape = self.scene.primitives.unit_shape(leaf.primitive);
        let value = shape.inside_outside(unit_point);
        let value = if value.is_nan() { f64::INFINITY } else { value };
        let unit_from_world = leaf.unit_from_group.matrix3 * world_from_group.inverse().matrix3;
        let quick = quick_bounds(&shape, &world_from_unit.matrix3, &unit_from_world, unit_point);
        let bounds = Bounds { lower: quick.lower.max(bound).min(quick.upper), upper: quick.upper };
        self.leaves.push(Candidate {
            leaf,
            index,
            frame,
            world_from_unit,
            value,
            bounds,
            level: Level::Quick,
        });
        self.update(self.leaves.len() - 1);
    }

    /// Narrows the bounds of a candidate by one level.
    fn refine(&mut self, leaf: usize) {
        let candidate = &mut self.leaves[leaf];
        let (level, limits) = match candidate.level {
            Level::Quick => {
                // To a twentieth of what is open, so that a small shape far away is narrowed too.
                let Bounds { lower, upper } = candidate.bounds;
                let relative_tolerance = (0.05 * (upper - lower) / upper).clamp(1e-9, 0.01);
                (Level::Coarse, SearchLimits { relative_tolerance, most_cells: 2_000 })
            }
            Level::Coarse => (Level::Fine, SearchLimits::default()),
            Level::Fine => return,
        };
        candidate.level = level;
        let shape = self.scene.primitives.unit_shape(candidate.leaf.primitive);
        if let Some(closest) = shape.closest_point_under(&candidate.world_from_unit, self.point, &limits) {
            let upper = closest.distance.max(0.0);
            let Bounds { lower, .. } = candidate.bounds;
            candidate.bounds = Bounds { lower: lower.max(upper - closest.error).min(upper), upper };
            if closest.error <= SearchLimits::default().relative_tolerance * upper {
                candidate.level = Level::Fine;
            }
        }
        self.update(leaf);
    }

    fn refine_to_the_end(&mut self, leaf: usize) {
        while self.leaves[leaf].level != Level::Fine {
            self.refine(leaf);
        }
    }

    /// Takes the bounds of a candidate into account.
    fn update(&mut self, leaf: usize) {
        let Candidate { bounds, level, .. } = &self.leaves[leaf];
        if self.best.is_none_or(|best| bounds.upper < self.leaves[best].bounds.upper) {
            self.best = Some(leaf);
        }
        if *level != Level::Fine {
            let (bound, part) = (bounds.lower, Part::Bounded(leaf));
            self.pending.push(pending(bound, usize::MAX, part));
        }
    }

    /// The first, in the order of children, of the candidates that are as near as the best one.
    fn first_of_the_nearest(&self) -> Option<usize> {
        let best = self.best?;
        let enough = self.enough();
        let is_tied = |leaf: &usize| self.leaves[*leaf].bounds.upper <= enough;
        let tied: Vec<usize> = (0..self.leaves.len()).filter(is_tied).collect();
        if tied.len() <= 1 {
            return Some(best);
        }
        tied.into_iter().min_by_key(|leaf| self.scene.rank(&self.path(*leaf)))
    }

    fn path(&self, leaf: usize) -> InstancePath {
        let Candidate { index, frame, .. } = self.leaves[leaf];
        let mut path = self.frames[frame].path.clone();
        path.push(index);
        path
    }
}

/// Distances that differ by less, relatively, are equal.
const TIE: f64 = 1e-11;
/// The relative error of a distance that counts as none.
const DISTANCE_ERROR: f64 = 1e-9;

fn distance_to_box(point: DVec3, bounds: &Aabb) -> f64 {
    let outside = (bounds.min - point).max(point - bounds.max).max(DVec3::ZERO);
    // A box beyond the range of f64 excludes nothing.
    let distance = outside.length() * (1.0 - 4.0 * f64::EPSILON);
    if distance.is_nan() { 0.0 } else { distance }
}

/// Bounds on the distance from a point outside to the image of a unit shape under a map.
///
/// With m = M p for the unit point p, the surface point p / N(p) towards the centre is `|m| (1 - 1/N)` away. Any plane
/// with a unit normal u and beyond the shape, whose support function is h, gives the lower bound `u . m - h(M^T u)`. Tried
/// are the normal of the surface at that point, which is good near the shape, and the direction of m, good far away.
fn quick_bounds(shape: &Superquadric, matrix: &DMat3, unit_from_world: &DMat3, unit_point: DVec3) -> Bounds {
    let nothing = Bounds { lower: 0.0, upper: f64::INFINITY };
    let from_center = *matrix * unit_point;
    let (norm, gradient) = shape.norm().value_and_gradient(unit_point);
    if !from_center.is_finite() || norm.is_nan() {
        return nothing;
    }
    let length = from_center.length();
    let upper = (length * (1.0 - 1.0 / norm)).max(0.0);
    let normals = [unit_vector(unit_from_world.transpose() * gradient), unit_vector(from_center)];
    let lower = normals.into_iter().flatten().fold(0.0, |best: f64, normal| {
        let support = shape.norm().support(matrix.transpose() * normal);
        // Less the rounding of both terms. `max` ignores a bound that is NaN.
        best.max(normal.dot(from_center) - support - 16.0 * f64::EPSILON * (length + support))
    });
    Bounds { lower, upper }
}
