//! Tiles: first hits, direct light and scattered rays of a batch of samples.

use superegg_geom::glam::DVec3;
use superegg_scene::{AmbientOcclusion, Light, LightModel};
use superegg_trace::Footprint;
use superegg_trace::packet::ShadowRays;

use crate::camera::sample::FilmSample;
use crate::camera::view::View;
use crate::film::first::{FirstLight, SampleResults};
use crate::render::lane_lighting::LaneLighting;
use crate::render::point_shadows::PointShadows;
use crate::render::primary_hits::{CameraPaths, PrimaryHits};
use crate::render::shadow_queue::ShadowQueue;
use crate::render::surface_ids::SurfaceIdTable;
use crate::shade::context::RenderContext;
use crate::shade::direct;
use crate::shade::path::{add_indirect_light, trace_first_paths};
use crate::shade::shadow_batch::add_transmitted;
use crate::shade::state::ShadingState;
use crate::shade::surfaces::Surfaces;
use crate::shade::whitted::Wavefront;
use crate::stats::TraceStats;

/// Traces batches of samples and reuses its memory.
pub(crate) struct TileTracer<'a> {
    camera: CameraPaths<'a>,
    pub(crate) stats: TraceStats,
    hits: PrimaryHits<'a>,
    /// The surfaces that reflected, refracted and shadow rays hit.
    instances: Surfaces<'a>,
    lanes: LaneLighting,
    point_shadows: PointShadows,
    shadow_queue: ShadowQueue,
    results: SampleResults,
    needs: SampleNeeds,
    /// The ids of the tile's surfaces.
    pub(crate) ids: SurfaceIdTable<'a>,
}

/// The results that are needed of each sample, beside its colour.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SampleNeeds {
    /// The first hit.
    pub(crate) first_hits: bool,
    /// The light of first surfaces.
    pub(crate) passes: bool,
}

impl<'a> TileTracer<'a> {
    /// For pictures of `samples` samples per pixel.
    pub(crate) fn new(
        context: RenderContext<'a>,
        view: &'a View,
        samples: u32,
        needs: SampleNeeds,
        ids: SurfaceIdTable<'a>,
    ) -> Self {
        Self {
            camera: CameraPaths::new(context, view, samples),
            stats: TraceStats::default(),
            hits: PrimaryHits::new(&context),
            instances: Surfaces::new(context.scene),
            lanes: LaneLighting::new(&context, view),
            point_shadows: PointShadows::new(),
            shadow_queue: ShadowQueue::default(),
            results: SampleResults::default(),
            needs,
            ids,
        }
    }

    /// The light that each sample receives. There are at most [`superegg_trace::packet::MOST_RAYS`]
    /// samples. Every sixteen neighbours form a packet.
    pub(crate) fn trace(&mut self, samples: &[FilmSample]) -> &mut SampleResults {
        if self.camera.context.picture.light_model == LightModel::Path {
            return self.trace_paths(samples);
        }
        self.find_primary_hits(samples, true);
        self.add_light();
        let Self { camera, stats, hits, lanes, results, instances, .. } = self;
        lanes.write_colors(&hits.visible, &mut results.colors);
        let mut shading = ShadingState { colors: &mut results.colors, stats, surfaces: instances };
        direct::add_ambient(camera.context, &hits.shaded.points, true, &mut shading);
        let wave = Wavefront::of_points(camera.context, 1, &hits.shaded.points, &mut shading)
            .with_beams_tested(hits.mirrors.moved_count());
        let seen = hits.points_in_mirrors(camera, samples, &mut shading);
        wave.follow_all(seen, &mut shading);
        self.finish(samples.len())
    }

    /// [`TileTracer::trace`] by paths.
    fn trace_paths(&mut self, samples: &[FilmSample]) -> &mut SampleResults {
        self.find_primary_hits(samples, false);
        let Self { camera, stats, hits, results, instances, .. } = self;
        let context = camera.context;
        let mut shading = ShadingState { colors: &mut results.colors, stats, surfaces: instances };
        direct::add_emission(&hits.shaded.points, &mut shading);
        self.keep_emission();
        self.add_light();
        let Self { stats, hits, results, instances, .. } = self;
        let mut shading = ShadingState { colors: &mut results.colors, stats, surfaces: instances };
        let points = trace_first_paths(context, &hits.shaded.points, &mut shading);
        self.keep_direct_light();
        let Self { stats, results, instances, .. } = self;
        let mut shading = ShadingState { colors: &mut results.colors, stats, surfaces: instances };
        add_indirect_light(context, points, &mut shading);
        self.finish(samples.len())
    }

    /// Keeps the light so far as that of no surface, if passes are needed.
    fn keep_emission(&mut self) {
        if self.needs.passes {
            let SampleResults { colors, passes, .. } = &mut self.results;
            passes.clear();
            passes.extend(colors.iter().map(|&emission| FirstLight { emission, direct: DVec3::ZERO }));
        }
    }

