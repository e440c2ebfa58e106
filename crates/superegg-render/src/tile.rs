//! A tile of the picture: camera rays as one beam where they begin at one place, and for each light that shines from one point the shadow rays as
//! another, seen from the light.

use std::cell::OnceCell;
use std::rc::Rc;

use pulp::Arch;
use superegg_geom::glam::{DAffine3, DMat3, DVec2, DVec3, Vec3};
use superegg_geom::lanes::beam::{ALL_LANES, PacketVectors};
use superegg_geom::{Ray, RayStart, error_through, unit_vector};
use superegg_scene::{AmbientOcclusion, Light, Pattern};

use crate::integrator::{Setting, Taken, Wave, at_surface};
use crate::lighting::{self, LightWay, ShadowRays};
use crate::medium::Media;
use crate::packet_light::{AddShine, Finish, PacketFinish, PacketLight, PacketShine, SetFinish, Shine};
use crate::point::{Arrival, MaterialRef, Place, Seen, SurfacePoint, albedo_of_shape};
use crate::sequence::SampleKey;
use crate::shading::Shares;
use crate::view::{PacketDirections, View};
use superegg_trace::beam::{
    self, Beam, BeamHit, Kind, LANES, NO_CANDIDATE, ShadowRay, ShadowStart, Sight, Told, f32_columns, lanes,
};
use superegg_trace::pencil::{DirectionsFrom, Pencil, first_lanes};
use superegg_trace::{CompiledScene, FlightRay, Footprint, InstancePath};

/// A sample of the picture.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FilmSample {
    /// The pixel, from the top left corner, and the number of the sample within it: what its random numbers are drawn from.
    pub(crate) pixel: (u32, u32),
    pub(crate) index: u32,
    /// The place on the film in pixels from the top left corner: the centre of the first pixel is (0.5, 0.5).
    pub(crate) film_px: DVec2,
}

/// What the camera rays of some samples see.
#[derive(Clone, Debug, Default)]
pub(crate) struct Sightings {
    /// Linear light.
    pub(crate) colors: Vec<DVec3>,
    /// The surface that each meets first; none unless they are asked for.
    pub(crate) firsts: Vec<Option<FirstSurface>>,
}

/// The surface that a camera ray meets first.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FirstSurface {
    /// Its distance from the plane of the camera, along the line of sight, in world units.
    pub(crate) depth: f32,
    /// The unit normal on the camera's side, in world space.
    pub(crate) normal: Vec3,
    /// The colour of the surface itself, linear.
    pub(crate) albedo: Vec3,
    /// A number that differs from instance to instance, never 0.
    pub(crate) id: u32,
}

/// Traces tiles, one after the other, in the same memory.
pub(crate) struct TileTracer<'a> {
    setting: Setting<'a>,
    view: &'a View,
    footprint: Footprint,
    /// What the camera is in.
    media: Media,
    pub(crate) taken: Taken,
    beam: Beam<'a>,
    /// Camera rays from one place, and what they see.
    rays: Pencil,
    sight: Sight,
    looks: Looks<'a>,
    /// The lights, where opaque surfaces are lit in lanes, and what they are lit by.
    packet_lights: Option<Vec<PacketLight>>,
    finishes: Vec<PacketFinish>,
    /// What the lights have brought to them so far, and what the next one will where nothing is between.
    light: Vec<PacketVectors>,
    shines: Vec<PacketShine>,
    /// The other points that the last samples see first, as many at most, and what light and sky bring to each sample.
    points: Vec<SurfacePoint<'a>>,
    seen: Sightings,
    asks_firsts: bool,
    /// The candidate of each point, or [`NO_CANDIDATE`].
    candidates: Vec<u32>,
    arch: Arch,
    /// Shadow rays: those of surfaces that lanes tell of, whole packets first, and then those of points, with the light that each gets if nothing is
    /// between.
    from_light: Pencil,
    starts: Vec<ShadowStart>,
    lit_lanes: Vec<LitLanes>,
    /// Those that are no whole packets, until the others are put in.
    lit_in_part: Vec<Told>,
    lit_points: Vec<(u32, DVec3)>,
    /// By packets the lanes of those that the light reaches.
    open: Vec<u32>,
}

