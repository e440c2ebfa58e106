//! The first surfaces on camera rays: in packets if all rays have one origin, else ray by ray.

use std::rc::Rc;

use superegg_geom::Ray;
use superegg_geom::glam::{DVec3, Vec3};
use superegg_simd::Arch;
use superegg_trace::packet::{
    CandidateHit, Columns, LANES, PacketRays, PacketTracer, VisibleSurfaces, bits, first_lanes,
};
use superegg_trace::{Footprint, TraceRay};

use crate::camera::sample::FilmSample;
use crate::camera::sobol::SampleKey;
use crate::camera::view::{PacketDirections, View};
use crate::film::first::{FirstHit, SampleResults};
use crate::render::lane_mirrors::{LaneMirrors, MirroredHit};
use crate::render::surface_cache::SurfaceCache;
use crate::render::surface_ids::SurfaceIdTable;
use crate::shade::context::{RenderContext, at_surface, bump_at, cos_of_weights};
use crate::shade::medium::Media;
use crate::shade::phong::LobeWeights;
use crate::shade::point::{PathState, SurfaceOwner, SurfacePoint, SurfaceView};
use crate::shade::state::ShadingState;
use crate::shade::surfaces::Located;
use crate::shade::textured::Finish;
use crate::shade::whitted::{MIRRORED, Wavefront};
use crate::stats::TraceStats;

/// The camera rays of a picture and the state of each at its start.
pub(crate) struct CameraPaths<'a> {
    pub(crate) context: RenderContext<'a>,
    pub(crate) view: &'a View,
    /// The width of a ray, for the number of samples per pixel.
    pub(crate) footprint: Footprint,
    /// The transparent shapes that contain the camera.
    media: Media,
}

impl<'a> CameraPaths<'a> {
    /// Camera rays of a view with `samples` samples per pixel.
    pub(crate) fn new(context: RenderContext<'a>, view: &'a View, samples: u32) -> Self {
        let media = context.media_at(view.position());
        Self { context, view, footprint: view.footprint(samples), media }
    }

    /// The state at the start of the ray of a sample. `pixel` is the index of its colour.
    fn state(&self, pixel: usize, sample: &FilmSample, ray: &Ray) -> PathState {
        let media = if self.view.is_parallel() && self.context.has_transmission {
            self.context.media_at(ray.origin)
        } else {
            self.media.clone()
        };
        let key = SampleKey::new(sample.pixel, sample.index);
        PathState { pixel, weight: DVec3::ONE, key, media, is_from_floor: false }
    }
}

/// First hits that are shaded in f64.
#[derive(Default)]
pub(crate) struct PrimaryPoints<'a> {
    pub(crate) points: Vec<SurfacePoint<'a>>,
    /// The packet candidate of each point; `None` on the floor and for rays traced one by one.
    pub(crate) candidates: Vec<Option<u32>>,
}

impl<'a> PrimaryPoints<'a> {
    fn clear(&mut self) {
        self.points.clear();
        self.candidates.clear();
    }

    fn push(&mut self, point: SurfacePoint<'a>, candidate: Option<u32>) {
        self.points.push(point);
        self.candidates.push(candidate);
    }
}

/// The first hits of the samples of one batch.
pub(crate) struct PrimaryHits<'a> {
    pub(crate) tracer: PacketTracer<'a>,
    /// Camera rays with one origin.
    pub(crate) rays: PacketRays,
    /// Their first surfaces. Those in f32 lanes are no points.
    pub(crate) visible: VisibleSurfaces,
    pub(crate) surfaces: SurfaceCache<'a>,
    /// The mirrors in f32 lanes.
    pub(crate) mirrors: LaneMirrors,
    pub(crate) shaded: PrimaryPoints<'a>,
    /// The map from gradients to normals of each candidate that is shaded in lanes.
    normal_maps: Vec<Option<Columns>>,
    arch: Arch,
}

impl<'a> PrimaryHits<'a> {
    pub(crate) fn new(context: &RenderContext<'a>) -> Self {
        Self {
            tracer: PacketTracer::new(context.scene),
            rays: PacketRays::default(),
            visible: VisibleSurfaces::default(),
            surfaces: SurfaceCache::new(*context),
            mirrors: LaneMirrors::new(),
            shaded: PrimaryPoints::default(),
            normal_maps: Vec::new(),
            arch: Arch::new(),
        }
    }

    /// Removes the points of the batch before.
    pub(crate) fn clear(&mut self) {
        self.shaded.clear();
    }

