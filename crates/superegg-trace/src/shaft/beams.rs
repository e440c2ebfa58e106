//! Rays that leave one surface together. One search finds the few shapes that they may hit, often none.

use std::cell::Cell;

use superegg_geom::Aabb;
use superegg_geom::glam::DVec3;

use super::first_hits::{FirstHit, FirstHits};
use super::hull::Shaft;
use super::index_groups::IndexGroups;
use super::occluders::{Occluder, ShaftStart};
use super::occlusion::ShaftRays;
use crate::ray::footprint::Footprint;
use crate::ray::limits::Coarsened;
use crate::ray::query::{Hit, Side, SurfaceStart, TraceRay};
use crate::scene::compiled::CompiledScene;
use crate::scene::path::InstancePath;

/// The most rays of a group.
const NEIGHBOURS: usize = 64;
/// Rays are tested one by one against no more shapes than this.
const MOST_TESTED: usize = 4;
/// A stream costs more than so few rays.
const FEW_RAYS: usize = 3;
/// Smaller groups cost more than their rays.
const LEAST_GROUP: usize = 4;

/// Rays from the points of one box along the unit directions in another.
#[derive(Clone, Copy, Debug)]
pub struct RayBeam<'p> {
    /// Holds the origins, with their rounding errors.
    pub origins: Aabb,
    /// Holds the directions, which have unit length.
    pub directions: Aabb,
    /// The instance whose surface all rays leave outwards.
    pub own: Option<&'p InstancePath>,
    /// The largest width of a ray.
    pub footprint: Footprint,
}

/// The shapes that the rays of a beam may hit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BeamHits {
    /// No ray hits anything.
    None,
    /// The shapes that were found; no ray hits any other.
    Found,
    /// Many, or shapes that are not known.
    Unknown,
}

impl CompiledScene {
    /// The shapes that the rays of a beam may hit; with [`BeamHits::Found`] they are in `found`.
    pub fn beam_hits(&self, beam: &RayBeam<'_>, found: &mut Vec<Occluder>) -> BeamHits {
        let RayBeam { origins, directions, own, footprint } = *beam;
        if !(origins.min.is_finite() && origins.max.is_finite() && directions.min.is_finite()) {
            return BeamHits::Unknown;
        }
        let width = footprint.at(self.reach_from(&origins));
        let shaft = Shaft::along(&origins, &directions);
        match self.find_occluders(&shaft, ShaftStart { own, width }, found) {
            true if found.is_empty() => BeamHits::None,
            true => BeamHits::Found,
            false => BeamHits::Unknown,
        }
    }

    /// [`CompiledScene::intersect_many_counted`] for rays of which neighbours are alike, such as reflected rays: groups that
    /// leave one surface are tested against the few shapes in their beam.
    pub fn intersect_alike(&self, rays: &[TraceRay], coarsened: &mut Coarsened) -> Vec<Option<Hit>> {
        let mut beams = BEAMS.take().unwrap_or_default();
        beams.is_known.clear();
        beams.is_known.resize(rays.len(), false);
        for group in IndexGroups::of(rays.iter().map(start_of), NEIGHBOURS).groups() {
            beams.test(self, rays, group);
        }
        let Beams { is_known, hits: known, .. } = &mut *beams;
        let unknown = is_known.iter().filter(|&&is_known| !is_known).count();
        let mut hits = if unknown > FEW_RAYS {
            self.intersect_others(rays, is_known, coarsened)
        } else {
            let rays = rays.iter().zip(&*is_known);
            let trace = |(ray, &is_known): (&TraceRay, &bool)| {
                if is_known { None } else { self.intersect_counted(ray, false, coarsened) }
            };
            rays.map(trace).collect()
        };
        for (index, hit) in known.drain(..) {
            hits[index] = Some(hit);
        }
        BEAMS.set(Some(beams));
        hits
    }
}

/// The surface that a ray leaves outwards, if any. `None` for a ray that goes into its shape.
fn start_of(ray: &TraceRay) -> Option<Option<&InstancePath>> {
    match &ray.start {
        Some(SurfaceStart { side: Side::Inward, .. }) => None,
        Some(SurfaceStart { side: Side::Outward, path }) => Some(Some(path)),
        None => Some(None),
    }
}

/// The rays that beams have decided, with memory for one beam after the other.
#[derive(Default)]
struct Beams {
    found: Vec<Occluder>,
    columns: ShaftRays,
    first_hits: FirstHits,
    /// The rays whose hits, or misses, are known.
    is_known: Vec<bool>,
    /// The hits, with the indices of their rays.
    hits: Vec<(usize, Hit)>,
}

thread_local! {
    /// The memory of the last beams of this thread.
    static BEAMS: Cell<Option<Box<Beams>>> = const { Cell::new(None) };
}

