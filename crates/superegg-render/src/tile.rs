//! A tile of the picture: camera rays as one beam where they begin at one place, and for each light that shines from one point the shadow rays as
//! another, seen from the light.

use std::rc::Rc;

use superegg_geom::glam::{DAffine3, DMat3, DVec2, DVec3};
use superegg_geom::{Ray, error_through, unit_vector};
use superegg_scene::{AmbientOcclusion, Light, Pattern};

use crate::beam::{Beam, BeamHit, Kind, NO_CANDIDATE, ShadowRay};
use crate::flight::FlightRay;
use crate::footprint::Footprint;
use crate::integrator::{Setting, Taken, Wave, at_surface};
use crate::lighting::{self, LightWay, ShadowRays};
use crate::medium::Media;
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
    pub(crate) depth: f64,
    /// The unit normal on the camera's side, in world space.
    pub(crate) normal: DVec3,
    /// The colour of the surface itself, linear.
    pub(crate) albedo: DVec3,
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
    /// What shading needs of a candidate, made when it is first shaded.
    looks: Vec<Option<Look<'a>>>,
    /// The points that the last samples see first, as many at most, and what light and sky bring to each sample.
    points: Vec<SurfacePoint<'a>>,
    colors: Vec<DVec3>,
    /// The candidate of each point, or [`NO_CANDIDATE`].
    candidates: Vec<u32>,
    shadow_rays: Vec<ShadowRay>,
    /// The point of each shadow ray, and what light comes that way if nothing stops it.
    lit: Vec<(usize, DVec3)>,
    stopped: Vec<bool>,
}

