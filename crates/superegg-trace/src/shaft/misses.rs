//! Rays that leave one surface together and hit nothing.

use std::collections::HashMap;

use foldhash::fast::RandomState;
use superegg_geom::Aabb;
use superegg_geom::glam::DVec3;

use super::hull::Shaft;
use super::occluders::{Occluder, ShaftStart};
use crate::ray::footprint::Footprint;
use crate::ray::limits::Coarsened;
use crate::ray::query::{Hit, Side, SurfaceStart, TraceRay};
use crate::scene::compiled::CompiledScene;
use crate::scene::path::InstancePath;

/// The most rays of a group.
const NEIGHBOURS: usize = 64;
/// Smaller groups are not split.
const LEAST_SPLIT: usize = 16;
/// Halves of a shaft with more shapes are seldom empty.
const MOST_SPLIT: usize = 2;
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
    /// leave one surface through an empty shaft are not traced.
    pub fn intersect_alike(&self, rays: &[TraceRay], coarsened: &mut Coarsened) -> Vec<Option<Hit>> {
        let mut finder = MissFinder { scene: self, found: Vec::new(), misses: vec![false; rays.len()] };
        for group in by_start(rays).iter().flat_map(|indices| indices.chunks(NEIGHBOURS)) {
            finder.test(rays, group);
        }
        self.intersect_others(rays, &finder.misses, coarsened)
    }
}

/// The indices of the rays that leave each surface outwards, and of those that start on none.
fn by_start(rays: &[TraceRay]) -> Vec<Vec<usize>> {
    let mut surfaces: HashMap<Option<&InstancePath>, usize, RandomState> = HashMap::default();
    let mut by_surface: Vec<Vec<usize>> = Vec::new();
    let mut last = None;
    for (index, ray) in rays.iter().enumerate() {
        let path = match &ray.start {
            Some(SurfaceStart { side: Side::Inward, .. }) => continue,
            Some(SurfaceStart { side: Side::Outward, path }) => Some(path),
            None => None,
        };
        let surface = match last {
            Some((last_path, surface)) if last_path == path => surface,
            _ => *surfaces.entry(path).or_insert_with(|| {
                by_surface.push(Vec::new());
                by_surface.len() - 1
            }),
        };
        last = Some((path, surface));
        by_surface[surface].push(index);
    }
    by_surface
}

struct MissFinder<'s> {
    scene: &'s CompiledScene,
    found: Vec<Occluder>,
    misses: Vec<bool>,
}

impl MissFinder<'_> {
    /// Marks rays with one start if their shaft, or that of one half, is empty.
    fn test(&mut self, rays: &[TraceRay], group: &[usize]) {
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
        match self.scene.beam_hits(&beam, &mut self.found) {
            BeamHits::None => group.iter().for_each(|&index| self.misses[index] = true),
            BeamHits::Found if self.found.len() <= MOST_SPLIT && group.len() >= 2 * LEAST_SPLIT => {
                let (one, other) = group.split_at(group.len() / 2);
                self.test(rays, one);
                self.test(rays, other);
            }
            BeamHits::Found | BeamHits::Unknown => {}
        }
    }
}

const EMPTY: Aabb = Aabb { min: DVec3::INFINITY, max: DVec3::NEG_INFINITY };
/// More than the rounding of a unit direction.
const ROUNDING: DVec3 = DVec3::splat(1e-15);
