//! A tile of the picture: camera rays as one beam where they begin at one place, and for each light that shines from one point the shadow rays as
//! another, seen from the light.

use std::cell::OnceCell;
use std::rc::Rc;

use pulp::Arch;
use superegg_geom::glam::{DAffine3, DMat3, DVec2, DVec3, Vec3};
use superegg_geom::{Ray, RayStart, error_through, unit_vector};
use superegg_scene::{AmbientOcclusion, Light, Pattern};

use crate::beam::{Beam, BeamHit, Kind, LANES, NO_CANDIDATE, ShadowRay, f32_columns, lanes};
use crate::compiled::CompiledScene;
use crate::flight::FlightRay;
use crate::footprint::Footprint;
use crate::integrator::{Setting, Taken, Wave, at_surface};
use crate::lighting::{self, LightWay, ShadowRays};
use crate::medium::Media;
use crate::packet_light::{Finish, PacketFinish, PacketLight, Shine};
use crate::path::InstancePath;
use crate::point::{Arrival, MaterialRef, Place, Seen, SurfacePoint, albedo_of_shape};
use crate::sequence::{SampleKey, disc};
use crate::shading::Shares;
use crate::view::View;

/// A sample of the picture.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FilmSample {
    /// The pixel, from the top left corner, and the number of the sample within it: what its random numbers are drawn from.
    pub(crate) pixel: (u32, u32),
    pub(crate) index: u32,
    /// The place on the film in pixels from the top left corner: the centre of the first pixel is (0.5, 0.5).
    pub(crate) film_px: DVec2,
}

/// What a camera ray sees.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sighting {
    /// Linear light.
    pub(crate) color: DVec3,
    /// The surface that it meets first.
    pub(crate) first: Option<FirstSurface>,
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
    rays: Vec<Ray>,
    hits: Vec<Option<BeamHit>>,
    looks: Looks<'a>,
    /// The lights, where opaque surfaces are lit in lanes, and what they are lit by.
    packet_lights: Option<Vec<PacketLight>>,
    finishes: Vec<PacketFinish>,
    /// The points that the last samples see first, as many at most, and what light and sky bring to each sample.
    points: Vec<SurfacePoint<'a>>,
    colors: Vec<DVec3>,
    /// The candidate of each point, or [`NO_CANDIDATE`].
    candidates: Vec<u32>,
    arch: Arch,
    shadow_rays: Vec<ShadowRay>,
    /// What each shadow ray brings if nothing stops it.
    lit: Vec<Lit>,
    stopped: Vec<bool>,
}

/// The light of a shadow ray.
#[derive(Clone, Copy, Debug)]
struct Lit {
    /// The place of the sample.
    pixel: usize,
    /// The number of its point; `None` where lanes have lit it.
    point: Option<usize>,
    color: DVec3,
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

/// The choice of a [`SampleKey`] for the place on the lens.
const LENS: u32 = 0;

impl<'a> TileTracer<'a> {
    /// For pictures of so many samples a pixel.
    pub(crate) fn new(setting: Setting<'a>, view: &'a View, samples: u32) -> Self {
        Self {
            setting,
            view,
            footprint: view.footprint(samples),
            media: setting.media_at(view.position()),
            taken: Taken::default(),
            beam: Beam::new(setting.scene),
            rays: Vec::new(),
            hits: Vec::new(),
            looks: Looks { scene: setting.scene, by_candidate: Vec::new() },
            packet_lights: PacketLight::all(&setting, view),
            finishes: Vec::new(),
            points: Vec::new(),
            colors: Vec::new(),
            candidates: Vec::new(),
            arch: Arch::new(),
            shadow_rays: Vec::new(),
            lit: Vec::new(),
            stopped: Vec::new(),
        }
    }

    /// What each of some samples sees: at most [`crate::beam::MOST_RAYS`] of them, neighbours by the sixteen.
    pub(crate) fn trace(&mut self, samples: &[FilmSample], seen: &mut Vec<Sighting>) {
        self.meet_surfaces(samples, true);
        self.add_light();
        let mut wave = Wave::new(self.setting, 1);
        self.points.iter().for_each(|point| wave.leave(point, &mut self.colors, &mut self.taken));
        wave.follow_all(&mut self.colors, &mut self.taken);
        self.report(seen);
    }

    /// The same with the share of each surface's sky that is open instead of its light, and black where there is no surface.
    pub(crate) fn trace_occlusion(
        &mut self,
        samples: &[FilmSample],
        occlusion: AmbientOcclusion,
        seen: &mut Vec<Sighting>,
    ) {
        self.meet_surfaces(samples, false);
        self.colors.fill(DVec3::ZERO);
        let open = lighting::open_shares(self.setting, occlusion, &self.points, &mut self.taken);
        for (point, share) in self.points.iter().zip(open) {
            self.colors[point.arrival.pixel] = DVec3::splat(share);
        }
        self.report(seen);
    }