    /// Traces the rays of a camera with a lens or of an orthographic camera one by one. Adds the
    /// sky to the colours of rays without a hit.
    pub(crate) fn trace_single_rays(
        &mut self,
        camera: &CameraPaths<'a>,
        samples: &[FilmSample],
        shading: &mut ShadingState<'_, 'a>,
    ) {
        let mut wave = Wavefront::with_capacity(camera.context, 0, samples.len());
        for (pixel, sample) in samples.iter().enumerate() {
            let ray = camera.view.sample_ray(sample);
            let state = camera.state(pixel, sample, &ray);
            wave.push(TraceRay::new(ray).with_footprint(camera.footprint), state);
        }
        self.shaded.points = wave.trace(shading);
        self.shaded.candidates.resize(self.shaded.points.len(), None);
    }

    /// Traces the rays of a pinhole camera in packets. With `in_lanes`, surfaces that the lane
    /// kernels can shade may stay in f32.
    pub(crate) fn trace_packets(&mut self, camera: &CameraPaths<'a>, samples: &[FilmSample], in_lanes: bool) {
        self.rays.start(camera.view.position());
        for packet in samples.chunks(LANES) {
            let directions = self.arch.dispatch(PacketDirections { view: camera.view, samples: packet });
            self.rays.extend(&directions, first_lanes(packet.len()));
        }
        self.tracer.start_tile();
        self.surfaces.clear();
        self.tracer.find(&self.rays, camera.footprint, camera.view.footprint(1));
        self.normal_maps.clear();
        if in_lanes {
            self.find_normal_maps();
        }
        self.tracer.resolve(&self.rays, &self.normal_maps, &mut self.visible);
        self.mirrors.clear();
        if in_lanes {
            let Self { rays, tracer, visible, surfaces, mirrors, .. } = self;
            let (scene, seen_from) = (camera.context.scene, (rays.origin, camera.footprint));
            let moved = mirrors.find(scene, tracer, surfaces, visible, seen_from);
            tracer.move_to_hits(rays, moved, visible);
        }
    }

    fn find_normal_maps(&mut self) {
        self.normal_maps.resize(self.tracer.candidate_count(), None);
        for found in self.tracer.found() {
            let map = &mut self.normal_maps[found.candidate as usize];
            let surface = self.surfaces.get_or_prepare(&self.tracer, found.candidate);
            *map = surface.plain.as_ref().map(|(_, map)| *map);
        }
    }

    /// Appends a colour for each sample: the sky where the ray has no hit, else black. Hits on the
    /// floor become points, and the hits behind them are removed.
    pub(crate) fn shade_misses(
        &mut self,
        camera: &CameraPaths<'a>,
        samples: &[FilmSample],
        colors: &mut Vec<DVec3>,
    ) {
        let RenderContext { environment, ground, .. } = camera.context;
        if ground.is_none() && environment.sky.is_none() && environment.map.is_none() {
            colors.resize(samples.len(), environment.background);
            return;
        }
        let mut nearest = self.nearest_t(samples.len());
        for (pixel, sample) in samples.iter().enumerate() {
            let ray = self.rays.ray(pixel);
            let on_floor = ground.and_then(|ground| Some((ground, ground.intersect(&ray)?)));
            let color = if let Some((ground, t)) = on_floor.filter(|(_, t)| *t < nearest[pixel]) {
                nearest[pixel] = -1.0;
                self.visible.surfaces[pixel / LANES].lanes &= !(1 << (pixel % LANES));
                let state = camera.state(pixel, sample, &ray);
                let point = camera.context.point_of_floor(&ground, &ray, t, camera.footprint, state);
                self.shaded.push(point, None);
                DVec3::ZERO
            } else if nearest[pixel] == f64::INFINITY {
                camera.context.sky(ray.direction)
            } else {
                DVec3::ZERO
            };
            colors.push(color);
        }
        self.visible.hits.retain(|(pixel, _)| nearest[*pixel as usize] >= 0.0);
    }

    /// The t of the first hit of each ray; infinity where it has none.
    fn nearest_t(&self, samples: usize) -> Vec<f64> {
        let mut nearest = vec![f64::INFINITY; samples];
        for resolved in &self.visible.resolved {
            for lane in bits(resolved.lanes) {
                let pixel = resolved.packet * LANES + lane;
                nearest[pixel] = self.visible.surface_at(pixel).t;
            }
        }
        for (pixel, hit) in &self.visible.hits {
            nearest[*pixel as usize] = hit.t;
        }
        nearest
    }

