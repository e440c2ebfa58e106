//! The rays of a stream and their outcomes.

use std::num::NonZeroU32;

use superegg_geom::glam::DVec3;
use superegg_geom::kernels::stream::BoxRay;
use superegg_geom::{Ray, RayStart, ShapeHit, Superquadric};

use crate::ray::footprint::Footprint;
use crate::ray::query::{Hit, SurfaceStart, TraceRay};
use crate::scene::compiled::CompiledScene;
use crate::scene::group::{Group, Leaf};
use crate::scene::path::InstancePath;

/// The task of a stream, and its rays.
#[derive(Clone, Copy)]
pub(super) struct Query<'s> {
    pub(super) scene: &'s CompiledScene,
    pub(super) root: &'s Group,
    /// For occlusion: the end of the rays. `None` for the closest hit.
    pub(super) any_before: Option<f64>,
    pub(super) rays: &'s [TraceRay],
}

/// The outcome for one ray.
#[derive(Clone, Copy, Debug)]
pub(super) enum Outcome {
    /// The ray hits nothing.
    Miss,
    /// Something occludes the ray.
    Occluded,
    /// The closest hit.
    Hit(Nearest),
    /// f32 cannot decide.
    Unresolved,
}

/// The closest hit of a ray.
#[derive(Clone, Copy, Debug)]
pub(super) struct Nearest {
    pub(super) t: f64,
    /// A bound on the error of t.
    pub(super) error: f32,
    /// The path to the group, and the index of the child in it.
    pub(super) trail: TrailId,
    pub(super) child: u32,
    pub(super) precision: Precision,
}

/// How a hit was computed.
#[derive(Clone, Copy, Debug)]
pub(super) enum Precision {
    /// In f64, by the index in [`RayTable::exact`].
    Exact(u32),
    /// In f32.
    Approximate { leaving: bool },
}

/// A path to a group, shared by all rays in it: an index in [`RayTable::trails`] plus 1; `None` for the root.
pub(super) type TrailId = Option<NonZeroU32>;

/// The group above, and the index of the instance there.
#[derive(Clone, Copy, Debug)]
pub(super) struct Trail {
    pub(super) above: TrailId,
    pub(super) instance: u32,
}

/// The state of a ray at leaves.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct LeafState {
    /// The last index of the path that the ray starts on, or [`NO_LEAF`].
    pub(super) starts_on: u32,
    /// The number of leaves that the ray waits for.
    pub(super) waits: u32,
}

/// Marks a ray that starts on no surface. An `Option` would need half again the memory.
pub(super) const NO_LEAF: u32 = u32::MAX;

/// The end, in f32, of a ray that has its outcome.
pub(super) const DONE: f32 = -1.0;

/// A ray and a leaf that it may hit.
#[derive(Clone, Copy)]
pub(super) struct RayLeafPair<'s> {
    /// The id of the ray.
    pub(super) id: u32,
    pub(super) trail: TrailId,
    /// The index of the leaf in its group.
    pub(super) index: u32,
    pub(super) leaf: &'s Leaf,
}

/// The rays of a stream. Rays have ids in the order of their octants within a chunk, so that the rays of a list are
/// neighbours in memory.
#[derive(Debug, Default)]
pub(super) struct RayTable {
    /// The id of each ray, by its index in the query.
    pub(super) id_of: Vec<u32>,
    /// The index of each ray, by its id.
    pub(super) index_of: Vec<u32>,
    pub(super) outcomes: Vec<Outcome>,
    /// No hit beyond these t counts.
    pub(super) ends: Vec<f32>,
    /// Empty if the root has no groups.
    pub(super) footprints: Vec<Footprint>,
    pub(super) leaf_states: Vec<LeafState>,
    /// Origins and directions in the spaces of the open groups, the root's first; there the index of a ray is its id.
    pub(super) lines: Vec<[DVec3; 2]>,
    /// The same rays in the spaces of the groups' trees.
    pub(super) boxes: Vec<BoxRay>,
    pub(super) trails: Vec<Trail>,
    /// The hits computed in f64, at most one for each ray, without their paths.
    pub(super) exact: Vec<Hit>,
    /// Whether a group was hit as its proxy to bound the work, for each ray. Empty until one was.
    pub(super) coarsened: Vec<bool>,
}