impl Beams {
    /// Tests rays with one start against the shapes in their beam, if these are few.
    fn test(&mut self, scene: &CompiledScene, rays: &[TraceRay], group: &[usize]) {
        let Some(&first) = group.first().filter(|_| group.len() >= LEAST_GROUP) else { return };
        let (mut origins, mut directions) = (EMPTY, EMPTY);
        let (mut width, mut spread) = (0.0f64, 0.0f64);
        for &index in group {
            let TraceRay { ray, footprint, .. } = &rays[index];
            // A group of rays of very different lengths of direction would have a wide box.
            let direction = ray.direction.normalize_or_zero();
            origins = origins.union(&Aabb::around(ray.origin, DVec3::splat(ray.origin_error)));
            directions = directions.union(&Aabb { min: direction, max: direction });
            width = width.max(footprint.width);
            spread = spread.max(footprint.spread / ray.direction.length());
        }
        let beam = RayBeam {
            origins,
            directions: Aabb { min: directions.min - ROUNDING, max: directions.max + ROUNDING },
            own: rays[first].start.as_ref().map(|start| &start.path),
            footprint: Footprint { width, spread },
        };
        match scene.beam_hits(&beam, &mut self.found) {
            BeamHits::None => group.iter().for_each(|&index| self.is_known[index] = true),
            BeamHits::Found if self.found.len() <= MOST_TESTED => self.test_each(scene, rays, group),
            BeamHits::Found | BeamHits::Unknown => {}
        }
    }

    /// Tests each ray against the shapes that were found.
    fn test_each(&mut self, scene: &CompiledScene, rays: &[TraceRay], group: &[usize]) {
        let Self { found, columns, first_hits, is_known, hits } = self;
        columns.clear();
        group.iter().for_each(|&index| columns.push(&rays[index].ray));
        scene.first_hits(found, columns, first_hits);
        for (&index, hit) in group.iter().zip(first_hits.found.drain(..)) {
            is_known[index] = !matches!(hit, FirstHit::Unknown);
            if let FirstHit::Hit(hit) = hit {
                hits.push((index, hit));
            }
        }
    }
}

const EMPTY: Aabb = Aabb { min: DVec3::INFINITY, max: DVec3::NEG_INFINITY };
/// More than the rounding of a unit direction.
const ROUNDING: DVec3 = DVec3::splat(1e-15);

#[cfg(test)]
mod tests {
    use superegg_geom::{Ray, RayStart, SplitMix};
    use superegg_lang::load_text;

    use super::*;

    #[test]
    fn mirrored_rays_hit_what_each_hits_alone() {
        let mut random = SplitMix::new(31);
        let (mut hit, mut missed) = (0, 0);
        for case in 0..60 {
            let mut text =
                String::from("prm plate\ncoeff 5 5 .2\nexp .4 .1\nobj all\nap plate\nxs 0 0 -.2\n");
            for shape in 0..case % 7 {
                let mut number = |least: f64, most: f64| least + (most - least) * random.unit();
                let (e, n, size) = (number(0.05, 2.2), number(0.05, 2.0), number(0.2, 1.0));
                let (x, y, angle) = (number(-3.0, 3.0), number(-3.0, 3.0), number(0.0, 360.0));
                text += &format!(
                    "prm p{shape}\nexp {e} {n}\ncoeff {size} .6 {size}\nobj all\nap p{shape}\nrs 1 2 3 {angle}\nxs {x} {y} .5\n"
                );
            }
            let (session, diagnostics) = load_text("mirrors.scn", &text);
            assert!(diagnostics.is_empty(), "{diagnostics:?}");
            let scene = CompiledScene::compile(session.scene(), Some("all"), 4);
            let eye = DVec3::new(6.0, -9.0, 7.0);
            let mut rays = Vec::new();
            for i in 0..400 {
                let target = DVec3::new(f64::from(i % 20) - 10.0, f64::from(i / 20) - 10.0, 0.0) * 0.35;
                let ray = Ray::new(eye, target - eye);
                let Some(first) = scene.intersect(&ray.into()) else { continue };
                let surface = scene.interaction(&first);
                let direction = ray.direction - 2.0 * ray.direction.dot(surface.normal) * surface.normal;
                let mirrored =
                    Ray { origin: surface.position, direction, origin_error: surface.position_error };
                let start = SurfaceStart::of(first.path, RayStart::SurfaceOutward);
                rays.push(TraceRay::new(mirrored).with_start(start));
            }
            let together = scene.intersect_alike(&rays, &mut Coarsened::default());
            for (ray, found) in rays.iter().zip(together) {
                match (found, scene.intersect(ray)) {
                    (None, None) => missed += 1,
                    (Some(found), Some(alone)) => {
                        assert_eq!(found.path, alone.path, "case {case}: {ray:?}\n{text}");
                        assert!(
                            (found.t - alone.t).abs() <= 1e-11 * (1.0 + alone.t),
                            "case {case}: {ray:?}\n{text}"
                        );
                        hit += 1;
                    }
                    (found, alone) => panic!("case {case}: {ray:?} {found:?} {alone:?}\n{text}"),
                }
            }
        }
        assert!(hit > 500 && missed > 5_000, "{hit} {missed}");
    }
}
