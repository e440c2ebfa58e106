//! Parts of a picture's work on their own, on one thread, for benchmarks.

use superegg_geom::glam::DVec2;
use superegg_geom::{Ray, RayStart, unit_vector};
use superegg_scene::Light;

use crate::beam::{Beam, ShadowRay};
use crate::compiled::CompiledScene;
use crate::footprint::Footprint;
use crate::tiling::{Tile, tiles};
use crate::view::View;

/// The camera rays of a picture, one a pixel, by tiles as [`crate::render`] makes them.
pub fn camera_tiles(view: &View, width: u32, height: u32) -> Vec<Vec<Ray>> {
    let ray = |(x, y): (u32, u32)| view.ray(DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5));
    let rays = |tile: &Tile| tile.pixels_by_block().into_iter().map(ray).collect();
    tiles(width, height).iter().map(rays).collect()
}

/// Traces tiles of camera rays.
pub struct TileProbe<'s> {
    beam: Beam<'s>,
    footprint: Footprint,
}

impl<'s> TileProbe<'s> {
    /// For a scene, and rays of this width.
    pub fn new(scene: &'s CompiledScene, footprint: Footprint) -> Self {
        Self { beam: Beam::new(scene), footprint }
    }

    /// Finds which shape each ray meets first, and where to f32's precision; returns how many meet one.
    pub fn find(&mut self, rays: &[Ray]) -> usize {
        self.beam.start_tile();
        self.beam.find(rays, self.footprint)
    }

    /// The same settled in f64.
    pub fn settle(&mut self, rays: &[Ray]) -> usize {
        self.beam.start_tile();
        let mut found = Vec::new();
        self.beam.closest(rays, self.footprint, &mut found);
        found.iter().flatten().count()
    }

    /// Traces the shadow rays from what a tile sees to a light: how many there are, how many are stopped, and the time for them
    /// alone by a clock of seconds.
    pub fn shadows(&mut self, rays: &[Ray], light: &Light, clock: &dyn Fn() -> f64) -> (usize, usize, f64) {
        let place = light.position().unwrap_or_default();
        self.beam.start_tile();
        let mut found = Vec::new();
        self.beam.closest(rays, self.footprint, &mut found);
        let mut shadow_rays = Vec::new();
        for hit in found.iter().flatten() {
            let candidate = &self.beam.candidates[hit.candidate as usize];
            let origin = candidate.world_from_unit().transform_point3(hit.unit_point);
            let direction = place - origin;
            let normal = unit_vector(candidate.unit_from_world.matrix3.transpose() * hit.gradient);
            if normal.is_some_and(|normal| normal.dot(direction) > 0.0) {
                let origin_error = 16.0 * f64::EPSILON * origin.abs().max_element();
                let (own, start) = (hit.candidate, RayStart::SurfaceOutward);
                let width = self.footprint.at(hit.t);
                shadow_rays.push(ShadowRay {
                    ray: Ray { origin, direction, origin_error },
                    own,
                    start,
                    width,
                });
            }
        }
        let width = shadow_rays.iter().map(|ray| ray.width).reduce(f64::min).unwrap_or(0.0);
        let footprint = Footprint { width, spread: 0.0 };
        let mut stopped = Vec::new();
        let before = clock();
        self.beam.occluded(place, &shadow_rays, footprint, &mut stopped);
        let seconds = clock() - before;
        (shadow_rays.len(), stopped.into_iter().filter(|&stops| stops).count(), seconds)
    }
}