/// Shadow rays from the surface of one candidate that lanes of a packet tell of.
struct LitLanes {
    of: Told,
    /// Where they begin among the shadow rays.
    first: usize,
}

impl LitLanes {
    /// The lanes that are open, by packets of shadow rays which of them are stopped.
    fn open(&self, stopped: &[u32]) -> u32 {
        let (packet, place) = (self.first / LANES, self.first % LANES);
        let next = stopped.get(packet + 1).copied().unwrap_or_default();
        let open = !((stopped[packet] | next << LANES) >> place);
        if self.of.lanes == ALL_LANES {
            return open & ALL_LANES;
        }
        lanes(self.of.lanes).enumerate().fold(0, |all, (ray, lane)| all | (open >> ray & 1) << lane)
    }

    /// The sample of a shadow ray, which is one of these.
    fn sample(&self, ray: usize) -> Option<usize> {
        Some(self.of.packet * LANES + lanes(self.of.lanes).nth(ray.checked_sub(self.first)?)?)
    }
}

/// What shading needs of candidates, each made when it is first shaded.
struct Looks<'a> {
    scene: &'a CompiledScene,
    by_candidate: Vec<Option<Look<'a>>>,
}

/// A candidate, ready to be shaded.
#[derive(Clone)]
struct Look<'a> {
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
    plain: Option<(Finish, [[f32; 3]; 3])>,
}

impl<'a> TileTracer<'a> {
    /// For pictures of so many samples a pixel; `asks_firsts` for what samples meet first, which takes some time.
    pub(crate) fn new(setting: Setting<'a>, view: &'a View, samples: u32, asks_firsts: bool) -> Self {
        Self {
            setting,
            view,
            footprint: view.footprint(samples),
            media: setting.media_at(view.position()),
            taken: Taken::default(),
            beam: Beam::new(setting.scene),
            rays: Pencil::default(),
            sight: Sight::default(),
            looks: Looks { scene: setting.scene, by_candidate: Vec::new() },
            packet_lights: PacketLight::all(&setting, view),
            finishes: Vec::new(),
            light: Vec::new(),
            shines: Vec::new(),
            points: Vec::new(),
            seen: Sightings::default(),
            asks_firsts,
            candidates: Vec::new(),
            arch: Arch::new(),
            from_light: Pencil::default(),
            starts: Vec::new(),
            lit_lanes: Vec::new(),
            lit_in_part: Vec::new(),
            lit_points: Vec::new(),
            open: Vec::new(),
        }
    }

    /// What each of some samples sees: at most [`superegg_trace::beam::MOST_RAYS`] of them, neighbours by the sixteen.
    pub(crate) fn trace(&mut self, samples: &[FilmSample]) -> &mut Sightings {
        self.meet_surfaces(samples, true);
        self.add_light();
        let mut wave = Wave::new(self.setting, 1);
        self.points.iter().for_each(|point| wave.leave(point, &mut self.seen.colors, &mut self.taken));
        wave.follow_all(&mut self.seen.colors, &mut self.taken);
        self.take_light_of_lanes();
        self.report(samples.len())
    }

    /// The same with the share of each surface's sky that is open instead of its light, and black where there is no surface.
    pub(crate) fn trace_occlusion(
        &mut self,
        samples: &[FilmSample],
        occlusion: AmbientOcclusion,
    ) -> &mut Sightings {
        self.meet_surfaces(samples, false);
        self.seen.colors.fill(DVec3::ZERO);
        let open = lighting::open_shares(self.setting, occlusion, &self.points, &mut self.taken);
        for (point, share) in self.points.iter().zip(open) {
            self.seen.colors[point.arrival.pixel] = DVec3::splat(share);
        }
        self.report(samples.len())
    }

    /// Finds the points that samples see first, but for those that lanes may tell of. What is seen where no surface is goes to the colours.
    fn meet_surfaces(&mut self, samples: &[FilmSample], lanes_may_tell: bool) {
        self.taken.rays.camera += samples.len() as u64;
        self.points.clear();
        self.candidates.clear();
        self.seen.colors.clear();
        if self.view.is_pinhole() {
            self.meet_by_beam(samples, lanes_may_tell && self.packet_lights.is_some());
        } else {
            self.seen.colors.resize(samples.len(), DVec3::ZERO);
            self.meet_apart(samples);
        }
    }

