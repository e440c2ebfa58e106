//! Rays of packets against a shape that is not convex: the kernels of streams isolate the first crossings, which are then
//! computed in f64.

use arrayvec::ArrayVec;
use superegg_geom::kernels::LanePowers;
use superegg_geom::kernels::stream::{
    ENTRY_LANES, EntryKind, STREAM_LANES, ShapeEntries, ShapeEntry, StreamHits, StreamLanes,
};
use superegg_geom::kernels::verify::{KnownCrossing, VerifyBatch};
use superegg_geom::{Ray, RayStart, Superquadric};
use superegg_simd::bits;

/// A ray in the space of the unit shape.
#[derive(Clone, Copy)]
pub(super) struct LocalRay {
    /// The packet and the lane.
    pub(super) index: [usize; 2],
    pub(super) ray: Ray,
    /// No crossing beyond this t counts.
    pub(super) t_max: f64,
}

/// Memory for the kernels.
#[derive(Default)]
pub(super) struct Isolation {
    entries: ShapeEntries,
    lanes: StreamLanes,
    answers: StreamHits,
    verify: VerifyBatch,
    /// The rays that wait for the search.
    queued: ArrayVec<(LocalRay, ShapeEntry), STREAM_LANES>,
    /// The rays that wait for the verification.
    isolated: ArrayVec<LocalRay, STREAM_LANES>,
}

impl Isolation {
    /// The first crossings of free rays, by packet, lane and t. Those of other rays may be left out if they are beyond the rays' ends.
    pub(super) fn intersect(
        &mut self,
        shape: &Superquadric,
        rays: &[LocalRay],
        mut take: impl FnMut([usize; 2], f64),
    ) {
        let powers = LanePowers::of_any(shape);
        let in_f64 = |ray: &LocalRay| shape.intersect(&ray.ray, RayStart::Free).map(|hit| hit.t);
        for rays in rays.chunks(ENTRY_LANES) {
            for (lane, LocalRay { ray, t_max, .. }) in rays.iter().enumerate() {
                self.entries.set_unit(lane, ray.origin, ray.direction, *t_max);
            }
            self.entries.run();
            for (lane, ray) in rays.iter().enumerate() {
                match self.entries.kind(lane) {
                    EntryKind::Misses => {}
                    EntryKind::Enters => {
                        let entry = self.entries.get(lane);
                        self.lanes.set(self.queued.len(), powers, &entry, false);
                        self.queued.push((*ray, entry));
                    }
                    EntryKind::Inside | EntryKind::Unresolved => {
                        in_f64(ray).into_iter().for_each(|t| take(ray.index, t));
                    }
                }
            }
            if self.queued.len() > STREAM_LANES - ENTRY_LANES {
                self.solve(shape, &in_f64, &mut take);
            }
        }
        self.solve(shape, &in_f64, &mut take);
    }

    /// Searches the rays that wait.
    fn solve(
        &mut self,
        shape: &Superquadric,
        in_f64: &impl Fn(&LocalRay) -> Option<f64>,
        take: &mut impl FnMut([usize; 2], f64),
    ) {
        let Self { lanes, answers, verify, queued, isolated, .. } = self;
        lanes.clear_from(queued.len());
        lanes.isolate(queued.len(), answers);
        for lane in bits(answers.found | answers.unresolved) {
            let (ray, entry) = &queued[lane];
            if answers.unresolved >> lane & 1 == 1 {
                in_f64(ray).into_iter().for_each(|t| take(ray.index, t));
                continue;
            }
            let t_at = |s: f32| entry.t_entry + f64::from(s) * entry.t_per_s;
            let s = answers.s[lane];
            let between = Some([t_at(s - answers.error[lane]), t_at(s)]);
            verify.push(shape, &ray.ray, RayStart::Free, &KnownCrossing { clear_from: 0.0, between });
            isolated.push(*ray);
        }
        verify.run();
        for (index, ray) in isolated.iter().enumerate() {
            let t = match verify.get(index) {
                Some(verified) => verified.map(|(hit, _)| hit.t),
                None => in_f64(ray),
            };
            t.into_iter().for_each(|t| take(ray.index, t));
        }
        verify.clear();
        queued.clear();
        isolated.clear();
    }
}
