//! Queries of many rays.

use std::cell::Cell;

use super::refine::{REFINED_TOGETHER, Refiner};
use super::table::Outcome;
use super::traverse::Stream;
use crate::ray::limits::Coarsened;
use crate::ray::query::{Hit, TraceRay};
use crate::scene::compiled::CompiledScene;
use crate::scene::group::Group;

/// The number of rays in a stream: as many as fit into a core's cache with their state. If the scene itself is larger than
/// the cache, longer lists are worth more, so the number grows with the scene.
fn rays_together(root: &Group) -> usize {
    (16 * root.nodes.len()).clamp(1 << 14, 1 << 17)
}

thread_local! {
    /// The refiner of the last query of this thread, with its memory.
    static REFINER: Cell<Option<Box<Refiner>>> = const { Cell::new(None) };
}

impl CompiledScene {
    /// The number of rays that are best traced together.
    pub(crate) fn rays_together(&self) -> usize {
        self.root.as_deref().map_or(1 << 14, rays_together)
    }

    /// The closest hit of each ray: the answers of [`CompiledScene::intersect`], computed together on one thread.
    pub fn intersect_many(&self, rays: &[TraceRay]) -> Vec<Option<Hit>> {
        self.intersect_many_counted(rays, &mut Coarsened::default())
    }

    /// [`CompiledScene::intersect_many`] that counts the rays whose work was bounded.
    pub fn intersect_many_counted(&self, rays: &[TraceRay], coarsened: &mut Coarsened) -> Vec<Option<Hit>> {
        self.intersect_others(rays, &[], coarsened)
    }

    /// [`CompiledScene::intersect_many_counted`] of the rays that `left_out` does not mark, which may be empty. The others get
    /// no hit.
    pub(crate) fn intersect_others(
        &self,
        rays: &[TraceRay],
        left_out: &[bool],
        coarsened: &mut Coarsened,
    ) -> Vec<Option<Hit>> {
        let mut hits = Vec::with_capacity(rays.len());
        self.append_hits(rays, left_out, coarsened, &mut hits);
        hits
    }

    /// [`CompiledScene::intersect_others`] that appends the hits to a list.
    pub(crate) fn append_hits(
        &self,
        rays: &[TraceRay],
        left_out: &[bool],
        coarsened: &mut Coarsened,
        hits: &mut Vec<Option<Hit>>,
    ) {
        let Some(root) = self.root.as_deref() else {
            hits.extend(rays.iter().map(|_| None));
            return;
        };
        let mut stream = Stream::new(self, root, None);
        let mut refiner = REFINER.take().unwrap_or_default();
        let together = rays_together(root);
        for (first, rays) in (0..).step_by(together).zip(rays.chunks(together)) {
            stream.run(rays, left_out.get(first..).unwrap_or_default());
            // A few rays at a time, so that each stays in the nearest cache.
            for (part, rays) in rays.chunks(REFINED_TOGETHER).enumerate() {
                refiner.refine(&stream, part * REFINED_TOGETHER, rays, hits);
            }
            coarsened.rays += stream.coarsened_count();
        }
        coarsened.rays += std::mem::take(&mut refiner.coarsened).rays;
        REFINER.set(Some(refiner));
    }

    /// Whether each ray hits any surface with 0 <= t < `t_max`: the answers of [`CompiledScene::occluded`], computed
    /// together on one thread.
    pub fn occluded_many(&self, rays: &[TraceRay], t_max: f64) -> Vec<bool> {
        self.occluded_many_counted(rays, t_max, &mut Coarsened::default())
    }

    /// [`CompiledScene::occluded_many`] that counts the rays whose work was bounded.
    pub fn occluded_many_counted(
        &self,
        rays: &[TraceRay],
        t_max: f64,
        coarsened: &mut Coarsened,
    ) -> Vec<bool> {
        let mut occluded = vec![false; rays.len()];
        let Some(root) = self.root.as_deref().filter(|_| !rays.is_empty()) else { return occluded };
        let (mut stream, together) = (Stream::new(self, root, Some(t_max)), rays_together(root));
        for (rays, occluded) in rays.chunks(together).zip(occluded.chunks_mut(together)) {
            stream.run(rays, &[]);
            for ((index, ray), occluded) in rays.iter().enumerate().zip(occluded) {
                *occluded = match stream.table().outcome(index) {
                    Outcome::Miss => false,
                    Outcome::Unresolved => self.occluded_counted(ray, t_max, false, coarsened),
                    Outcome::Occluded | Outcome::Hit(_) => true,
                };
            }
            coarsened.rays += stream.coarsened_count();
        }
        occluded
    }

    /// The number of rays that hit something: the work of [`CompiledScene::intersect_many`] without the refinement.
    #[cfg(feature = "bench")]
    pub(crate) fn find_many(&self, rays: &[TraceRay]) -> usize {
        let Some(root) = self.root.as_deref() else { return 0 };
        let (mut stream, mut count) = (Stream::new(self, root, None), 0);
        for rays in rays.chunks(rays_together(root)) {
            stream.run(rays, &[]);
            for (index, ray) in rays.iter().enumerate() {
                count += usize::from(match stream.table().outcome(index) {
                    Outcome::Miss | Outcome::Occluded => false,
                    Outcome::Hit(_) => true,
                    Outcome::Unresolved => self.intersect(ray).is_some(),
                });
            }
        }
        count
    }
}
