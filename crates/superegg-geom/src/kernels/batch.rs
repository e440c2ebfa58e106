//! Many rays against one convex shape: stream kernels for the candidates, refinement in f64 for the crossings.
//!
//! [`crate::Superquadric::intersect_batch`] for convex shapes. t agrees with the scalar path to 1e-12 (1 + t); only the
//! rounding of f64 decides between hit and miss where the two differ.

use glam::DVec3;
use superegg_simd::{Arch, Simd, WithSimd, bits};

use super::LanePowers;
use super::refine::{RefineBatch, RefineRay, refine_powers};
use super::stream::{
    ENTRY_LANES, EntryKind, STREAM_LANES, ShapeEntries, ShapeEntry, StreamHits, StreamLanes,
};
use crate::math::numeric::scale_to_unit;
use crate::math::ray::{Ray, RayStart};
use crate::shape::ShapeHit;
use crate::superquadric::Convex;

/// The first crossing of each ray with the shape, in the order of the rays. Replaces the contents of `hits`.
///
/// The same as [`crate::Superquadric::intersect`] with [`RayStart::Free`] but for rounding. A ray that f32 does not resolve,
/// or that has an origin error, is intersected by that method.
pub fn intersect(shape: &Convex, rays: &[Ray], hits: &mut Vec<Option<ShapeHit>>) {
    hits.clear();
    hits.resize(rays.len(), None);
    let arch = Arch::new();
    arch.dispatch(BatchKernel { arch, shape, rays, hits });
}

/// A ray in the space of the unit shape.
#[derive(Clone, Copy)]
struct UnitRay {
    /// The index of the ray.
    index: usize,
    origin: DVec3,
    /// Its largest coordinate is in [1, 2).
    direction: DVec3,
    /// Converts t of this ray to t of the original one.
    t_scale: f64,
}

/// A ray that waits for its search.
#[derive(Clone, Copy)]
struct Queued {
    ray: UnitRay,
    t_entry: f64,
    t_per_s: f64,
}

/// A crossing that waits for its refinement.
#[derive(Clone, Copy)]
struct Found {
    ray: UnitRay,
    t: f64,
    error: f64,
    leaving: bool,
}

/// Rays that are searched together, all from outside of their box or all from inside.
struct Queue {
    lanes: StreamLanes,
    rays: Vec<Queued>,
}

impl Queue {
    fn new(arch: Arch) -> Self {
        Self { lanes: StreamLanes::new(arch), rays: Vec::with_capacity(STREAM_LANES) }
    }

    #[inline(always)]
    fn push(&mut self, powers: LanePowers, entry: &ShapeEntry, ray: UnitRay) {
        self.lanes.set(self.rays.len(), powers, entry, false);
        self.rays.push(Queued { ray, t_entry: entry.t_entry, t_per_s: entry.t_per_s });
    }
}

struct BatchKernel<'a> {
    arch: Arch,
    shape: &'a Convex,
    rays: &'a [Ray],
    hits: &'a mut [Option<ShapeHit>],
}

impl WithSimd for BatchKernel<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let powers = LanePowers::of(self.shape);
        let mut search = Search {
            outside: Queue::new(self.arch),
            inside: Queue::new(self.arch),
            kernel: self,
            answers: StreamHits::default(),
            refine: RefineBatch::default(),
            found: Vec::new(),
        };
        let mut entries = ShapeEntries::default();
        let mut group = Vec::with_capacity(ENTRY_LANES);
        for index in 0..search.kernel.rays.len() {
            match search.unit_ray(index) {
                Some(ray) => {
                    entries.set_unit(group.len(), ray.origin, ray.direction, f64::INFINITY);
                    group.push(ray);
                }
                None => search.intersect_scalar(index),
            }
            if group.len() == ENTRY_LANES {
                search.enter(powers, &mut entries, &mut group);
            }
        }
        search.enter(powers, &mut entries, &mut group);
        search.search_outside();
        search.search_inside();
        search.refine();
    }
}

/// Crossings that are refined together, so that they stay in the nearest cache.
const REFINED_TOGETHER: usize = 128;

struct Search<'a> {
    kernel: BatchKernel<'a>,
    outside: Queue,
    inside: Queue,
    answers: StreamHits,
    refine: RefineBatch,
    found: Vec<Found>,
}