impl RayTable {
    /// The outcome of a ray, by its index in the query.
    #[inline(always)]
    pub(super) fn outcome(&self, index: usize) -> &Outcome {
        &self.outcomes[self.id_of[index] as usize]
    }

    /// The ray of an id, as it was given.
    pub(super) fn ray<'s>(&self, query: &Query<'s>, id: usize) -> &'s TraceRay {
        &query.rays[self.index_of[id] as usize]
    }

    /// The path of a hit.
    #[inline(always)]
    pub(super) fn path(&self, nearest: &Nearest) -> InstancePath {
        let mut path = self.path_to(nearest.trail);
        path.push(nearest.child);
        path
    }

    /// The path to a group.
    #[inline(always)]
    pub(super) fn path_to(&self, trail: TrailId) -> InstancePath {
        if trail.is_none() { InstancePath::default() } else { self.path_along(trail) }
    }

    fn path_along(&self, trail: TrailId) -> InstancePath {
        let mut path = InstancePath::default();
        let mut instances = smallvec::SmallVec::<[u32; 8]>::new();
        let mut at = trail;
        while let Some(id) = at {
            let Trail { above, instance } = self.trails[index(id)];
            instances.push(instance);
            at = above;
        }
        instances.iter().rev().for_each(|&instance| path.push(instance));
        path
    }

    /// Adds a trail: the instance below a group.
    pub(super) fn push_trail(&mut self, above: TrailId, instance: u32) -> TrailId {
        self.trails.push(Trail { above, instance });
        NonZeroU32::new(self.trails.len() as u32)
    }

    /// The leaf of an approximate hit, and the ray in the space of its unit shape.
    #[inline(always)]
    pub(super) fn before_leaf<'s>(&self, query: &Query<'s>, nearest: &Nearest, ray: &Ray) -> (&'s Leaf, Ray) {
        let (group, ray) = query.root.follow(self.path_to(nearest.trail).indices(), ray);
        let leaf = &group.leaves[nearest.child as usize];
        (leaf, ray.through(&leaf.unit_from_group))
    }

    /// The start of a ray at a child of the group at `path`, which is restored.
    pub(super) fn start_at(
        &self,
        query: &Query<'_>,
        id: usize,
        path: &mut InstancePath,
        child: u32,
    ) -> RayStart {
        path.push(child);
        let start = SurfaceStart::at(self.ray(query, id).start.as_ref(), path);
        path.pop();
        start
    }

    /// Ends a ray.
    #[inline(always)]
    pub(super) fn end(&mut self, id: usize, outcome: Outcome) {
        self.outcomes[id] = outcome;
        self.ends[id] = DONE;
    }

    /// No hit beyond this t counts.
    #[inline(always)]
    pub(super) fn t_max(&self, query: &Query<'_>, id: usize) -> f64 {
        match self.outcomes[id] {
            Outcome::Hit(nearest) => nearest.t,
            Outcome::Miss | Outcome::Occluded | Outcome::Unresolved => {
                query.any_before.unwrap_or(f64::INFINITY)
            }
        }
    }

    /// Takes a hit if it is closer than the nearest. If their errors overlap, the ray is unresolved.
    #[inline(always)]
    pub(super) fn take(&mut self, query: &Query<'_>, id: usize, hit: Nearest) {
        match self.outcomes[id] {
            Outcome::Unresolved => return,
            Outcome::Hit(old) if f64::from(hit.error + old.error) >= (hit.t - old.t).abs() => {
                return self.end(id, Outcome::Unresolved);
            }
            Outcome::Hit(_) | Outcome::Miss | Outcome::Occluded => {}
        }
        if hit.t < self.t_max(query, id) {
            self.outcomes[id] = Outcome::Hit(hit);
            self.ends[id] = (hit.t as f32).next_up().min(f32::MAX);
        }
    }

    /// The ray of a pair in the space of the leaf's unit shape.
    pub(super) fn before_pair(&self, query: &Query<'_>, pair: &RayLeafPair<'_>) -> Ray {
        let id = pair.id as usize;
        let [origin, direction] = self.lines[id];
        let ray = Ray { origin, direction, ..self.ray(query, id).ray };
        let (_, ray) = query.root.follow(self.path_to(pair.trail).indices(), &ray);
        ray.through(&pair.leaf.unit_from_group)
    }

    /// Tests a leaf in f64.
    #[inline(never)]
    pub(super) fn test_in_f64(&mut self, query: &Query<'_>, pair: &RayLeafPair<'_>, start: RayStart) {
        let local = self.before_pair(query, pair);
        self.test_shape_in_f64(query, pair.id as usize, &TestedShape::of(query, pair), &local, start);
    }

    /// Tests a shape in f64 with the ray in its space.
    pub(super) fn test_shape_in_f64(
        &mut self,
        query: &Query<'_>,
        id: usize,
        tested: &TestedShape,
        local: &Ray,
        start: RayStart,
    ) {
        if let Some(t_max) = query.any_before {
            if tested.shape.occluded(local, start, t_max) {
                self.end(id, Outcome::Occluded);
            }
        } else if let Some(hit) = tested.shape.intersect(local, start) {
            self.take_exact(query, id, tested, hit, None);
        }
    }

    /// Takes the first hit of a ray on a shape, computed in f64, if it is closer than the nearest. `gradient` is that of N there,
    /// if it is known.
    pub(super) fn take_exact(
        &mut self,
        query: &Query<'_>,
        id: usize,
        tested: &TestedShape,
        hit: ShapeHit,
        gradient: Option<DVec3>,
    ) {
        let TestedShape { trail, child, primitive, .. } = *tested;
        let ShapeHit { t, leaving, point: unit_point } = hit;
        // Each ray keeps one hit.
        let kept = match self.outcomes[id] {
            Outcome::Hit(Nearest { precision: Precision::Exact(kept), .. }) => kept as usize,
            Outcome::Hit(_) | Outcome::Miss | Outcome::Occluded | Outcome::Unresolved => self.exact.len(),
        };
        if t < self.t_max(query, id) {
            let (path, scene) = (InstancePath::default(), query.scene.id);
            let hit = Hit { t, leaving, primitive, unit_point, unit_gradient: gradient, path, scene };
            match self.exact.get_mut(kept) {
                Some(exact) => *exact = hit,
                None => self.exact.push(hit),
            }
        }
        let precision = Precision::Exact(kept as u32);
        self.take(query, id, Nearest { t, error: (1e-12 * t) as f32, trail, child, precision });
    }

    /// Removes the trails that lead to no hit and to none of the groups in `open`, which get their new ids. Returns the
    /// number of those that remain. No ray may wait at a leaf.
    #[inline(never)]
    pub(super) fn compact_trails<'t>(&mut self, open: impl Iterator<Item = &'t mut TrailId>) -> usize {
        let Self { outcomes, trails, .. } = self;
        let mut ends: Vec<&mut TrailId> = open.collect();
        ends.extend(outcomes.iter_mut().filter_map(|outcome| match outcome {
            Outcome::Hit(nearest) => Some(&mut nearest.trail),
            Outcome::Miss | Outcome::Occluded | Outcome::Unresolved => None,
        }));
        let mut is_kept = vec![false; trails.len()];
        for end in &ends {
            let mut at = **end;
            while let Some(id) = at {
                if std::mem::replace(&mut is_kept[index(id)], true) {
                    break;
                }
                at = trails[index(id)].above;
            }
        }
        // A trail comes after the one above it.
        let mut new_ids: Vec<TrailId> = vec![None; trails.len()];
        let mut count = 0;
        for old in 0..trails.len() {
            if is_kept[old] {
                let Trail { above, instance } = trails[old];
                trails[count] = Trail { above: above.and_then(|id| new_ids[index(id)]), instance };
                count += 1;
                new_ids[old] = NonZeroU32::new(count as u32);
            }
        }
        trails.truncate(count);
        ends.into_iter().for_each(|end| *end = end.and_then(|id| new_ids[index(id)]));
        count
    }
}

fn index(id: NonZeroU32) -> usize {
    id.get() as usize - 1
}

/// A shape that a ray is tested against in f64.
pub(super) struct TestedShape {
    pub(super) trail: TrailId,
    pub(super) child: u32,
    pub(super) shape: Superquadric,
    /// The primitive to report.
    pub(super) primitive: u32,
}

impl TestedShape {
    /// The shape of a leaf.
    pub(super) fn of(query: &Query<'_>, pair: &RayLeafPair<'_>) -> Self {
        let RayLeafPair { trail, index: child, leaf, .. } = *pair;
        let shape = query.scene.primitives.unit_shape(leaf.primitive);
        Self { trail, child, shape, primitive: leaf.primitive }
    }
}
