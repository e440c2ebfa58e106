//! A tile of the picture: camera rays as one beam where they begin at one place, and for each light that shines from one point the shadow rays as
//! another, seen from the light.

use std::cell::OnceCell;
use std::rc::Rc;

use superegg_geom::glam::{DAffine3, DMat3, DVec3, Vec3};
use superegg_geom::kernels::packet::{ALL_LANES, PacketVectors};
use superegg_geom::{Ray, RayStart, error_through, unit_vector};
use superegg_scene::{AmbientOcclusion, Light, Pattern};
use superegg_simd::Arch;

use crate::camera::sample::FilmSample;
use crate::camera::sobol::SampleKey;
use crate::camera::view::{PacketDirections, View};
use crate::film::first::{FirstHit, SampleResults};
use crate::render::lane_kernels::{
    AddContribution, PacketContribution, PacketLight, PacketMaterials, PlainMaterial, SetMaterial,
    ShadePacket,
};
use crate::shade::context::{RenderContext, at_surface};
use crate::shade::direct::{self, LightSample, ShadowBatch};
use crate::shade::medium::Media;
use crate::shade::phong::LobeWeights;
use crate::shade::point::{MaterialRef, PathState, SurfaceOwner, SurfacePoint, SurfaceView, albedo_of_shape};
use crate::shade::whitted::Wavefront;
use crate::stats::TraceStats;
use superegg_trace::packet::{
    CandidateHit, Columns, DirectionsFrom, LANES, LaneSurface, PacketRays, PacketTracer, ShadowRay,
    ShadowRays, ShadowStart, SurfaceLanes, VisibleSurfaces, bits, f32_columns, first_lanes,
};
use superegg_trace::{CompiledScene, Footprint, InstancePath, Target, TraceRay};

/// Traces tiles, one after the other, in the same memory.
pub(crate) struct TileTracer<'a> {
    context: RenderContext<'a>,
    view: &'a View,
    footprint: Footprint,
    /// What the camera is in.
    media: Media,
    pub(crate) stats: TraceStats,
    beam: PacketTracer<'a>,
    /// Camera rays from one place, and what they see.
    rays: PacketRays,
    sight: VisibleSurfaces,
    looks: SurfaceCache<'a>,
    /// The lights, where opaque surfaces are lit in lanes, and what they are lit by.
    packet_lights: Option<Vec<PacketLight>>,
    finishes: Vec<PacketMaterials>,
    /// What the lights have brought to them so far, and what the next one will where nothing is between.
    light: Vec<PacketVectors>,
    shines: Vec<PacketContribution>,
    /// The other points that the last samples see first, as many at most, and what light and sky bring to each sample.
    points: Vec<SurfacePoint<'a>>,
    seen: SampleResults,
    needs_first_hits: bool,
    /// The candidate of each point, if it has one.
    candidates: Vec<Option<u32>>,
    /// By candidate the map from gradients to normals, if it is shaded in lanes.
    normal_maps: Vec<Option<Columns>>,
    arch: Arch,
    /// Shadow rays: those of surfaces that lanes tell of, whole packets first, and then those of points, with the light that each gets if nothing is
    /// between.
    from_light: PacketRays,
    starts: Vec<ShadowStart>,
    lit_lanes: Vec<LaneShadows>,
    /// Those that are no whole packets, until the others are put in.
    lit_in_part: Vec<SurfaceLanes>,
    lit_points: Vec<(u32, DVec3)>,
    /// By packets the lanes of those that the light reaches.
    open: Vec<u32>,
}

/// Shadow rays from the surface of one candidate that lanes of a packet tell of.
struct LaneShadows {
    of: SurfaceLanes,
    /// Where they begin among the shadow rays.
    first: usize,
}

impl LaneShadows {
    /// The lanes that are open, by packets of shadow rays which of them are stopped.
    fn open(&self, stopped: &[u32]) -> u32 {
        let (packet, place) = (self.first / LANES, self.first % LANES);
        let next = stopped.get(packet + 1).copied().unwrap_or_default();
        let open = !((stopped[packet] | next << LANES) >> place);
        if self.of.lanes == ALL_LANES {
            return open & ALL_LANES;
        }
        bits(self.of.lanes).enumerate().fold(0, |all, (ray, lane)| all | (open >> ray & 1) << lane)
    }