    /// Prepares the hits in f64 for shading and sets their colours to black.
    pub(crate) fn prepare_points(
        &mut self,
        camera: &CameraPaths<'a>,
        samples: &[FilmSample],
        colors: &mut [DVec3],
        stats: &mut TraceStats,
    ) {
        for i in 0..self.visible.hits.len() {
            let (pixel, hit) = self.visible.hits[i];
            let (pixel, ray) = (pixel as usize, self.rays.ray(pixel as usize));
            let state = camera.state(pixel, &samples[pixel], &ray);
            let point = self.point_of_hit(camera, &ray, &hit, state);
            stats.proxy_hits += u64::from(point.is_proxy());
            colors[pixel] = DVec3::ZERO;
            self.shaded.push(point, Some(hit.candidate));
        }
    }

    /// The points that mirrors in f32 lanes show.
    pub(crate) fn points_in_mirrors(
        &self,
        camera: &CameraPaths<'a>,
        samples: &[FilmSample],
        shading: &mut ShadingState<'_, 'a>,
    ) -> Vec<SurfacePoint<'a>> {
        let seen = self.mirrors.seen();
        shading.stats.rays.reflection += seen.len() as u64;
        let point = |seen: &MirroredHit| {
            let MirroredHit { pixel, ray, footprint, mirror, hit } = seen;
            let start = camera.state(*pixel, &samples[*pixel], ray);
            let state = PathState { weight: DVec3::splat(*mirror), key: start.key.branch(MIRRORED), ..start };
            let ray = TraceRay::new(*ray).with_footprint(*footprint);
            camera.context.surface_point(&ray, Some(hit), state, shading)
        };
        let mut points = Vec::with_capacity(seen.len());
        points.extend(seen.iter().filter_map(point));
        points
    }

    fn point_of_hit(
        &mut self,
        camera: &CameraPaths<'a>,
        ray: &Ray,
        hit: &CandidateHit,
        state: PathState,
    ) -> SurfacePoint<'a> {
        let footprint = at_surface(camera.footprint, ray, hit.t);
        let surface = self.surfaces.get_or_prepare(&self.tracer, hit.candidate);
        let world_from_unit = surface.world_from_unit(&self.tracer, hit.candidate);
        let Located { position, position_error, normal } =
            Located::of(world_from_unit, &surface.normal_map, hit.unit_point, hit.gradient);
        let direction = ray.direction.normalize();
        let view = SurfaceView { normal, direction, width: footprint.width };
        let (material, primitive) = (&surface.material, surface.primitive);
        let Finish { albedo, material, bumped } =
            camera.context.finish(material, primitive, hit.unit_point, world_from_unit, &view);
        let bump = bump_at(normal, hit.leaving, bumped, -direction);
        SurfacePoint {
            state: state.after(ray.origin, position),
            owner: SurfaceOwner::Instance(Rc::clone(&surface.path)),
            position,
            position_error,
            normal,
            leaving: hit.leaving,
            to_eye: -direction,
            footprint,
            albedo,
            weights: LobeWeights::of(&material, cos_of_weights(direction, normal, bump.as_deref())),
            material,
            bump,
        }
    }

    /// Writes depth, normal, albedo and ids of the first hit of each sample.
    pub(crate) fn write_first_hits(
        &self,
        camera: &CameraPaths<'a>,
        samples: usize,
        table: &mut SurfaceIdTable<'_>,
        results: &mut SampleResults,
    ) {
        results.first_hits.resize(samples, None);
        for (point, &candidate) in self.shaded.points.iter().zip(&self.shaded.candidates) {
            let ids = match &point.owner {
                SurfaceOwner::Instance(path) => {
                    match candidate.and_then(|candidate| self.surfaces.get(candidate)) {
                        Some(surface) => surface.ids(table),
                        None => table.of(path),
                    }
                }
                SurfaceOwner::Floor => table.of_floor(),
            };
            results.first_hits[point.state.pixel] = Some(FirstHit {
                depth: camera.view.depth(point.position) as f32,
                normal: point.shading_normal().as_vec3(),
                albedo: point.albedo.as_vec3(),
                ids,
            });
        }
        for resolved in &self.visible.resolved {
            let Some(surface) = self.surfaces.get(resolved.candidate) else { continue };
            let packet = &self.visible.surfaces[resolved.packet];
            for lane in bits(resolved.lanes & packet.lanes) {
                let pixel = resolved.packet * LANES + lane;
                let normal = packet.normal.each_ref().map(|column| column.0[lane]);
                results.first_hits[pixel] = Some(FirstHit {
                    // The component of a camera ray's direction along the line of sight is 1.
                    depth: self.visible.surface_at(pixel).t as f32,
                    normal: Vec3::from_array(normal),
                    albedo: surface.material.color.as_vec3(),
                    ids: surface.ids(table),
                });
            }
        }
    }
}