    /// Keeps the light since then as that of one surface.
    fn keep_direct_light(&mut self) {
        let SampleResults { colors, passes, .. } = &mut self.results;
        for (pass, &color) in passes.iter_mut().zip(&*colors) {
            pass.direct = color - pass.emission;
        }
    }

    /// The unoccluded fraction of the hemisphere at each first hit as a grey level, and black where
    /// there is no hit. Limits as for [`TileTracer::trace`].
    pub(crate) fn trace_occlusion(
        &mut self,
        samples: &[FilmSample],
        occlusion: AmbientOcclusion,
    ) -> &mut SampleResults {
        self.find_primary_hits(samples, false);
        let Self { camera, stats, hits, results, .. } = self;
        results.colors.fill(DVec3::ZERO);
        let points = &hits.shaded.points;
        let open = direct::open_fractions(camera.context, occlusion, points, stats);
        for (point, fraction) in points.iter().zip(open) {
            results.colors[point.state.pixel] = DVec3::splat(fraction);
        }
        self.finish(samples.len())
    }

    /// Finds the first hit of each sample. Samples without a hit get the colour of the sky.
    fn find_primary_hits(&mut self, samples: &[FilmSample], in_lanes: bool) {
        let Self { camera, stats, hits, lanes, results: SampleResults { colors, .. }, instances, .. } = self;
        stats.rays.camera += samples.len() as u64;
        hits.clear();
        colors.clear();
        if camera.view.is_pinhole() {
            hits.trace_packets(camera, samples, in_lanes && lanes.is_enabled());
            hits.shade_misses(camera, samples, colors);
            lanes.start(&camera.context, hits, stats);
            hits.prepare_points(camera, samples, colors, stats);
        } else {
            colors.resize(samples.len(), DVec3::ZERO);
            let mut shading = ShadingState { colors, stats, surfaces: instances };
            hits.trace_single_rays(camera, samples, &mut shading);
        }
    }

    /// The colours of the samples and, if requested, their first hits.
    fn finish(&mut self, samples: usize) -> &mut SampleResults {
        self.stats.coarsened.rays += self.hits.tracer.take_coarsened().rays;
        self.results.first_hits.clear();
        if self.needs.first_hits {
            self.hits.write_first_hits(&self.camera, samples, &mut self.ids, &mut self.results);
        }
        &mut self.results
    }

    /// Adds direct light to all first hits.
    fn add_light(&mut self) {
        let context = self.camera.context;
        let in_packets = self.camera.view.is_pinhole();
        if in_packets {
            for (index, light) in context.lights() {
                if let Some(position) = point_position(light) {
                    self.add_point_light((index, light), position);
                }
            }
        }
        let others = context.lights().filter(|(_, light)| !in_packets || point_position(light).is_none());
        let Self { hits, stats, results, instances, .. } = self;
        let mut shading = ShadingState { colors: &mut results.colors, stats, surfaces: instances };
        direct::add_light(context, &hits.shaded.points, &others, true, &mut shading);
    }

    /// Adds the light of a point light to all first hits that it reaches.
    fn add_point_light(&mut self, (index, light): (u32, &Light), position: DVec3) {
        let Self { camera, stats, hits, lanes, point_shadows, shadow_queue, results, instances, .. } = self;
        let CameraPaths { context, footprint, .. } = camera;
        shadow_queue.start(position);
        let lane_width =
            lanes.queue_shadows(context, hits, (index as usize, position), *footprint, shadow_queue);
        let first_of_points = shadow_queue.len();
        let point_width = point_shadows.queue(context, &hits.shaded, (index, light), position, shadow_queue);
        if shadow_queue.len() == 0 {
            return;
        }
        stats.rays.shadow += shadow_queue.len() as u64;
        let PrimaryHits { tracer, rays, visible, shaded, .. } = hits;
        let ShadowQueue { from_light, starts } = &*shadow_queue;
        let ray = |i: usize| match i.checked_sub(first_of_points) {
            Some(i) => point_shadows.ray(i, &shaded.points, position),
            None => lanes.shadow_ray(i, visible, *footprint, from_light),
        };
        let shadow = ShadowRays { from_light, starts, ray: &ray };
        let width = lane_width.min(point_width);
        let occluded = tracer.occluded(shadow, Footprint { width, spread: 0.0 });
        let of_points = (first_of_points, &*occluded);
        let colors = &mut results.colors;
        let mut dimmed = point_shadows.add_unoccluded(context, &shaded.points, position, of_points, colors);
        lanes.add_unoccluded(rays.directions().len(), &occluded);
        let mut shading = ShadingState { colors, stats, surfaces: instances };
        add_transmitted(*context, &mut dimmed, 1.0, &mut shading);
    }
}

/// The position of a light without a radius. Its shadow rays have one origin and form packets.
fn point_position(light: &Light) -> Option<DVec3> {
    light.position().filter(|_| light.radius == 0.0)
}
