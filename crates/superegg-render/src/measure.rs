//! Parts of a picture's work on their own, on one thread, for benchmarks.

use superegg_geom::glam::DVec2;
use superegg_geom::{Ray, RayStart, unit_vector};
use superegg_scene::Light;

use crate::beam::{Beam, BeamHit, Shadow};
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
        let mut shadow_rays = vec![None; rays.len()];
        let mut starts = vec![(0, RayStart::Free); rays.len()];
        for (i, hit) in found.iter().enumerate() {
            let Some(hit) = hit else { continue };
            let candidate = &self.beam.candidates[hit.candidate as usize];
            let position = candidate.world_from_unit().transform_point3(hit.unit_point);
            let direction = place - position;
            let normal = unit_vector(candidate.unit_from_world.matrix3.transpose() * hit.gradient);
            if normal.is_some_and(|normal| normal.dot(direction) > 0.0) {
                let origin_error = 16.0 * f64::EPSILON * position.abs().max_element();
                shadow_rays[i] = Some(Ray { origin: position, direction, origin_error });
                starts[i] = (hit.candidate, RayStart::SurfaceOutward);
            }
        }
        let width = |hit: &Option<BeamHit>| hit.map_or(0.0, |hit| self.footprint.at(hit.t));
        let widths: Vec<f64> = found.iter().map(width).collect();
        let least = widths.iter().copied().filter(|&width| width > 0.0).fold(f64::INFINITY, f64::min);
        let shadow = Shadow { rays: &shadow_rays, starts: &starts, widths: &widths };
        let footprint = Footprint { width: if least.is_finite() { least } else { 0.0 }, spread: 0.0 };
        let before = clock();
        let occluded = self.beam.occluded(place, &shadow, footprint);
        let seconds = clock() - before;
        let stopped = occluded.iter().map(|lanes| lanes.count_ones() as usize).sum();
        (shadow_rays.iter().flatten().count(), stopped, seconds)
    }
}
