//! Parts of a picture's work on one thread, for benchmarks.

use superegg_geom::{Ray, RayStart, unit_vector};
use superegg_scene::Light;

use crate::packet::{PacketRays, PacketTracer, ShadowRay, ShadowRays, ShadowStart, VisibleSurfaces};
use crate::ray::footprint::Footprint;
use crate::ray::query::TraceRay;
use crate::scene::compiled::CompiledScene;

/// The camera rays of a tile.
pub struct CameraTile(PacketRays);

impl CameraTile {
    /// A tile of these rays.
    pub fn new(rays: PacketRays) -> Self {
        Self(rays)
    }

    /// The number of rays.
    pub fn count(&self) -> usize {
        self.0.count()
    }
}

/// Traces a stream without the refinement in f64, as [`TileProbe::find`] does packets. Returns the number of rays that hit.
pub fn find_many(scene: &CompiledScene, rays: &[TraceRay]) -> usize {
    scene.find_many(rays)
}

/// Traces tiles of camera rays.
pub struct TileProbe<'s> {
    tracer: PacketTracer<'s>,
    footprint: Footprint,
    visible: VisibleSurfaces,
}

/// The shadow rays of a tile.
#[derive(Clone, Copy, Debug)]
pub struct ShadowTiming {
    /// The number of rays.
    pub rays: usize,
    /// The number of occluded rays.
    pub occluded: usize,
    /// The time for them alone, in seconds.
    pub seconds: f64,
}

impl<'s> TileProbe<'s> {
    /// For rays of this width.
    pub fn new(scene: &'s CompiledScene, footprint: Footprint) -> Self {
        Self { tracer: PacketTracer::new(scene), footprint, visible: VisibleSurfaces::default() }
    }

    /// Finds the first shape on each ray, with t in f32. Returns the number of rays that hit.
    pub fn find(&mut self, tile: &CameraTile) -> usize {
        self.tracer.start_tile();
        self.tracer.count_hits(&tile.0, self.footprint)
    }

    /// The same with hits refined in f64.
    pub fn refine(&mut self, tile: &CameraTile) -> usize {
        self.tracer.start_tile();
        self.tracer.closest(&tile.0, self.footprint, &mut self.visible);
        self.visible.hits.len()
    }

    /// Traces the shadow rays from the visible points of a tile to a light. `clock` returns seconds.
    pub fn shadows(&mut self, tile: &CameraTile, light: &Light, clock: &dyn Fn() -> f64) -> ShadowTiming {
        let position = light.position().unwrap_or_default();
        let (mut starts, mut rays, mut from_light) = (Vec::new(), Vec::new(), PacketRays::default());
        from_light.start(position);
        self.refine(tile);
        for (_, hit) in &self.visible.hits {
            let candidate = self.tracer.candidate(hit.candidate);
            let origin = candidate.world_from_unit().transform_point3(hit.unit_point);
            let direction = position - origin;
            let normal = unit_vector(candidate.unit_from_world.matrix3.transpose() * hit.gradient);
            if normal.is_some_and(|normal| normal.dot(direction) > 0.0) {
                let origin_error = 16.0 * f64::EPSILON * origin.abs().max_element();
                let width = self.footprint.at(hit.t);
                from_light.push(-direction);
                starts.push(ShadowStart { own: Some(hit.candidate), start: RayStart::SurfaceOutward });
                rays.push(ShadowRay { ray: Ray { origin, direction, origin_error }, width });
            }
        }
        let width = rays.iter().map(|ray| ray.width).reduce(f64::min).unwrap_or(0.0);
        let footprint = Footprint { width, spread: 0.0 };
        let shadow = ShadowRays { from_light: &from_light, starts: &starts, ray: &|i| rays[i] };
        let before = clock();
        let occluded = self.tracer.occluded(shadow, footprint);
        let seconds = clock() - before;
        let occluded = occluded.into_iter().map(u32::count_ones).sum::<u32>() as usize;
        ShadowTiming { rays: rays.len(), occluded, seconds }
    }
}
