//! Parts of a picture's work on their own, on one thread, for benchmarks.

use superegg_geom::glam::{DVec2, DVec3};
use superegg_geom::{Ray, RayStart, unit_vector};
use superegg_scene::Light;

use crate::beam::{Beam, Pencil, ShadowRay, ShadowRays, ShadowWay, Sight, take_directions};
use crate::compiled::CompiledScene;
use crate::footprint::Footprint;
use crate::tiling::{Tile, tiles};
use crate::view::View;

/// The directions of a picture's camera rays, one a pixel, by tiles as [`crate::render`] makes them; of a camera whose rays begin at one place.
pub fn camera_tiles(view: &View, width: u32, height: u32) -> Vec<Vec<DVec3>> {
    let ray = |(x, y): (u32, u32)| view.ray(DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5)).direction;
    let rays = |tile: &Tile| tile.pixels_by_block().into_iter().map(ray).collect();
    tiles(width, height).iter().map(rays).collect()
}

/// Traces tiles of camera rays.
pub struct TileProbe<'s> {
    beam: Beam<'s>,
    origin: DVec3,
    footprint: Footprint,
}

impl<'s> TileProbe<'s> {
    /// For a scene, and the camera rays of a view.
    pub fn new(scene: &'s CompiledScene, view: &View) -> Self {
        Self { beam: Beam::new(scene), origin: view.position(), footprint: view.footprint(1) }
    }

    /// Finds which shape each ray meets first, and where to f32's precision; returns how many meet one.
    pub fn find(&mut self, tile: &[DVec3]) -> usize {
        let mut directions = Vec::new();
        take_directions(tile.iter().copied(), &mut directions);
        self.beam.start_tile();
        let rays = Pencil { origin: self.origin, directions: &directions, count: tile.len() };
        self.beam.find(rays, self.footprint)
    }

    /// The same settled in f64.
    pub fn settle(&mut self, tile: &[DVec3]) -> usize {
        self.sight(tile).hits.len()
    }

    fn sight(&mut self, tile: &[DVec3]) -> Sight {
        let (mut directions, mut sight) = (Vec::new(), Sight::default());
        take_directions(tile.iter().copied(), &mut directions);
        self.beam.start_tile();
        let rays = Pencil { origin: self.origin, directions: &directions, count: tile.len() };
        self.beam.closest(rays, self.footprint, &mut sight);
        sight
    }

    /// Traces the shadow rays from what a tile sees to a light: how many there are, how many are stopped, and the time for them
    /// alone by a clock of seconds.
    pub fn shadows(&mut self, tile: &[DVec3], light: &Light, clock: &dyn Fn() -> f64) -> (usize, usize, f64) {
        let place = light.position().unwrap_or_default();
        let (mut ways, mut rays) = (Vec::new(), Vec::new());
        for (_, hit) in self.sight(tile).hits {
            let candidate = &self.beam.candidates[hit.candidate as usize];
            let origin = candidate.world_from_unit().transform_point3(hit.unit_point);
            let direction = place - origin;
            let normal = unit_vector(candidate.unit_from_world.matrix3.transpose() * hit.gradient);
            if normal.is_some_and(|normal| normal.dot(direction) > 0.0) {
                let origin_error = 16.0 * f64::EPSILON * origin.abs().max_element();
                let width = self.footprint.at(hit.t);
                ways.push(ShadowWay { direction, own: hit.candidate, start: RayStart::SurfaceOutward });
                rays.push(ShadowRay { ray: Ray { origin, direction, origin_error }, width });
            }
        }
        let width = rays.iter().map(|ray| ray.width).reduce(f64::min).unwrap_or(0.0);
        let footprint = Footprint { width, spread: 0.0 };
        let asked = ShadowRays { ways: &ways, ray: &|i| rays[i] };
        let before = clock();
        let stopped = self.beam.occluded(place, asked, footprint);
        let seconds = clock() - before;
        (rays.len(), stopped.into_iter().map(u32::count_ones).sum::<u32>() as usize, seconds)
    }
}
