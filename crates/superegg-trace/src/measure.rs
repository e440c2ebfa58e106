//! Parts of a picture's work on their own, on one thread, for benchmarks.

use superegg_geom::{Ray, RayStart, unit_vector};
use superegg_scene::Light;

use crate::beam::{Beam, ShadowRay, ShadowRays, ShadowStart, Sight};
use crate::compiled::CompiledScene;
use crate::flight::FlightRay;
use crate::footprint::Footprint;
use crate::pencil::Pencil;

/// The camera rays of a tile.
pub struct CameraTile(Pencil);

impl CameraTile {
    /// A tile of these rays.
    pub fn new(rays: Pencil) -> Self {
        Self(rays)
    }

    /// How many rays it has.
    pub fn count(&self) -> usize {
        self.0.count()
    }
}

/// Finds which shape each of many rays with nothing in common meets first, and where to f32's precision (where that cannot tell, f64 does), as
/// [`TileProbe::find`] does for camera rays; returns how many meet one.
pub fn find_many(scene: &CompiledScene, rays: &[FlightRay]) -> usize {
    scene.find_many(rays)
}

/// Traces tiles of camera rays.
pub struct TileProbe<'s> {
    beam: Beam<'s>,
    footprint: Footprint,
    sight: Sight,
}

impl<'s> TileProbe<'s> {
    /// For a scene, and rays of this width.
    pub fn new(scene: &'s CompiledScene, footprint: Footprint) -> Self {
        Self { beam: Beam::new(scene), footprint, sight: Sight::default() }
    }

    /// Finds which shape each ray meets first, and where to f32's precision; returns how many meet one.
    pub fn find(&mut self, tile: &CameraTile) -> usize {
        self.beam.start_tile();
        self.beam.find(&tile.0, self.footprint)
    }

    /// The same settled in f64.
    pub fn settle(&mut self, tile: &CameraTile) -> usize {
        self.beam.start_tile();
        self.beam.closest(&tile.0, self.footprint, &mut self.sight);
        self.sight.hits.len()
    }

    /// Traces the shadow rays from what a tile sees to a light: how many there are, how many are stopped, and the time for them
    /// alone by a clock of seconds.
    pub fn shadows(
        &mut self,
        tile: &CameraTile,
        light: &Light,
        clock: &dyn Fn() -> f64,
    ) -> (usize, usize, f64) {
        let place = light.position().unwrap_or_default();
        let (mut starts, mut rays, mut from_light) = (Vec::new(), Vec::new(), Pencil::default());
        from_light.start(place);
        self.settle(tile);
        for (_, hit) in &self.sight.hits {
            let candidate = &self.beam.candidates[hit.candidate as usize];
            let origin = candidate.world_from_unit().transform_point3(hit.unit_point);
            let direction = place - origin;
            let normal = unit_vector(candidate.unit_from_world.matrix3.transpose() * hit.gradient);
            if normal.is_some_and(|normal| normal.dot(direction) > 0.0) {
                let origin_error = 16.0 * f64::EPSILON * origin.abs().max_element();
                let width = self.footprint.at(hit.t);
                from_light.push(-direction);
                starts.push(ShadowStart { own: hit.candidate, start: RayStart::SurfaceOutward });
                rays.push(ShadowRay { ray: Ray { origin, direction, origin_error }, width });
            }
        }
        let width = rays.iter().map(|ray| ray.width).reduce(f64::min).unwrap_or(0.0);
        let footprint = Footprint { width, spread: 0.0 };
        let asked = ShadowRays { from_light: &from_light, starts: &starts, ray: &|i| rays[i] };
        let before = clock();
        let stopped = self.beam.occluded(asked, footprint);
        let seconds = clock() - before;
        (rays.len(), stopped.into_iter().map(u32::count_ones).sum::<u32>() as usize, seconds)
    }
}