    /// The sample of a shadow ray, which is one of these.
    fn sample(&self, ray: usize) -> Option<usize> {
        Some(self.of.packet * LANES + bits(self.of.lanes).nth(ray.checked_sub(self.first)?)?)
    }
}

/// What shading needs of candidates, each made when it is first shaded.
struct SurfaceCache<'a> {
    scene: &'a CompiledScene,
    by_candidate: Vec<Option<PreparedSurface<'a>>>,
}

/// A candidate, ready to be shaded.
#[derive(Clone)]
struct PreparedSurface<'a> {
    /// Made for the first hit that lanes do not tell of: most have none.
    world_from_unit: OnceCell<DAffine3>,
    /// Brings gradients into the world.
    normal_map: DMat3,
    material: MaterialRef<'a>,
    /// Of a primitive.
    primitive: Option<u32>,
    path: Rc<InstancePath>,
    id: u32,
    /// How lanes shade it, with the columns of the map of gradients; `None` where they do not.
    plain: Option<(PlainMaterial, [[f32; 3]; 3])>,
}

impl<'a> TileTracer<'a> {
    /// For pictures of so many samples a pixel; `asks_firsts` for what samples meet first, which takes some time.
    pub(crate) fn new(
        context: RenderContext<'a>,
        view: &'a View,
        samples: u32,
        needs_first_hits: bool,
    ) -> Self {
        Self {
            context,
            view,
            footprint: view.footprint(samples),
            media: context.media_at(view.position()),
            stats: TraceStats::default(),
            beam: PacketTracer::new(context.scene),
            rays: PacketRays::default(),
            sight: VisibleSurfaces::default(),
            looks: SurfaceCache { scene: context.scene, by_candidate: Vec::new() },
            packet_lights: PacketLight::all(&context, view),
            finishes: Vec::new(),
            light: Vec::new(),
            shines: Vec::new(),
            points: Vec::new(),
            seen: SampleResults::default(),
            needs_first_hits,
            candidates: Vec::new(),
            normal_maps: Vec::new(),
            arch: Arch::new(),
            from_light: PacketRays::default(),
            starts: Vec::new(),
            lit_lanes: Vec::new(),
            lit_in_part: Vec::new(),
            lit_points: Vec::new(),
            open: Vec::new(),
        }
    }

    /// What each of some samples sees: at most [`superegg_trace::packet::MOST_RAYS`] of them, neighbours by the sixteen.
    pub(crate) fn trace(&mut self, samples: &[FilmSample]) -> &mut SampleResults {
        self.find_primary_hits(samples, true);
        self.add_light();
        let mut wave = Wavefront::new(self.context, 1);
        self.points.iter().for_each(|point| wave.scatter(point, &mut self.seen.colors, &mut self.stats));
        wave.follow_all(&mut self.seen.colors, &mut self.stats);
        self.write_lane_colors();
        self.report(samples.len())
    }

    /// The same with the share of each surface's sky that is open instead of its light, and black where there is no surface.
    pub(crate) fn trace_occlusion(
        &mut self,
        samples: &[FilmSample],
        occlusion: AmbientOcclusion,
    ) -> &mut SampleResults {
        self.find_primary_hits(samples, false);
        self.seen.colors.fill(DVec3::ZERO);
        let open = direct::open_fractions(self.context, occlusion, &self.points, &mut self.stats);
        for (point, share) in self.points.iter().zip(open) {
            self.seen.colors[point.state.pixel] = DVec3::splat(share);
        }
        self.report(samples.len())
    }

    /// Finds the points that samples see first, but for those that lanes may tell of. What is seen where no surface is goes to the colours.
    fn find_primary_hits(&mut self, samples: &[FilmSample], lanes_may_tell: bool) {
        self.stats.rays.camera += samples.len() as u64;
        self.points.clear();
        self.candidates.clear();
        self.seen.colors.clear();
        if self.view.is_pinhole() {
            self.trace_packets(samples, lanes_may_tell && self.packet_lights.is_some());
        } else {
            self.seen.colors.resize(samples.len(), DVec3::ZERO);
            self.trace_single_rays(samples);
        }
    }

    fn state(&self, pixel: usize, sample: &FilmSample, ray: &Ray) -> PathState {
        let media = if self.view.is_parallel() && self.context.lets_light_through {
            self.context.media_at(ray.origin)
        } else {
            self.media.clone()
        };
        let key = SampleKey::new(sample.pixel, sample.index);
        PathState { pixel, weight: DVec3::ONE, key, media, is_from_floor: false }
    }

