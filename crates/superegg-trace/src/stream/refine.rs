//! The refinement of f32 hits in f64.

use superegg_geom::glam::DVec3;
use superegg_geom::kernels::refine::{RefineBatch, RefineRay, refine_powers};
use superegg_geom::{Ray, ShapeHit, scale_to_unit};

use super::table::{Outcome, Precision};
use super::traverse::Stream;
use crate::ray::limits::Coarsened;
use crate::ray::query::{Hit, TraceRay};
use crate::scene::compiled::CompiledScene;
use crate::scene::group::Leaf;

/// The number of rays whose hits are refined together.
pub(super) const REFINED_TOGETHER: usize = 128;

/// Refines hits, with memory for one batch after the other.
#[derive(Default)]
pub(super) struct Refiner {
    batch: RefineBatch,
    /// The primitive of each hit in the batch.
    primitives: Vec<u32>,
    /// The rays that were traced in f64 with bounded work.
    pub(super) coarsened: Coarsened,
}

impl Refiner {
    /// Appends the hits of `rays`, which are those of a stream's last run from index `first` on.
    pub(super) fn refine(
        &mut self,
        stream: &Stream<'_>,
        first: usize,
        rays: &[TraceRay],
        hits: &mut Vec<Option<Hit>>,
    ) {
        let (table, query) = (stream.table(), stream.query());
        let scene = query.scene;
        for (index, traced) in (first..).zip(rays) {
            let Outcome::Hit(nearest) = table.outcome(index) else { continue };
            if let Precision::Approximate { leaving } = nearest.precision {
                let Some((direction, _)) = scale_to_unit(traced.ray.direction) else { continue };
                let ray = Ray::new(traced.ray.origin, direction);
                let (leaf, ray) = table.before_leaf(query, nearest, &ray);
                self.push(scene, leaf, &ray, nearest.t, leaving);
            }
        }
        self.batch.run();
        let mut refined_before = 0;
        let coarsened = &mut self.coarsened;
        hits.extend((first..).zip(rays).map(|(index, traced)| {
            let nearest = match table.outcome(index) {
                Outcome::Miss | Outcome::Occluded => return None,
                Outcome::Unresolved => return scene.intersect_counted(traced, false, coarsened),
                Outcome::Hit(nearest) => nearest,
            };
            // Converts t to lengths of the given direction.
            let (_, scale) = scale_to_unit(traced.ray.direction)?;
            let path = table.path(nearest);
            let leaving = match nearest.precision {
                Precision::Exact(kept) => {
                    return Some(Hit { t: nearest.t * scale, path, ..table.exact[kept as usize].clone() });
                }
                Precision::Approximate { leaving } => leaving,
            };
            let number = refined_before;
            refined_before += 1;
            let refined = self.batch.get(number).map(|(ShapeHit { t, point, .. }, gradient)| {
                (if leaving { 2.0 * nearest.t - t } else { t }, point, gradient)
            });
            // If the refined t is outside the error bound, another shape may be closer.
            match refined.filter(|(t, ..)| (t - nearest.t).abs() <= f64::from(nearest.error)) {
                Some((t, unit_point, gradient)) => Some(Hit {
                    t: t * scale,
                    leaving,
                    primitive: self.primitives[number],
                    unit_point,
                    unit_gradient: (gradient != DVec3::ZERO).then_some(gradient),
                    path,
                    scene: scene.id,
                }),
                None => scene.intersect_counted(traced, false, coarsened),
            }
        }));
        self.batch.clear();
        self.primitives.clear();
    }

    /// Adds a hit to the batch.
    #[inline(always)]
    fn push(&mut self, scene: &CompiledScene, leaf: &Leaf, ray: &Ray, t: f64, leaving: bool) {
        let Ray { origin, direction, .. } = *ray;
        let powers = refine_powers(&scene.primitives.unit_shape(leaf.primitive));
        self.primitives.push(leaf.primitive);
        self.batch.push(&if leaving {
            // The exit is the first hit of the reversed ray.
            RefineRay { origin: origin + 2.0 * t * direction, direction: -direction, t, powers }
        } else {
            RefineRay { origin, direction, t, powers }
        });
    }
}
