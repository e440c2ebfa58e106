//! The queues of rays at leaves.
//!
//! A ray at a leaf first waits for the test of the shape's own box, then for the solver, until the kernel has a full batch.
//! A ray that waits at many leaves may already have its closest hit in a queue, so it flushes the queues.

use superegg_geom::RayStart;
use superegg_geom::kernels::LanePowers;
use superegg_geom::kernels::stream::{
    END, ENTRY_LANES, EntryKind, STREAM_LANES, ShapeEntries, ShapeEntry, StreamHits, StreamLanes,
};
use superegg_geom::kernels::verify::{KnownCrossing, VerifyBatch};

use super::table::{DONE, Nearest, Outcome, Precision, Query, RayLeafPair, RayTable, TestedShape};
use superegg_simd::bits;

/// A ray that waits at more leaves flushes the queues.
const MOST_WAITS: u32 = 4;

/// A ray at the box of a shape.
#[derive(Clone, Copy)]
struct QueuedRay<'s> {
    pair: RayLeafPair<'s>,
    start: RayStart,
    /// The t where the ray enters the box.
    entry: f64,
    /// Converts a length in unit space to t.
    t_per_length: f64,
    /// For a ray that starts in the box, unless its search begins beyond the surface: the t where it leaves the box.
    exit: Option<f64>,
}

/// Rays that wait for the solver.
struct SolverQueue<'s> {
    lanes: StreamLanes,
    rays: Vec<QueuedRay<'s>>,
}

impl<'s> SolverQueue<'s> {
    fn new() -> Self {
        Self { lanes: StreamLanes::default(), rays: Vec::with_capacity(STREAM_LANES) }
    }

    #[inline(always)]
    fn push(&mut self, powers: LanePowers, approach: &ShapeEntry, is_inward: bool, ray: QueuedRay<'s>) {
        self.lanes.set(self.rays.len(), powers, approach, is_inward);
        self.rays.push(ray);
    }

    /// Whether the next batch of boxes might not fit.
    #[inline(always)]
    fn is_full(&self) -> bool {
        self.rays.len() > STREAM_LANES - ENTRY_LANES
    }
}

/// All rays that wait at leaves.
pub(super) struct LeafQueues<'s> {
    approaches: ShapeEntries,
    /// The rays that wait for the test of boxes.
    approaching: Vec<(RayLeafPair<'s>, RayStart)>,
    /// Rays that enter the box from outside.
    outside: SolverQueue<'s>,
    /// Rays that start in the box.
    inside: SolverQueue<'s>,
    /// Rays to shapes that are not convex.
    not_convex: SolverQueue<'s>,
    answers: StreamHits,
    /// Rays to shapes that are not convex whose answers are to be verified, by their lanes.
    verify: VerifyBatch,
    verified_lanes: Vec<usize>,
    /// Whether the queues are to be flushed.
    pub(super) must_flush: bool,
}

impl<'s> LeafQueues<'s> {
    pub(super) fn new() -> Self {
        Self {
            approaches: ShapeEntries::default(),
            approaching: Vec::with_capacity(ENTRY_LANES),
            outside: SolverQueue::new(),
            inside: SolverQueue::new(),
            not_convex: SolverQueue::new(),
            answers: StreamHits::default(),
            verify: VerifyBatch::default(),
            verified_lanes: Vec::with_capacity(STREAM_LANES),
            must_flush: false,
        }
    }

    pub(super) fn is_empty(&self) -> bool {
        let Self { approaching, outside, inside, not_convex, .. } = self;
        let is_waiting = |queue: &SolverQueue<'_>| !queue.rays.is_empty();
        approaching.is_empty() && ![outside, inside, not_convex].into_iter().any(is_waiting)
    }

    /// Adds a ray, by its index in the space of the leaf's group. Returns whether the queue is full.
    #[inline(always)]
    pub(super) fn push(
        &mut self,
        table: &mut RayTable,
        pair: RayLeafPair<'s>,
        start: RayStart,
        local_ray: usize,
    ) -> bool {
        if start == RayStart::SurfaceOutward && pair.leaf.lane_powers.is_some() {
            // A ray that leaves a convex shape does not hit it again.
            return false;
        }
        let (lane, id) = (self.approaching.len(), pair.id as usize);
        let t_max = f64::from(table.ends[id]);
        self.approaches.set(lane, &pair.leaf.unit_from_group, table.lines[local_ray], t_max);
        self.approaching.push((pair, start));
        let waits = &mut table.leaf_states[id].waits;
        *waits += 1;
        self.must_flush |= *waits > MOST_WAITS;
        self.must_flush || lane + 1 == ENTRY_LANES
    }

    /// Runs the kernels that have full batches, or all of them to flush. Returns whether the boxes were tested.
    #[inline(always)]
    pub(super) fn run(&mut self, query: &Query<'s>, table: &mut RayTable) -> bool {
        if !(self.must_flush || self.approaching.len() == ENTRY_LANES) {
            return false;
        }
        self.test_boxes(query, table);
        if self.must_flush || self.outside.is_full() {
            self.solve_outside(query, table);
        }
        if self.must_flush || self.inside.is_full() {
            self.solve_inside(query, table);
        }
        if self.must_flush || self.not_convex.is_full() {
            self.solve_not_convex(query, table);
        }
        self.must_flush = false;
        true
    }