    /// The colours of the samples and, where asked for, what they meet first.
    fn report(&mut self, samples: usize) -> &mut SampleResults {
        let Self { seen, points, candidates, looks, sight, context, view, .. } = self;
        seen.first_hits.clear();
        if !self.needs_first_hits {
            return seen;
        }
        seen.first_hits.resize(samples, None);
        for (point, &candidate) in points.iter().zip(&*candidates) {
            let id = match &point.place {
                SurfaceOwner::Instance(path) => candidate
                    .and_then(|candidate| looks.made(candidate))
                    .map_or_else(|| context.scene.instance_id(path), |look| look.id),
                SurfaceOwner::Floor => InstancePath::FLOOR_ID,
            };
            seen.first_hits[point.state.pixel] = Some(FirstHit {
                depth: view.depth(point.position) as f32,
                normal: point.facing_normal().as_vec3(),
                albedo: point.albedo.as_vec3(),
                id,
            });
        }
        for told in &sight.resolved {
            let Some(look) = looks.made(told.candidate) else { continue };
            let surfaces = &sight.surfaces[told.packet];
            for lane in bits(told.lanes & surfaces.lanes) {
                let pixel = told.packet * LANES + lane;
                let normal = surfaces.normal.each_ref().map(|column| column.0[lane]);
                seen.first_hits[pixel] = Some(FirstHit {
                    // The part of a camera ray's direction along the line of sight is 1.
                    depth: sight.surface_at(pixel).t as f32,
                    normal: Vec3::from_array(normal),
                    albedo: look.material.color.as_vec3(),
                    id: look.id,
                });
            }
        }
        seen
    }

    /// Rays of a camera with a lens, or of an orthographic one, each by itself.
    fn trace_single_rays(&mut self, samples: &[FilmSample]) {
        let mut wave = Wavefront::new(self.context, 0);
        for (pixel, sample) in samples.iter().enumerate() {
            let ray = self.view.sample_ray(sample);
            let state = self.state(pixel, sample, &ray);
            wave.push(TraceRay::new(ray).with_footprint(self.footprint), state);
        }
        self.points = wave.arrive(&mut self.seen.colors, &mut self.stats);
        self.candidates.resize(self.points.len(), None);
    }

    /// Rays from one place.
    fn trace_packets(&mut self, samples: &[FilmSample], lanes_may_tell: bool) {
        self.rays.start(self.view.position());
        for packet in samples.chunks(LANES) {
            let directions = self.arch.dispatch(PacketDirections { view: self.view, samples: packet });
            self.rays.extend(&directions, first_lanes(packet.len()));
        }
        self.beam.start_tile();
        self.looks.by_candidate.clear();
        self.beam.find(&self.rays, self.footprint, self.view.footprint(1));
        self.normal_maps.clear();
        if lanes_may_tell {
            self.normal_maps.resize(self.beam.candidate_count(), None);
            for found in self.beam.found() {
                let map = &mut self.normal_maps[found.candidate as usize];
                *map = self.looks.look(&self.beam, found.candidate).plain.as_ref().map(|(_, map)| *map);
            }
        }
        self.beam.resolve(&self.rays, &self.normal_maps, &mut self.sight);
        self.shade_misses(samples);
        self.prepare_lanes();
        for i in 0..self.sight.hits.len() {
            let (pixel, hit) = self.sight.hits[i];
            let (pixel, ray) = (pixel as usize, self.rays.ray(pixel as usize));
            let state = self.state(pixel, &samples[pixel], &ray);
            let point = self.point_of_hit(&ray, &hit, state);
            self.seen.colors[pixel] = DVec3::ZERO;
            self.points.push(point);
            self.candidates.push(Some(hit.candidate));
        }
    }