    fn arrival(&self, pixel: usize, sample: &FilmSample, ray: &Ray) -> Arrival {
        let media = if self.view.is_parallel() && self.setting.lets_light_through {
            self.setting.media_at(ray.origin)
        } else {
            self.media.clone()
        };
        let key = SampleKey::new(sample.pixel, sample.index);
        Arrival { pixel, weight: DVec3::ONE, key, media, is_from_floor: false }
    }

    /// The colours of the samples and, where asked for, what they meet first.
    fn report(&mut self, samples: usize) -> &mut Sightings {
        let Self { seen, points, candidates, looks, sight, setting, view, .. } = self;
        seen.firsts.clear();
        if !self.asks_firsts {
            return seen;
        }
        seen.firsts.resize(samples, None);
        for (point, &candidate) in points.iter().zip(&*candidates) {
            let id = match &point.place {
                Place::Instance(path) => {
                    looks.made(candidate).map_or_else(|| setting.scene.instance_id(path), |look| look.id)
                }
                Place::Floor => InstancePath::FLOOR_ID,
            };
            seen.firsts[point.arrival.pixel] = Some(FirstSurface {
                depth: view.depth(point.position) as f32,
                normal: point.facing_normal().as_vec3(),
                albedo: point.albedo.as_vec3(),
                id,
            });
        }
        for told in &sight.told {
            let Some(look) = looks.made(told.candidate) else { continue };
            let surfaces = &sight.surfaces[told.packet];
            for lane in lanes(told.lanes & surfaces.lanes) {
                let pixel = told.packet * LANES + lane;
                let normal = surfaces.normal.each_ref().map(|column| column.0[lane]);
                seen.firsts[pixel] = Some(FirstSurface {
                    // The part of a camera ray's direction along the line of sight is 1.
                    depth: sight.told(pixel).1 as f32,
                    normal: Vec3::from_array(normal),
                    albedo: look.material.color.as_vec3(),
                    id: look.id,
                });
            }
        }
        seen
    }

    /// Rays of a camera with a lens, or of an orthographic one, each by itself.
    fn meet_apart(&mut self, samples: &[FilmSample]) {
        let mut wave = Wave::new(self.setting, 0);
        for (pixel, sample) in samples.iter().enumerate() {
            let ray = self.view.sample_ray(sample);
            let arrival = self.arrival(pixel, sample, &ray);
            wave.push(FlightRay { ray, departure: None, footprint: self.footprint }, arrival);
        }
        self.points = wave.arrive(&mut self.seen.colors, &mut self.taken);
        self.candidates.resize(self.points.len(), NO_CANDIDATE);
    }

    /// Rays from one place.
    fn meet_by_beam(&mut self, samples: &[FilmSample], lanes_may_tell: bool) {
        self.rays.start(self.view.position());
        for packet in samples.chunks(LANES) {
            let directions = self.arch.dispatch(PacketDirections { view: self.view, samples: packet });
            self.rays.extend(&directions, first_lanes(packet.len()));
        }
        self.beam.start_tile();
        self.looks.by_candidate.clear();
        let looks = &mut self.looks;
        let pixel = self.view.footprint(1);
        self.beam.closest_but(&self.rays, self.footprint, pixel, &mut self.sight, |beam, candidate| {
            if lanes_may_tell { Some(looks.look(beam, candidate).plain?.1) } else { None }
        });
        self.meet_surroundings(samples);
        self.finish_lanes();
        for i in 0..self.sight.hits.len() {
            let (pixel, hit) = self.sight.hits[i];
            let (pixel, ray) = (pixel as usize, self.rays.ray(pixel as usize));
            let arrival = self.arrival(pixel, &samples[pixel], &ray);
            let point = self.point_of_hit(&ray, &hit, arrival);
            self.seen.colors[pixel] = DVec3::ZERO;
            self.points.push(point);
            self.candidates.push(hit.candidate);
        }
    }