    /// Tests the boxes of shapes, and passes the rays that hit on to the solver.
    #[inline(always)]
    fn test_boxes(&mut self, query: &Query<'s>, table: &mut RayTable) {
        self.approaches.run();
        // Misses are unpredictable, so they are counted without a branch.
        let mut arrived = 0u32;
        for (lane, (pair, _)) in self.approaching.iter().enumerate() {
            let id = pair.id as usize;
            let arrives = (self.approaches.kind(lane) != EntryKind::Misses) & (table.ends[id] != DONE);
            table.leaf_states[id].waits -= u32::from(!arrives);
            arrived |= u32::from(arrives) << lane;
        }
        for lane in bits(arrived) {
            let (pair, start) = self.approaching[lane];
            let kind = self.approaches.kind(lane);
            let is_inside = kind == EntryKind::Inside;
            // The one hit of a ray that goes into the shape is its exit.
            let is_inward = start == RayStart::SurfaceInward && is_inside && query.any_before.is_none();
            let is_on_surface = start != RayStart::Free;
            // The search of a shape that is not convex begins beyond the surface.
            let skips_start = is_on_surface && pair.leaf.lane_powers.is_none();
            let is_outward = start == RayStart::SurfaceOutward && is_inside;
            let is_solvable = !is_on_surface || is_inward || (skips_start && is_outward);
            let approach = self.approaches.get(lane);
            let approach = if skips_start { approach.beyond_surface() } else { Some(approach) };
            let Some(approach) = approach.filter(|_| is_solvable && kind != EntryKind::Unresolved) else {
                table.leaf_states[pair.id as usize].waits -= 1;
                table.test_in_f64(query, &pair, start);
                continue;
            };
            let ShapeEntry { t_entry: entry, t_per_s: t_per_length, length, .. } = approach;
            // The side of a ray beyond the surface is known.
            let may_exit = is_inside && !skips_start;
            let exit = may_exit.then_some(entry + f64::from(length) * t_per_length);
            let ray = QueuedRay { pair, start, entry, t_per_length, exit };
            match pair.leaf.lane_powers {
                None => {
                    let shape = query.scene.primitives.unit_shape(pair.leaf.primitive);
                    self.not_convex.push(LanePowers::of_any(&shape), &approach, is_inward, ray);
                }
                // Occlusion does not depend on whether the ray starts in the box.
                Some(powers) if is_inside && query.any_before.is_none() => {
                    self.inside.push(powers, &approach, is_inward, ray);
                }
                Some(powers) => self.outside.push(powers, &approach, false, ray),
            }
        }
        self.approaching.clear();
    }

    #[inline(always)]
    fn solve_outside(&mut self, query: &Query<'s>, table: &mut RayTable) {
        let count = self.outside.rays.len();
        self.outside.lanes.clear_from(count);
        if query.any_before.is_some() {
            self.outside.lanes.occluded(count, &mut self.answers);
        } else {
            self.outside.lanes.intersect(count, &mut self.answers);
        }
        for lane in bits(end_waits(table, &self.outside.rays, &self.answers)) {
            let ray = &self.outside.rays[lane];
            match query.any_before {
                // Facts to be verified have only rays that start on a shape that is not convex.
                Some(t_max) => _ = take_occlusion(query, table, &self.answers, lane, ray, t_max),
                None => take_hit(query, table, &self.answers, lane, ray, false),
            }
        }
        self.outside.rays.clear();
    }

    #[inline(always)]
    fn solve_inside(&mut self, query: &Query<'s>, table: &mut RayTable) {
        let count = self.inside.rays.len();
        if count == 0 {
            return;
        }
        self.inside.lanes.clear_from(count);
        self.inside.lanes.intersect_from_inside(count, &mut self.answers);
        for lane in bits(end_waits(table, &self.inside.rays, &self.answers)) {
            let leaving = self.answers.leaving >> lane & 1 == 1;
            take_hit(query, table, &self.answers, lane, &self.inside.rays[lane], leaving);
        }
        self.inside.rays.clear();
    }