    /// The colours where nothing is, and the points of the floor, whose rays no longer count as those that meet something else.
    fn shade_misses(&mut self, samples: &[FilmSample]) {
        let RenderContext { environment, ground, .. } = self.context;
        if ground.is_none() && environment.sky.is_none() {
            self.seen.colors.resize(samples.len(), environment.background);
            return;
        }
        let mut nearest = vec![f64::INFINITY; samples.len()];
        for told in &self.sight.resolved {
            for lane in bits(told.lanes) {
                let pixel = told.packet * LANES + lane;
                nearest[pixel] = self.sight.surface_at(pixel).t;
            }
        }
        for (pixel, hit) in &self.sight.hits {
            nearest[*pixel as usize] = hit.t;
        }
        for (pixel, sample) in samples.iter().enumerate() {
            let ray = self.rays.ray(pixel);
            let on_floor = ground.and_then(|ground| Some((ground, ground.meet(&ray)?)));
            let color = if let Some((ground, t)) = on_floor.filter(|(_, t)| *t < nearest[pixel]) {
                nearest[pixel] = -1.0;
                self.sight.surfaces[pixel / LANES].lanes &= !(1 << (pixel % LANES));
                let state = self.state(pixel, sample, &ray);
                self.points.push(self.context.point_of_floor(&ground, &ray, t, self.footprint, state));
                self.candidates.push(None);
                DVec3::ZERO
            } else if nearest[pixel] == f64::INFINITY {
                self.context.sky(ray.direction)
            } else {
                DVec3::ZERO
            };
            self.seen.colors.push(color);
        }
        self.sight.hits.retain(|(pixel, _)| nearest[*pixel as usize] >= 0.0);
    }

    /// What the surfaces that lanes tell of are made of, and the ambient light on them.
    fn prepare_lanes(&mut self) {
        self.finishes.clear();
        self.finishes.resize(self.sight.surfaces.len(), PacketMaterials::NONE);
        for &SurfaceLanes { packet, candidate, lanes } in &self.sight.resolved {
            let look = self.looks.look(&self.beam, candidate);
            let lanes = lanes & self.sight.surfaces[packet].lanes;
            self.stats.proxy_hits += u64::from(look.primitive.is_none()) * u64::from(lanes.count_ones());
            if let Some((finish, _)) = &look.plain {
                let packet = &mut self.finishes[packet];
                self.arch.dispatch(SetMaterial { packet, lanes, finish });
            }
        }
        self.light.clear();
        self.light.extend(self.finishes.iter().map(PacketMaterials::ambient));
    }

    /// Takes what came to the surfaces that lanes tell of for the colours of their samples.
    fn write_lane_colors(&mut self) {
        for (packet, (surfaces, light)) in self.sight.surfaces.iter().zip(&self.light).enumerate() {
            for lane in bits(surfaces.lanes) {
                let [r, g, b] = light.each_ref().map(|column| f64::from(column.0[lane]));
                self.seen.colors[packet * LANES + lane] = DVec3::new(r, g, b);
            }
        }
    }

    /// Adds what lights bring to the points.
    fn add_light(&mut self) {
        let Self { context, view, .. } = *self;
        if !view.is_pinhole() {
            let (points, lights) = (&self.points, context.lights());
            direct::add_light(context, points, &lights, true, &mut self.seen.colors, &mut self.stats);
            return;
        }
        for (number, light) in context.lights().filter(|(_, light)| is_point(light)) {
            self.add_point_light(number as usize, light);
        }
        let others = context.lights().filter(|(_, light)| !is_point(light));
        direct::add_light(context, &self.points, &others, true, &mut self.seen.colors, &mut self.stats);
    }