    /// The colours where nothing is, and the points of the floor, whose rays no longer count as those that meet something else.
    fn meet_surroundings(&mut self, samples: &[FilmSample]) {
        let Setting { surroundings, ground, .. } = self.setting;
        if ground.is_none() && surroundings.sky.is_none() {
            self.seen.colors.resize(samples.len(), surroundings.background);
            return;
        }
        let mut nearest = vec![f64::INFINITY; samples.len()];
        for told in &self.sight.told {
            for lane in lanes(told.lanes) {
                let pixel = told.packet * LANES + lane;
                nearest[pixel] = self.sight.told(pixel).1;
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
                let arrival = self.arrival(pixel, sample, &ray);
                self.points.push(self.setting.point_of_floor(&ground, &ray, t, self.footprint, arrival));
                self.candidates.push(NO_CANDIDATE);
                DVec3::ZERO
            } else if nearest[pixel] == f64::INFINITY {
                self.setting.sky(ray.direction)
            } else {
                DVec3::ZERO
            };
            self.seen.colors.push(color);
        }
        self.sight.hits.retain(|(pixel, _)| nearest[*pixel as usize] >= 0.0);
    }

    /// What the surfaces that lanes tell of are made of, and the ambient light on them.
    fn finish_lanes(&mut self) {
        self.finishes.clear();
        self.finishes.resize(self.sight.surfaces.len(), PacketFinish::NONE);
        for &Told { packet, candidate, lanes } in &self.sight.told {
            let look = self.looks.look(&self.beam, candidate);
            let lanes = lanes & self.sight.surfaces[packet].lanes;
            self.taken.stand_ins += u64::from(look.primitive.is_none()) * u64::from(lanes.count_ones());
            if let Some((finish, _)) = &look.plain {
                let packet = &mut self.finishes[packet];
                self.arch.dispatch(SetFinish { packet, lanes, finish });
            }
        }
        self.light.clear();
        self.light.extend(self.finishes.iter().map(PacketFinish::ambient));
    }

    /// Takes what came to the surfaces that lanes tell of for the colours of their samples.
    fn take_light_of_lanes(&mut self) {
        for (packet, (surfaces, light)) in self.sight.surfaces.iter().zip(&self.light).enumerate() {
            for lane in lanes(surfaces.lanes) {
                let [r, g, b] = light.each_ref().map(|column| f64::from(column.0[lane]));
                self.seen.colors[packet * LANES + lane] = DVec3::new(r, g, b);
            }
        }
    }

    /// Adds what lights bring to the points.
    fn add_light(&mut self) {
        let Self { setting, view, .. } = *self;
        if !view.is_pinhole() {
            let (points, lights) = (&self.points, setting.lights());
            lighting::add_light(setting, points, &lights, true, &mut self.seen.colors, &mut self.taken);
            return;
        }
        for (number, light) in setting.lights().filter(|(_, light)| is_point(light)) {
            self.add_point_light(number as usize, light);
        }
        let others = setting.lights().filter(|(_, light)| !is_point(light));
        lighting::add_light(setting, &self.points, &others, true, &mut self.seen.colors, &mut self.taken);
    }