    /// Finds the points that samples see first, but for those that lanes may tell of. What is seen where no surface is goes to the colours.
    fn meet_surfaces(&mut self, samples: &[FilmSample], lanes_may_tell: bool) {
        self.taken.rays.camera += samples.len() as u64;
        self.colors.clear();
        self.colors.resize(samples.len(), DVec3::ZERO);
        self.points.clear();
        self.candidates.clear();
        let mut rays = std::mem::take(&mut self.rays);
        rays.clear();
        rays.extend(samples.iter().map(|sample| self.ray(sample)));
        if self.view.is_pinhole() {
            self.meet_by_beam(samples, &rays, lanes_may_tell && self.packet_lights.is_some());
        } else {
            self.meet_apart(samples, &rays);
        }
        self.rays = rays;
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

    /// The colours of the samples with what the film keeps of their points.
    fn report(&self, seen: &mut Vec<Sighting>) {
        seen.clear();
        seen.extend(self.colors.iter().map(|&color| Sighting { color, first: None }));
        for (point, &candidate) in self.points.iter().zip(&self.candidates) {
            let look = self.looks.made(candidate);
            let id = match &point.place {
                Place::Instance(path) => {
                    look.map_or_else(|| self.setting.scene.instance_id(path), |look| look.id)
                }
                Place::Floor => InstancePath::FLOOR_ID,
            };
            seen[point.arrival.pixel].first = Some(FirstSurface {
                depth: self.view.depth(point.position) as f32,
                normal: point.facing_normal().as_vec3(),
                albedo: point.albedo.as_vec3(),
                id,
            });
        }
        for (packet, surfaces) in self.beam.surfaces.iter().enumerate() {
            for lane in lanes(surfaces.lanes) {
                let pixel = packet * LANES + lane;
                let (candidate, t, _) = self.beam.told(pixel);
                let Some(look) = self.looks.made(candidate) else { continue };
                let normal = surfaces.normal.each_ref().map(|column| column.0[lane]);
                seen[pixel].first = Some(FirstSurface {
                    // The part of a camera ray's direction along the line of sight is 1.
                    depth: t as f32,
                    normal: Vec3::from_array(normal),
                    albedo: look.material.color.as_vec3(),
                    id: look.id,
                });
            }
        }
    }

    /// The camera ray of a sample.
    pub(crate) fn ray(&self, sample: &FilmSample) -> Ray {
        if !self.view.has_lens() {
            return self.view.ray(sample.film_px);
        }
        let key = SampleKey::new(sample.pixel, sample.index).branch(LENS);
        self.view.lens_ray(sample.film_px, disc(key.point(0, 1)))
    }

    /// Rays of a camera with a lens, or of an orthographic one, each by itself.
    fn meet_apart(&mut self, samples: &[FilmSample], rays: &[Ray]) {
        let mut wave = Wave::new(self.setting, 0);
        for (pixel, (ray, sample)) in rays.iter().zip(samples).enumerate() {
            let arrival = self.arrival(pixel, sample, ray);
            wave.push(FlightRay { ray: *ray, departure: None, footprint: self.footprint }, arrival);
        }
        self.points = wave.arrive(&mut self.colors, &mut self.taken);
        self.candidates.resize(self.points.len(), NO_CANDIDATE);
    }

    /// Rays from one place.
    fn meet_by_beam(&mut self, samples: &[FilmSample], rays: &[Ray], lanes_may_tell: bool) {
        self.beam.start_tile();
        self.looks.by_candidate.clear();
        let mut hits = std::mem::take(&mut self.hits);
        let looks = &mut self.looks;
        self.beam.closest_but(rays, self.footprint, &mut hits, |beam, candidate| {
            if lanes_may_tell { Some(looks.look(beam, candidate).plain?.1) } else { None }
        });
        self.finishes.clear();
        self.finishes.resize(self.beam.surfaces.len(), PacketFinish::NONE);
        for (pixel, (ray, hit)) in rays.iter().zip(&hits).enumerate() {
            let (packet, lane) = (pixel / LANES, pixel % LANES);
            let told = self.beam.surfaces[packet].lanes >> lane & 1 == 1;
            let told = told.then(|| self.beam.told(pixel));
            let nearest = told.map(|(_, t, _)| t).or_else(|| Some(hit.as_ref()?.t));
            let ground = self.setting.ground.and_then(|ground| Some((ground, ground.meet(ray)?)));
            if let Some((ground, t)) = ground.filter(|(_, t)| nearest.is_none_or(|nearest| *t < nearest)) {
                self.beam.surfaces[packet].lanes &= !(1 << lane);
                let arrival = self.arrival(pixel, &samples[pixel], ray);
                self.points.push(self.setting.point_of_floor(&ground, ray, t, self.footprint, arrival));
                self.candidates.push(NO_CANDIDATE);
            } else if let Some((candidate, ..)) = told {
                let look = self.looks.look(&self.beam, candidate);
                self.taken.stand_ins += u64::from(look.primitive.is_none());
                if let Some((finish, _)) = &look.plain {
                    self.finishes[packet].set(lane, finish);
                    self.colors[pixel] += finish.ambient;
                }
            } else if let Some(hit) = hit {
                let arrival = self.arrival(pixel, &samples[pixel], ray);
                let point = self.point_of_hit(ray, hit, arrival);
                self.points.push(point);
                self.candidates.push(hit.candidate);
            } else {
                let arrival = self.arrival(pixel, &samples[pixel], ray);
                self.colors[pixel] += arrival.weight * self.setting.sky(ray.direction);
            }
        }
        self.hits = hits;
    }

    /// Adds what lights bring to the points.
    fn add_light(&mut self) {
        let Self { setting, view, .. } = *self;
        if !view.is_pinhole() {
            let (points, lights) = (&self.points, setting.lights());
            lighting::add_light(setting, points, &lights, true, &mut self.colors, &mut self.taken);
            return;
        }
        for (number, light) in setting.lights().filter(|(_, light)| is_point(light)) {
            self.add_point_light(number as usize, light);
        }
        let others = setting.lights().filter(|(_, light)| !is_point(light));
        lighting::add_light(setting, &self.points, &others, true, &mut self.colors, &mut self.taken);
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
                let primitive = &scene.primitives[primitive as usize];
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
        self.shadow_rays.clear();
        self.lit.clear();
        for (number, (point, &own)) in self.points.iter().zip(&self.candidates).enumerate() {
            let Some(way) = LightWay::to_middle(light, point.position) else { continue };
            let Some(color) = lighting::lit(point, &way) else { continue };
            let ray =
                Ray { origin: point.position, direction: way.direction, origin_error: point.position_error };
            let past_ground = self.setting.share_past_ground(&ray, own == NO_CANDIDATE, 1.0);
            if past_ground == 0.0 {
                continue;
            }
            let (start, width) = (point.start(way.direction), point.footprint.width);
            self.shadow_rays.push(ShadowRay { ray, own, start, width });
            let (pixel, color) = (point.arrival.pixel, past_ground * point.arrival.weight * color);
            self.lit.push(Lit { pixel, point: Some(number), color });
        }
        self.shine_on_packets(number, place);
        if self.lit.is_empty() {
            return;
        }
        self.taken.rays.shadow += self.lit.len() as u64;
        let width = self.shadow_rays.iter().map(|ray| ray.width).fold(f64::INFINITY, f64::min);
        let footprint = Footprint { width, spread: 0.0 };
        self.beam.occluded(place, &self.shadow_rays, footprint, &mut self.stopped);
        let mut dimmed = ShadowRays::default();
        for (&Lit { pixel, point, color }, &stopped) in self.lit.iter().zip(&self.stopped) {
            match point.map(|number| &self.points[number]) {
                None if !stopped => self.colors[pixel] += color,
                Some(point) if !stopped => {
                    let media = &point.arrival.media;
                    self.colors[pixel] += color * media.transmittance_between(point.position, place);
                }
                Some(point) if self.setting.lets_light_through => {
                    dimmed.push(point, lighting::toward(point, place - point.position), color);
                }
                _ => {}
            }
        }
        lighting::add_dimmed(self.setting, dimmed, 1.0, &mut self.colors, &mut self.taken);
    }

    /// Takes shadow rays from what lanes tell of to a light at `place`.
    fn shine_on_packets(&mut self, number: usize, place: DVec3) {
        let Some(light) = self.packet_lights.as_ref().and_then(|lights| lights.get(number)) else { return };
        for (packet, (surfaces, finish)) in self.beam.surfaces.iter().zip(&self.finishes).enumerate() {
            if surfaces.lanes == 0 {
                continue;
            }
            let directions = &self.beam.surface_directions[packet];
            let shine = self.arch.dispatch(Shine { light, directions, surfaces, finish });
            for lane in lanes(shine.lanes) {
                let pixel = packet * LANES + lane;
                let (own, t, error) = self.beam.told(pixel);
                let origin = self.rays[pixel].point_at(t);
                let ray = Ray { origin, direction: place - origin, origin_error: error };
                let past_ground = self.setting.share_past_ground(&ray, false, 1.0);
                if past_ground == 0.0 {
                    continue;
                }
                let width = self.footprint.at(t);
                self.shadow_rays.push(ShadowRay { ray, own, start: RayStart::SurfaceOutward, width });
                let color = shine.color.each_ref().map(|column| f64::from(column.0[lane]));
                self.lit.push(Lit { pixel, point: None, color: past_ground * DVec3::from_array(color) });
            }
        }
    }
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
                    let material = scene.primitives[primitive as usize].material;
                    (Some(primitive), MaterialRef::Scene(&scene.materials[material as usize]))
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