    /// The surface at a hit.
    fn point_of_hit(&mut self, ray: &Ray, hit: &CandidateHit, state: PathState) -> SurfacePoint<'a> {
        let footprint = at_surface(self.footprint, ray, hit.t);
        let scene = self.context.scene;
        let look = self.looks.look(&self.beam, hit.candidate);
        let candidate = self.beam.candidate(hit.candidate);
        let world_from_unit = look.world_from_unit.get_or_init(|| candidate.world_from_unit());
        let own_error = 4.0 * f64::EPSILON * hit.unit_point.abs().max_element();
        let normal = unit_vector(look.normal_map * hit.gradient).unwrap_or(DVec3::Z);
        let position = world_from_unit.transform_point3(hit.unit_point);
        let direction = ray.direction.normalize();
        let albedo = match look.primitive {
            Some(primitive) if look.material.pattern != Pattern::None => {
                let seen = SurfaceView { normal, direction, width: footprint.width };
                let primitive = scene.primitive(primitive);
                albedo_of_shape(&look.material, primitive, hit.unit_point, world_from_unit, &seen)
            }
            _ => look.material.color,
        };
        let point = SurfacePoint {
            state: state.after(ray.origin, position),
            place: SurfaceOwner::Instance(Rc::clone(&look.path)),
            position,
            // Twice, for the rounding that the map itself carries.
            position_error: 2.0 * error_through(world_from_unit, hit.unit_point, own_error),
            normal,
            leaving: hit.leaving,
            to_eye: -direction,
            footprint,
            albedo,
            weights: LobeWeights::of(&look.material, direction.dot(normal).abs()),
            material: look.material.clone(),
        };
        self.stats.proxy_hits += u64::from(point.is_stand_in());
        point
    }

    /// Adds the light of one lamp, by its number, to all that it reaches.
    fn add_point_light(&mut self, number: usize, light: &Light) {
        let Some(place) = light.position() else { return };
        self.from_light.start(place);
        self.starts.clear();
        let width_at_lanes = self.queue_lane_shadows(number, place);
        let by_lanes = self.starts.len();
        let width = width_at_lanes.min(self.queue_point_shadows(light, place));
        if self.starts.is_empty() {
            return;
        }
        self.stats.rays.shadow += self.starts.len() as u64;
        let Self { context, beam, sight, rays, points, lit_points, lit_lanes, from_light, starts, .. } = self;
        let ray = |i: usize| {
            if let Some(point) = i.checked_sub(by_lanes) {
                return shadow_ray_of_point(&points[lit_points[point].0 as usize], place);
            }
            let lit = lit_lanes.partition_point(|lit| lit.first <= i).checked_sub(1);
            let sample = lit.and_then(|lit| lit_lanes[lit].sample(i)).unwrap_or_default();
            let LaneSurface { t, position_error: origin_error, .. } = sight.surface_at(sample);
            let direction = -from_light.direction(i);
            let ray = Ray { origin: place - direction, direction, origin_error };
            ShadowRay { ray, width: self.footprint.at(t) }
        };
        let shadow = ShadowRays { from_light, starts, ray: &ray };
        let stopped = beam.occluded(shadow, Footprint { width, spread: 0.0 });
        let is_stopped = |i: usize| stopped[i / LANES] >> (i % LANES) & 1 == 1;
        let mut dimmed = ShadowBatch::default();
        for (i, &(point, color)) in (by_lanes..).zip(&*lit_points) {
            let point = &points[point as usize];
            if !is_stopped(i) {
                let media = &point.state.media;
                self.seen.colors[point.state.pixel] +=
                    color * media.transmittance_between(point.position, place);
            } else if context.lets_light_through {
                dimmed.push(point, direct::toward(point, place - point.position), color);
            }
        }
        self.open.clear();
        self.open.resize(rays.directions().len(), 0);
        lit_lanes.iter().for_each(|lit| self.open[lit.of.packet] |= lit.open(&stopped));
        for ((light, shine), &lanes) in self.light.iter_mut().zip(&self.shines).zip(&self.open) {
            if lanes != 0 {
                self.arch.dispatch(AddContribution { light, shine, lanes });
            }
        }
        direct::add_transmitted(*context, dimmed, 1.0, &mut self.seen.colors, &mut self.stats);
    }

    /// Takes shadow rays from points to a light at `place`. Returns the least width of one.
    fn queue_point_shadows(&mut self, light: &Light, place: DVec3) -> f64 {
        self.lit_points.clear();
        let mut least_width = f64::INFINITY;
        for (number, (point, &own)) in (0..).zip(self.points.iter().zip(&self.candidates)) {
            let Some(way) = LightSample::to_middle(light, point.position) else { continue };
            let Some(color) = direct::lit(point, &way) else { continue };
            let ShadowRay { ray, width } = shadow_ray_of_point(point, place);
            let past_floor = self.context.transmittance_past_floor(&ray, own.is_none(), 1.0);
            if past_floor == 0.0 {
                continue;
            }
            least_width = least_width.min(width);
            self.from_light.push(-ray.direction);
            self.starts.push(ShadowStart { own, start: point.start(ray.direction) });
            self.lit_points.push((number, past_floor * point.state.weight * color));
        }
        least_width
    }

    /// The same from surfaces that lanes tell of.
    fn queue_lane_shadows(&mut self, number: usize, place: DVec3) -> f64 {
        self.lit_lanes.clear();
        let Some(light) = self.packet_lights.as_ref().and_then(|lights| lights.get(number)) else {
            return f64::INFINITY;
        };
        self.shines.resize(self.finishes.len(), PacketContribution::NONE);
        for (packet, (surfaces, finish)) in self.sight.surfaces.iter().zip(&self.finishes).enumerate() {
            let shine = &mut self.shines[packet];
            shine.lanes = 0;
            if surfaces.lanes != 0 {
                let directions = &self.sight.directions[packet];
                self.arch.dispatch(ShadePacket { light, directions, surfaces, finish, shine });
            }
        }
        // From the light to the camera.
        let way = self.rays.origin - place;
        let mut least_t = f64::INFINITY;
        let mut in_part = std::mem::take(&mut self.lit_in_part);
        for i in 0..self.sight.resolved.len() {
            let mut lit = self.sight.resolved[i];
            let shine = &mut self.shines[lit.packet];
            lit.lanes &= shine.lanes;
            if self.context.ground.is_some() {
                for lane in bits(lit.lanes) {
                    let sample = lit.packet * LANES + lane;
                    let LaneSurface { t, position_error: origin_error, .. } = self.sight.surface_at(sample);
                    let direction = way + t * self.rays.direction(sample);
                    let ray = Ray { origin: place + direction, direction: -direction, origin_error };
                    let past_floor = self.context.transmittance_past_floor(&ray, false, 1.0);
                    shine.color.iter_mut().for_each(|column| column.0[lane] *= past_floor as f32);
                    lit.lanes &= !(u32::from(past_floor == 0.0) << lane);
                }
            }
            match lit.lanes {
                0 => {}
                ALL_LANES => least_t = least_t.min(self.push_lanes(lit, way)),
                _ => in_part.push(lit),
            }
        }
        least_t = in_part.drain(..).fold(least_t, |least, lit| least.min(self.push_lanes(lit, way)));
        self.lit_in_part = in_part;
        // Rays grow no narrower.
        if least_t < f64::INFINITY { self.footprint.at(least_t) } else { f64::INFINITY }
    }

    /// Takes shadow rays from lanes of a packet to a light, from which `way` leads to the camera. Returns the least t of their camera rays.
    fn push_lanes(&mut self, lit: SurfaceLanes, way: DVec3) -> f64 {
        let (t, t_scale) = (&self.sight.surfaces[lit.packet].t, self.sight.t_scale);
        let rays = &self.rays.directions()[lit.packet];
        let directions = self.arch.dispatch(DirectionsFrom { rays, t, t_scale, offset: way });
        self.lit_lanes.push(LaneShadows { of: lit, first: self.starts.len() });
        self.from_light.extend(&directions, lit.lanes);
        let start = ShadowStart { own: Some(lit.candidate), start: RayStart::SurfaceOutward };
        self.starts.extend(std::iter::repeat_n(start, lit.lanes.count_ones() as usize));
        t_scale * f64::from(bits(lit.lanes).fold(f32::INFINITY, |least, lane| least.min(t.0[lane])))
    }
}