    /// The surface at a hit.
    fn point_of_hit(&mut self, ray: &Ray, hit: &BeamHit, arrival: Arrival) -> SurfacePoint<'a> {
        let footprint = at_surface(self.footprint, ray, hit.t);
        let scene = self.setting.scene;
        let look = self.looks.look(&self.beam, hit.candidate);
        let candidate = &self.beam.candidates[hit.candidate as usize];
        let world_from_unit = look.world_from_unit.get_or_init(|| candidate.world_from_unit());
        let own_error = 4.0 * f64::EPSILON * hit.unit_point.abs().max_element();
        let normal = unit_vector(look.normal_map * hit.gradient).unwrap_or(DVec3::Z);
        let position = world_from_unit.transform_point3(hit.unit_point);
        let direction = ray.direction.normalize();
        let albedo = match look.primitive {
            Some(primitive) if look.material.pattern != Pattern::None => {
                let seen = Seen { normal, direction, width: footprint.width };
                let primitive = scene.primitive(primitive);
                albedo_of_shape(&look.material, primitive, hit.unit_point, world_from_unit, &seen)
            }
            _ => look.material.color,
        };
        let point = SurfacePoint {
            arrival: arrival.after(ray.origin, position),
            place: Place::Instance(Rc::clone(&look.path)),
            position,
            // Twice, for the rounding that the map itself carries.
            position_error: 2.0 * error_through(world_from_unit, hit.unit_point, own_error),
            normal,
            leaving: hit.leaving,
            to_eye: -direction,
            footprint,
            albedo,
            shares: Shares::of(&look.material, direction.dot(normal).abs()),
            material: look.material.clone(),
        };
        self.taken.stand_ins += u64::from(point.is_stand_in());
        point
    }

    /// Adds the light of one lamp, by its number, to all that it reaches.
    fn add_point_light(&mut self, number: usize, light: &Light) {
        let Some(place) = light.position() else { return };
        self.from_light.start(place);
        self.starts.clear();
        let width_at_lanes = self.ask_for_lanes(number, place);
        let by_lanes = self.starts.len();
        let width = width_at_lanes.min(self.ask_for_points(light, place));
        if self.starts.is_empty() {
            return;
        }
        self.taken.rays.shadow += self.starts.len() as u64;
        let Self { setting, beam, sight, rays, points, lit_points, lit_lanes, from_light, starts, .. } = self;
        let ray = |i: usize| {
            if let Some(point) = i.checked_sub(by_lanes) {
                return shadow_ray_of_point(&points[lit_points[point].0 as usize], place);
            }
            let lit = lit_lanes.partition_point(|lit| lit.first <= i).checked_sub(1);
            let sample = lit.and_then(|lit| lit_lanes[lit].sample(i)).unwrap_or_default();
            let (_, t, origin_error) = sight.told(sample);
            let direction = -from_light.direction(i);
            let ray = Ray { origin: place - direction, direction, origin_error };
            ShadowRay { ray, width: self.footprint.at(t) }
        };
        let asked = beam::ShadowRays { from_light, starts, ray: &ray };
        let stopped = beam.occluded(asked, Footprint { width, spread: 0.0 });
        let is_stopped = |i: usize| stopped[i / LANES] >> (i % LANES) & 1 == 1;
        let mut dimmed = ShadowRays::default();
        for (i, &(point, color)) in (by_lanes..).zip(&*lit_points) {
            let point = &points[point as usize];
            if !is_stopped(i) {
                let media = &point.arrival.media;
                self.seen.colors[point.arrival.pixel] +=
                    color * media.transmittance_between(point.position, place);
            } else if setting.lets_light_through {
                dimmed.push(point, lighting::toward(point, place - point.position), color);
            }
        }
        self.open.clear();
        self.open.resize(rays.directions().len(), 0);
        lit_lanes.iter().for_each(|lit| self.open[lit.of.packet] |= lit.open(&stopped));
        for ((light, shine), &lanes) in self.light.iter_mut().zip(&self.shines).zip(&self.open) {
            if lanes != 0 {
                self.arch.dispatch(AddShine { light, shine, lanes });
            }
        }
        lighting::add_dimmed(*setting, dimmed, 1.0, &mut self.seen.colors, &mut self.taken);
    }

    /// Takes shadow rays from points to a light at `place`. Returns the least width of one.
    fn ask_for_points(&mut self, light: &Light, place: DVec3) -> f64 {
        self.lit_points.clear();
        let mut least_width = f64::INFINITY;
        for (number, (point, &own)) in (0..).zip(self.points.iter().zip(&self.candidates)) {
            let Some(way) = LightWay::to_middle(light, point.position) else { continue };
            let Some(color) = lighting::lit(point, &way) else { continue };
            let ShadowRay { ray, width } = shadow_ray_of_point(point, place);
            let past_ground = self.setting.share_past_ground(&ray, own == NO_CANDIDATE, 1.0);
            if past_ground == 0.0 {
                continue;
            }
            least_width = least_width.min(width);
            self.from_light.push(-ray.direction);
            self.starts.push(ShadowStart { own, start: point.start(ray.direction) });
            self.lit_points.push((number, past_ground * point.arrival.weight * color));
        }
        least_width
    }

    /// The same from surfaces that lanes tell of.
    fn ask_for_lanes(&mut self, number: usize, place: DVec3) -> f64 {
        self.lit_lanes.clear();
        let Some(light) = self.packet_lights.as_ref().and_then(|lights| lights.get(number)) else {
            return f64::INFINITY;
        };
        self.shines.resize(self.finishes.len(), PacketShine::NONE);
        for (packet, (surfaces, finish)) in self.sight.surfaces.iter().zip(&self.finishes).enumerate() {
            let shine = &mut self.shines[packet];
            shine.lanes = 0;
            if surfaces.lanes != 0 {
                let directions = &self.sight.directions[packet];
                self.arch.dispatch(Shine { light, directions, surfaces, finish, shine });
            }
        }
        // From the light to the camera.
        let way = self.rays.origin - place;
        let mut least_t = f64::INFINITY;
        let mut in_part = std::mem::take(&mut self.lit_in_part);
        for i in 0..self.sight.told.len() {
            let mut lit = self.sight.told[i];
            let shine = &mut self.shines[lit.packet];
            lit.lanes &= shine.lanes;
            if self.setting.ground.is_some() {
                for lane in lanes(lit.lanes) {
                    let sample = lit.packet * LANES + lane;
                    let (_, t, origin_error) = self.sight.told(sample);
                    let direction = way + t * self.rays.direction(sample);
                    let ray = Ray { origin: place + direction, direction: -direction, origin_error };
                    let past_ground = self.setting.share_past_ground(&ray, false, 1.0);
                    shine.color.iter_mut().for_each(|column| column.0[lane] *= past_ground as f32);
                    lit.lanes &= !(u32::from(past_ground == 0.0) << lane);
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
    fn push_lanes(&mut self, lit: Told, way: DVec3) -> f64 {
        let (t, t_scale) = (&self.sight.surfaces[lit.packet].t, self.sight.t_scale);
        let rays = &self.rays.directions()[lit.packet];
        let directions = self.arch.dispatch(DirectionsFrom { rays, t, t_scale, way });
        self.lit_lanes.push(LitLanes { of: lit, first: self.starts.len() });
        self.from_light.extend(&directions, lit.lanes);
        let start = ShadowStart { own: lit.candidate, start: RayStart::SurfaceOutward };
        self.starts.extend(std::iter::repeat_n(start, lit.lanes.count_ones() as usize));
        t_scale * f64::from(lanes(lit.lanes).fold(f32::INFINITY, |least, lane| least.min(t.0[lane])))
    }
}

/// The ray from a point to a light.
fn shadow_ray_of_point(point: &SurfacePoint<'_>, light: DVec3) -> ShadowRay {
    let direction = light - point.position;
    let ray = Ray { origin: point.position, direction, origin_error: point.position_error };
    ShadowRay { ray, width: point.footprint.width }
}

impl<'a> Looks<'a> {
    fn made(&self, candidate: u32) -> Option<&Look<'a>> {
        self.by_candidate.get(candidate as usize).and_then(Option::as_ref)
    }

    fn look(&mut self, beam: &Beam<'_>, candidate: u32) -> &Look<'a> {
        let scene = self.scene;
        if self.by_candidate.len() <= candidate as usize {
            self.by_candidate.resize(beam.candidates.len(), None);
        }
        self.by_candidate[candidate as usize].get_or_insert_with(|| {
            let path = Rc::new(beam.path(candidate));
            let candidate = &beam.candidates[candidate as usize];
            let (primitive, material) = match candidate.kind {
                Kind::Primitive(primitive) => {
                    let material = scene.material_of(scene.primitive(primitive));
                    (Some(primitive), MaterialRef::Scene(material))
                }
                Kind::StandIn => (None, MaterialRef::Mean(Rc::new(scene.stand_in_material(&path)))),
            };
            let normal_map = candidate.unit_from_world.matrix3.transpose();
            Look {
                world_from_unit: OnceCell::new(),
                normal_map,
                plain: Finish::of(&material).and_then(|finish| Some((finish, f32_columns(&normal_map)?.0))),
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