    /// Rays that certainly miss are done; hits are verified in f64.
    #[inline(always)]
    fn solve_not_convex(&mut self, query: &Query<'s>, table: &mut RayTable) {
        let Self { not_convex: SolverQueue { lanes, rays }, answers, verify, verified_lanes, .. } = self;
        if rays.is_empty() {
            return;
        }
        lanes.clear_from(rays.len());
        if query.any_before.is_some() {
            lanes.enters(rays.len(), answers);
        } else {
            lanes.isolate(rays.len(), answers);
        }
        // The first stretch of rays that start on the shape is not known.
        let on_surface = rays.iter().rev();
        let on_surface = on_surface.fold(0, |mask, ray| mask << 1 | u32::from(ray.start != RayStart::Free));
        for lane in bits(end_waits(table, rays, answers) | on_surface) {
            let ray = &rays[lane];
            let known = match query.any_before {
                Some(t_max) => take_occlusion(query, table, answers, lane, ray, t_max),
                None => isolated(query, table, answers, lane, ray),
            };
            if let Some(known) = known {
                let shape = query.scene.primitives.unit_shape(ray.pair.leaf.primitive);
                verify.push(&shape, &table.before_pair(query, &ray.pair), ray.start, &known);
                verified_lanes.push(lane);
            }
        }
        verify.run();
        for (number, &lane) in verified_lanes.iter().enumerate() {
            let ray = &rays[lane];
            match verify.get(number) {
                Some(None) => {}
                Some(Some((hit, gradient))) => {
                    let tested = TestedShape::of(query, &ray.pair);
                    table.take_exact(query, ray.pair.id as usize, &tested, hit, gradient);
                }
                None => table.test_in_f64(query, &ray.pair, ray.start),
            }
        }
        verify.clear();
        verified_lanes.clear();
        rays.clear();
    }
}

/// Ends the wait of solved rays. Returns a mask of those that hit or are unresolved.
#[inline(always)]
fn end_waits(table: &mut RayTable, rays: &[QueuedRay<'_>], answers: &StreamHits) -> u32 {
    for ray in rays {
        table.leaf_states[ray.pair.id as usize].waits -= 1;
    }
    answers.found | answers.unresolved
}

/// Takes the closest hit of a lane.
#[inline(always)]
fn take_hit<'s>(
    query: &Query<'s>,
    table: &mut RayTable,
    answers: &StreamHits,
    lane: usize,
    ray: &QueuedRay<'s>,
    leaving: bool,
) {
    let length = answers.s[lane];
    let id = ray.pair.id as usize;
    let t = ray.entry + f64::from(length) * ray.t_per_length;
    let error = f64::from(answers.error[lane]) * ray.t_per_length;
    let error = (error as f32).next_up();
    if answers.unresolved >> lane & 1 == 1 {
        // A grazing ray, which may be behind the nearest hit, or one that starts on the surface.
        if ray.exit.is_some() || t - f64::from(error) < table.t_max(query, id) {
            table.test_in_f64(query, &ray.pair, ray.start);
        }
        return;
    }
    if length < f32::INFINITY {
        let RayLeafPair { trail, index: child, .. } = ray.pair;
        let precision = Precision::Approximate { leaving };
        table.take(query, id, Nearest { t, error, trail, child, precision });
    }
}

/// The facts about the closest hit of a lane, to be verified. A hit behind another one is left out, but not the stretch beside the
/// surface on which a ray starts. A lane that is unresolved is tested in f64.
#[inline(always)]
fn isolated<'s>(
    query: &Query<'s>,
    table: &mut RayTable,
    answers: &StreamHits,
    lane: usize,
    ray: &QueuedRay<'s>,
) -> Option<KnownCrossing> {
    if answers.unresolved >> lane & 1 == 1 {
        table.test_in_f64(query, &ray.pair, ray.start);
        return None;
    }
    let t_at = |s: f32| ray.entry + f64::from(s) * ray.t_per_length;
    let (s, error) = (answers.s[lane], answers.error[lane]);
    let between = s.is_finite().then(|| [t_at(s - error), t_at(s)]);
    let t_max = table.t_max(query, ray.pair.id as usize);
    let between = between.filter(|&[first, _]| first < t_max);
    // The first stretch of a ray that starts on the shape may have a crossing before the other hit.
    let is_needed = between.is_some() || ray.start != RayStart::Free;
    is_needed.then_some(KnownCrossing { clear_from: ray.entry, between })
}

/// Takes the occlusion of a lane, by a hit before `t_max`. Returns the facts that remain to be verified.
#[inline(always)]
fn take_occlusion<'s>(
    query: &Query<'s>,
    table: &mut RayTable,
    answers: &StreamHits,
    lane: usize,
    ray: &QueuedRay<'s>,
    t_max: f64,
) -> Option<KnownCrossing> {
    let id = ray.pair.id as usize;
    if table.ends[id] == DONE {
        return None;
    }
    let length = answers.s[lane];
    let is_unresolved = answers.unresolved >> lane & 1 == 1;
    if length == f32::INFINITY && !is_unresolved && ray.start != RayStart::Free {
        return Some(KnownCrossing { clear_from: ray.entry, between: None });
    }
    // The kernel finds a point inside the shape. A ray from outside hits the shape before; one that starts inside hits it
    // where it leaves.
    let t = ray.exit.unwrap_or(ray.entry + f64::from(length) * ray.t_per_length);
    if length < f32::INFINITY && t < t_max * (1.0 - END) && t > 0.0 {
        table.end(id, Outcome::Occluded);
    } else if length < f32::INFINITY || is_unresolved {
        table.test_in_f64(query, &ray.pair, ray.start);
    }
    None
}