/// A candidate, ready to be shaded.
#[derive(Clone)]
struct Look<'a> {
    world_from_unit: DAffine3,
    /// Brings gradients into the world.
    normal_map: DMat3,
    material: MaterialRef<'a>,
    /// Of a primitive.
    primitive: Option<u32>,
    path: Rc<InstancePath>,
    id: u32,
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
            looks: Vec::new(),
            points: Vec::new(),
            colors: Vec::new(),
            candidates: Vec::new(),
            shadow_rays: Vec::new(),
            lit: Vec::new(),
            stopped: Vec::new(),
        }
    }

    /// What each of some samples sees: at most [`crate::beam::MOST_RAYS`] of them, neighbours by the sixteen.
    pub(crate) fn trace(&mut self, samples: &[FilmSample], seen: &mut Vec<Sighting>) {
        self.meet_surfaces(samples);
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
        self.meet_surfaces(samples);
        self.colors.fill(DVec3::ZERO);
        let open = lighting::open_shares(self.setting, occlusion, &self.points, &mut self.taken);
        for (point, share) in self.points.iter().zip(open) {
            self.colors[point.arrival.pixel] = DVec3::splat(share);
        }
        self.report(seen);
    }

    /// Finds the points that samples see first. What is seen where no surface is goes to the colours.
    fn meet_surfaces(&mut self, samples: &[FilmSample]) {
        self.taken.rays.camera += samples.len() as u64;
        self.colors.clear();
        self.colors.resize(samples.len(), DVec3::ZERO);
        self.points.clear();
        self.candidates.clear();
        let mut rays = std::mem::take(&mut self.rays);
        rays.clear();
        rays.extend(samples.iter().map(|sample| self.ray(sample)));
        if self.view.is_pinhole() {
            self.meet_by_beam(samples, &rays);
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
            let look = self.looks.get(candidate as usize).and_then(Option::as_ref);
            let id = match &point.place {
                Place::Instance(path) => {
                    look.map_or_else(|| self.setting.scene.instance_id(path), |look| look.id)
                }
                Place::Floor => InstancePath::FLOOR_ID,
            };
            seen[point.arrival.pixel].first = Some(FirstSurface {
                depth: self.view.depth(point.position),
                normal: point.facing_normal(),
                albedo: point.albedo,
                id,
            });
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
    fn meet_by_beam(&mut self, samples: &[FilmSample], rays: &[Ray]) {
        self.beam.start_tile();
        self.looks.clear();
        let mut hits = std::mem::take(&mut self.hits);
        self.beam.closest(rays, self.footprint, &mut hits);
        self.looks.resize(self.beam.candidates.len(), None);
        for (pixel, (ray, hit)) in rays.iter().zip(&hits).enumerate() {
            let ground = self.setting.ground.and_then(|ground| Some((ground, ground.meet(ray)?)));
            match (ground, hit) {
                (Some((ground, t)), hit) if hit.is_none_or(|hit| t < hit.t) => {
                    let arrival = self.arrival(pixel, &samples[pixel], ray);
                    let point = self.setting.point_of_floor(&ground, ray, t, self.footprint, arrival);
                    self.points.push(point);
                    self.candidates.push(NO_CANDIDATE);
                }
                (_, Some(hit)) => {
                    let arrival = self.arrival(pixel, &samples[pixel], ray);
                    let point = self.point_of_hit(ray, hit, arrival);
                    self.points.push(point);
                    self.candidates.push(hit.candidate);
                }
                (_, None) => {
                    let arrival = self.arrival(pixel, &samples[pixel], ray);
                    self.colors[pixel] += arrival.weight * self.setting.sky(ray.direction);
                }
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
        for light in setting.surroundings.lights.iter().filter(|light| is_point(light)) {
            self.add_point_light(light);
        }
        let others = setting.lights().filter(|(_, light)| !is_point(light));
        lighting::add_light(setting, &self.points, &others, true, &mut self.colors, &mut self.taken);
    }

    fn look(&mut self, candidate: u32) -> &Look<'a> {
        let (scene, beam) = (self.setting.scene, &self.beam);
        self.looks[candidate as usize].get_or_insert_with(|| {
            let path = Rc::new(beam.path(candidate));
            let candidate = &beam.candidates[candidate as usize];
            let (primitive, material) = match candidate.kind {
                Kind::Primitive(primitive) => {
                    let material = scene.primitives[primitive as usize].material;
                    (Some(primitive), MaterialRef::Scene(&scene.materials[material as usize]))
                }
                Kind::StandIn => (None, MaterialRef::Mean(Rc::new(scene.stand_in_material(&path)))),
            };
            Look {
                world_from_unit: candidate.world_from_unit(),
                normal_map: candidate.unit_from_world.matrix3.transpose(),
                material,
                primitive,
                id: scene.instance_id(&path),
                path,
            }
        })
    }

    /// The surface at a hit.
    fn point_of_hit(&mut self, ray: &Ray, hit: &BeamHit, arrival: Arrival) -> SurfacePoint<'a> {
        let footprint = at_surface(self.footprint, ray, hit.t);
        let scene = self.setting.scene;
        let look = self.look(hit.candidate);
        let own_error = 4.0 * f64::EPSILON * hit.unit_point.abs().max_element();
        let normal = unit_vector(look.normal_map * hit.gradient).unwrap_or(DVec3::Z);
        let position = look.world_from_unit.transform_point3(hit.unit_point);
        let direction = ray.direction.normalize();
        let albedo = match look.primitive {
            Some(primitive) if look.material.pattern != Pattern::None => {
                let seen = Seen { normal, direction, width: footprint.width };
                let primitive = &scene.primitives[primitive as usize];
                albedo_of_shape(&look.material, primitive, hit.unit_point, &look.world_from_unit, &seen)
            }
            _ => look.material.color,
        };
        let point = SurfacePoint {
            arrival: arrival.after(ray.origin, position),
            place: Place::Instance(Rc::clone(&look.path)),
            position,
            // Twice, for the rounding that the map itself carries.
            position_error: 2.0 * error_through(&look.world_from_unit, hit.unit_point, own_error),
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

    /// Adds the light of one lamp to all points that it reaches.
    fn add_point_light(&mut self, light: &Light) {
        let Some(place) = light.position() else { return };
        self.shadow_rays.clear();
        self.lit.clear();
        let mut least_width = f64::INFINITY;
        for (number, (point, &own)) in self.points.iter().zip(&self.candidates).enumerate() {
            let Some(way) = LightWay::to_middle(light, point.position) else { continue };
            let Some(color) = lighting::lit(point, &way) else { continue };
            let ray =
                Ray { origin: point.position, direction: way.direction, origin_error: point.position_error };
            let past_ground = self.setting.share_past_ground(&ray, own == NO_CANDIDATE, 1.0);
            if past_ground == 0.0 {
                continue;
            }
            let width = point.footprint.width;
            least_width = least_width.min(width);
            self.shadow_rays.push(ShadowRay { ray, own, start: point.start(way.direction), width });
            self.lit.push((number, past_ground * point.arrival.weight * color));
        }
        if self.lit.is_empty() {
            return;
        }
        self.taken.rays.shadow += self.lit.len() as u64;
        let footprint = Footprint { width: least_width, spread: 0.0 };
        self.beam.occluded(place, &self.shadow_rays, footprint, &mut self.stopped);
        let mut dimmed = ShadowRays::default();
        for (&(number, color), &stopped) in self.lit.iter().zip(&self.stopped) {
            let point = &self.points[number];
            if !stopped {
                let Arrival { pixel, media, .. } = &point.arrival;
                self.colors[*pixel] += color * media.transmittance_between(point.position, place);
            } else if self.setting.lets_light_through {
                dimmed.push(point, lighting::toward(point, place - point.position), color);
            }
        }
        lighting::add_dimmed(self.setting, dimmed, 1.0, &mut self.colors, &mut self.taken);
    }
}

/// Whether shadow rays of a tile can go as a beam: the light shines from one point.
fn is_point(light: &Light) -> bool {
    light.radius == 0.0 && light.position().is_some()
}