impl Search<'_> {
    /// A ray in unit space; `None` where only the scalar path takes it.
    #[inline(always)]
    fn unit_ray(&self, index: usize) -> Option<UnitRay> {
        let BatchKernel { shape, rays, .. } = &self.kernel;
        let ray = &rays[index];
        let inv_radii = shape.radii().recip();
        let (direction, first_scale) = scale_to_unit(ray.direction)?;
        let (direction, second_scale) = scale_to_unit(direction * inv_radii)?;
        let origin = ray.origin * inv_radii;
        (ray.origin_error == 0.0 && origin.is_finite()).then_some(UnitRay {
            index,
            origin,
            direction,
            t_scale: first_scale * second_scale,
        })
    }

    #[inline(never)]
    fn intersect_scalar(&mut self, index: usize) {
        let BatchKernel { shape, rays, hits, .. } = &mut self.kernel;
        hits[index] = shape.intersect(&rays[index], RayStart::Free);
    }

    /// Maps the rays of a group to the box, and queues those that hit it.
    #[inline(always)]
    fn enter(&mut self, powers: LanePowers, entries: &mut ShapeEntries, group: &mut Vec<UnitRay>) {
        entries.run();
        for (lane, &ray) in group.iter().enumerate() {
            match entries.kind(lane) {
                EntryKind::Misses => {}
                EntryKind::Enters => {
                    self.outside.push(powers, &entries.get(lane), ray);
                    if self.outside.rays.len() == STREAM_LANES {
                        self.search_outside();
                    }
                }
                EntryKind::Inside => {
                    self.inside.push(powers, &entries.get(lane), ray);
                    if self.inside.rays.len() == STREAM_LANES {
                        self.search_inside();
                    }
                }
                EntryKind::Unresolved => self.intersect_scalar(ray.index),
            }
        }
        group.clear();
        if self.found.len() >= REFINED_TOGETHER {
            self.refine();
        }
    }

    #[inline(always)]
    fn search_outside(&mut self) {
        let count = self.outside.rays.len();
        self.outside.lanes.clear_from(count);
        self.outside.lanes.intersect(count, &mut self.answers);
        let rays = std::mem::take(&mut self.outside.rays);
        self.outside.rays = self.take_answers(rays);
    }

    #[inline(always)]
    fn search_inside(&mut self) {
        let count = self.inside.rays.len();
        self.inside.lanes.clear_from(count);
        self.inside.lanes.intersect_from_inside(count, &mut self.answers);
        let rays = std::mem::take(&mut self.inside.rays);
        self.inside.rays = self.take_answers(rays);
    }

    /// Queues the crossings that were found for refinement. Returns the empty queue of rays.
    #[inline(always)]
    fn take_answers(&mut self, mut rays: Vec<Queued>) -> Vec<Queued> {
        let powers = refine_powers(self.kernel.shape);
        for lane in bits(self.answers.found | self.answers.unresolved) {
            let Some(&Queued { ray, t_entry, t_per_s }) = rays.get(lane) else { continue };
            if self.answers.unresolved >> lane & 1 == 1 {
                self.intersect_scalar(ray.index);
                continue;
            }
            let leaving = self.answers.leaving >> lane & 1 == 1;
            let t = t_entry + f64::from(self.answers.s[lane]) * t_per_s;
            let error = f64::from(self.answers.error[lane]) * t_per_s;
            let UnitRay { origin, direction, .. } = ray;
            self.refine.push(&if leaving {
                // An exit is the first crossing of the reversed ray, which starts as far beyond it.
                RefineRay { origin: origin + 2.0 * t * direction, direction: -direction, t, powers }
            } else {
                RefineRay { origin, direction, t, powers }
            });
            self.found.push(Found { ray, t, error, leaving });
        }
        rays.clear();
        rays
    }

    /// Refines the crossings that were found. Where the correction is larger than the bound the scalar path decides.
    #[inline(always)]
    fn refine(&mut self) {
        self.refine.run();
        for i in 0..self.found.len() {
            let Found { ray, t, error, leaving } = self.found[i];
            match self.refine.get(i).filter(|(hit, _)| (hit.t - t).abs() <= error) {
                Some((hit, _)) => {
                    let t = if leaving { 2.0 * t - hit.t } else { hit.t };
                    let point = hit.point * self.kernel.shape.radii();
                    self.kernel.hits[ray.index] =
                        Some(ShapeHit { t: (t * ray.t_scale).max(0.0), point, leaving });
                }
                None => self.intersect_scalar(ray.index),
            }
        }
        self.found.clear();
        self.refine.clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shape::Exponents;
    use crate::superquadric::Superquadric;

    #[test]
    fn one_lane_and_many_give_the_scalar_answers() {
        let radii = DVec3::new(1.0, 2.0, 0.5);
        for (e, n) in [(1.0, 1.0), (2.0, 2.0), (0.3, 1.7), (0.001, 0.5), (1.0, 0.2), (2.0, 1.0)] {
            let shape = Superquadric::new(radii, Exponents::new(e, n).unwrap()).unwrap();
            let convex = shape.as_convex().unwrap();
            // Not a multiple of any number of lanes.
            let rays: Vec<Ray> = (0..3001)
                .map(|i| {
                    let angle = f64::from(i) * 0.7;
                    let origin = DVec3::new(angle.sin(), (1.3 * angle).cos(), (0.6 * angle).sin())
                        * (0.5 + f64::from(i % 7));
                    Ray::new(origin, DVec3::new(0.3, 0.2, 0.1) * angle.cos() - origin)
                })
                .collect();
            let (mut many, mut one) = (Vec::new(), vec![None; rays.len()]);
            intersect(&convex, &rays, &mut many);
            let arch = Arch::Scalar;
            arch.dispatch(BatchKernel { arch, shape: &convex, rays: &rays, hits: &mut one });
            let mut hit_count = 0;
            for (i, ray) in rays.iter().enumerate() {
                let exact = shape.intersect(ray, RayStart::Free);
                hit_count += usize::from(exact.is_some());
                for hit in [many[i], one[i]] {
                    assert_eq!(hit.map(|hit| hit.leaving), exact.map(|hit| hit.leaving), "{e} {n} {ray:?}");
                    if let (Some(hit), Some(exact)) = (hit, exact) {
                        assert!(
                            (hit.t - exact.t).abs() < 1e-9 * (1.0 + exact.t),
                            "{e} {n} {hit:?} {exact:?}"
                        );
                    }
                }
            }
            assert!(hit_count > 1500, "{hit_count}");
        }
    }
}