/// The ray from a point to a light.
fn shadow_ray_of_point(point: &SurfacePoint<'_>, light: DVec3) -> ShadowRay {
    let direction = light - point.position;
    let ray = Ray { origin: point.position, direction, origin_error: point.position_error };
    ShadowRay { ray, width: point.footprint.width }
}

impl<'a> SurfaceCache<'a> {
    fn made(&self, candidate: u32) -> Option<&PreparedSurface<'a>> {
        self.by_candidate.get(candidate as usize).and_then(Option::as_ref)
    }

    fn look(&mut self, beam: &PacketTracer<'_>, candidate: u32) -> &PreparedSurface<'a> {
        let scene = self.scene;
        if self.by_candidate.len() <= candidate as usize {
            self.by_candidate.resize(beam.candidate_count(), None);
        }
        self.by_candidate[candidate as usize].get_or_insert_with(|| {
            let path = Rc::new(beam.path(candidate));
            let candidate = beam.candidate(candidate);
            let (primitive, material) = match candidate.target {
                Target::Primitive(primitive) => {
                    let material = scene.material_of(scene.primitive(primitive));
                    (Some(primitive), MaterialRef::Scene(material))
                }
                Target::Proxy => (None, MaterialRef::Mean(Rc::new(scene.proxy_material(&path)))),
            };
            let normal_map = candidate.unit_from_world.matrix3.transpose();
            PreparedSurface {
                world_from_unit: OnceCell::new(),
                normal_map,
                plain: PlainMaterial::of(&material)
                    .and_then(|finish| Some((finish, f32_columns(&normal_map)?.0))),
                material,
                primitive,
                id: scene.instance_id(&path),
                path,
            }
        })
    }
}

/// Whether shadow rays of a tile can go as a beam: the light shines from one point.
fn is_point(light: &Light) -> bool {
    light.radius == 0.0 && light.position().is_some()
}
