//! Rays that leave one surface together and hit nothing.

use std::collections::HashMap;

use foldhash::fast::RandomState;
use superegg_geom::Aabb;
use superegg_geom::glam::DVec3;

use super::hull::Shaft;
use super::occluders::{Occluder, ShaftStart};
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

impl CompiledScene {
    /// [`CompiledScene::intersect_many_counted`] for rays of which neighbours are alike, such as reflected rays: groups that
    /// leave one surface through an empty shaft are not traced.
    pub fn intersect_alike(&self, rays: &[TraceRay], coarsened: &mut Coarsened) -> Vec<Option<Hit>> {
        let mut finder = MissFinder { scene: self, found: Vec::new(), misses: vec![false; rays.len()] };
        for group in by_start(rays).iter().flat_map(|indices| indices.chunks(NEIGHBOURS)) {
            finder.test(rays, group);
        }
        let misses = finder.misses;
        if !misses.contains(&true) {
            return self.intersect_many_counted(rays, coarsened);
        }
        let traced: Vec<TraceRay> =
            rays.iter().zip(&misses).filter(|(_, is_miss)| !**is_miss).map(|(ray, _)| ray.clone()).collect();
        let mut hits = self.intersect_many_counted(&traced, coarsened).into_iter();
        misses.into_iter().map(|is_miss| if is_miss { None } else { hits.next().flatten() }).collect()
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
        let is_usable = origins.min.is_finite() && origins.max.is_finite() && directions.min.is_finite();
        if !is_usable {
            return;
        }
        let directions = Aabb { min: directions.min - ROUNDING, max: directions.max + ROUNDING };
        let width = width + spread * self.scene.reach_from(&origins);
        let own = rays[first].start.as_ref().map(|start| &start.path);
        let shaft = Shaft::along(&origins, &directions);
        let is_complete = self.scene.find_occluders(&shaft, ShaftStart { own, width }, &mut self.found);
        if is_complete && self.found.is_empty() {
            group.iter().for_each(|&index| self.misses[index] = true);
        } else if is_complete && self.found.len() <= MOST_SPLIT && group.len() >= 2 * LEAST_SPLIT {
            let (one, other) = group.split_at(group.len() / 2);
            self.test(rays, one);
            self.test(rays, other);
        }
    }
}

const EMPTY: Aabb = Aabb { min: DVec3::INFINITY, max: DVec3::NEG_INFINITY };
/// More than the rounding of a unit direction.
const ROUNDING: DVec3 = DVec3::splat(1e-15);
