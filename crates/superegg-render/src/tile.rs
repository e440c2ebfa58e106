//! A tile of the picture: camera rays as one beam where they begin at one place, and for each light that shines from one point the shadow rays as
//! another, seen from the light.

use std::rc::Rc;

use superegg_geom::glam::{DAffine3, DVec2, DVec3};
use superegg_geom::{Ray, RayStart, error_through, unit_vector};
use superegg_scene::{Light, Pattern};

use crate::beam::{Beam, BeamHit, Kind, LANES, NO_CANDIDATE, Shadow};
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

/// Traces tiles, one after the other.
pub(crate) struct TileTracer<'a> {
    setting: Setting<'a>,
    view: &'a View,
    footprint: Footprint,
    /// What the camera is in.
    media: Media,
    pub(crate) taken: Taken,
    beam: Beam<'a>,
    hits: Vec<Option<BeamHit>>,
    /// What shading needs of a candidate, made when it is first shaded.
    looks: Vec<Option<Look<'a>>>,
}

/// A candidate, ready to be shaded.
#[derive(Clone)]
struct Look<'a> {
    world_from_unit: DAffine3,
    material: MaterialRef<'a>,
    /// Of a primitive.
    primitive: Option<u32>,
    path: Rc<InstancePath>,
}

/// The choice of a [`SampleKey`] for the place on the lens.
const LENS: u32 = 0;

impl<'a> TileTracer<'a> {
    /// For pictures of so many samples a pixel.
    pub(crate) fn new(setting: Setting<'a>, view: &'a View, samples: u32) -> Self {
        let beam = Beam::new(setting.scene);
        let media = setting.media_at(view.position());
        let footprint = view.footprint(samples);
        let taken = Taken::default();
        Self { setting, view, footprint, media, taken, beam, hits: Vec::new(), looks: Vec::new() }
    }

    /// What each of some samples sees: at most [`crate::beam::MOST_RAYS`] of them, neighbours by the sixteen.
    pub(crate) fn trace(&mut self, samples: &[FilmSample]) -> Vec<Sighting> {
        let mut colors = vec![DVec3::ZERO; samples.len()];
        let points = self.first_points(samples, &mut colors);
        let firsts = self.first_surfaces(samples.len(), &points);
        let mut wave = Wave::new(self.setting, 1);
        points.iter().for_each(|point| wave.leave(point, &mut colors, &mut self.taken));
        wave.follow_all(&mut colors, &mut self.taken);
        colors.into_iter().zip(firsts).map(|(color, first)| Sighting { color, first }).collect()
    }

    /// The points of surfaces that some samples see first, as many at most. What comes to them straight from lights, and what is seen where no
    /// surface is, is added to the colours of the samples.
    pub(crate) fn first_points(
        &mut self,
        samples: &[FilmSample],
        colors: &mut [DVec3],
    ) -> Vec<SurfacePoint<'a>> {
        self.taken.rays.camera += samples.len() as u64;
        let rays: Vec<Ray> = samples.iter().map(|sample| self.ray(sample)).collect();
        let arrivals = samples.iter().enumerate().map(|(pixel, sample)| Arrival {
            pixel,
            weight: DVec3::ONE,
            key: SampleKey::new(sample.pixel, sample.index),
            media: if self.view.is_parallel() {
                self.setting.media_at(rays[pixel].origin)
            } else {
                self.media.clone()
            },
            is_from_floor: false,
        });
        let arrivals: Vec<Arrival> = arrivals.collect();
        if self.view.is_pinhole() {
            self.trace_beam(&rays, arrivals, colors)
        } else {
            self.trace_apart(&rays, arrivals, colors)
        }
    }

    /// What the film keeps of the points that so many samples see first.
    pub(crate) fn first_surfaces(
        &self,
        samples: usize,
        points: &[SurfacePoint<'_>],
    ) -> Vec<Option<FirstSurface>> {
        let mut firsts: Vec<Option<FirstSurface>> = vec![None; samples];
        for point in points {
            firsts[point.arrival.pixel] = Some(FirstSurface {
                depth: self.view.depth(point.position),
                normal: point.facing_normal(),
                albedo: point.albedo,
                id: match &point.place {
                    Place::Instance(path) => self.setting.scene.instance_id(path),
                    Place::Floor => InstancePath::FLOOR_ID,
                },
            });
        }
        firsts
    }

    /// The camera ray of a sample.
    pub(crate) fn ray(&self, sample: &FilmSample) -> Ray {
        if !self.view.has_lens() {
            return self.view.ray(sample.film_px);
        }
        let key = SampleKey::new(sample.pixel, sample.index).branch(LENS);
        self.view.lens_ray(sample.film_px, disc(key.point(0, 1)))
    }

    /// Rays of a camera with a lens, or of an orthographic one, each by itself: the lit points that they meet.
    fn trace_apart(
        &mut self,
        rays: &[Ray],
        arrivals: Vec<Arrival>,
        colors: &mut [DVec3],
    ) -> Vec<SurfacePoint<'a>> {
        let mut wave = Wave::new(self.setting, 0);
        for (ray, arrival) in rays.iter().zip(arrivals) {
            wave.push(FlightRay { ray: *ray, departure: None, footprint: self.footprint }, arrival);
        }
        let points = wave.arrive(colors, &mut self.taken);
        lighting::add_light(self.setting, &points, &self.setting.lights(), true, colors, &mut self.taken);
        points
    }

    /// Rays from one place: the lit points that they meet.
    fn trace_beam(
        &mut self,
        rays: &[Ray],
        arrivals: Vec<Arrival>,
        colors: &mut [DVec3],
    ) -> Vec<SurfacePoint<'a>> {
        self.beam.start_tile();
        self.looks.clear();
        let mut hits = std::mem::take(&mut self.hits);
        self.beam.closest(rays, self.footprint, &mut hits);
        let mut points = Vec::with_capacity(rays.len());
        // The candidate of each point.
        let mut candidates = Vec::with_capacity(rays.len());
        for ((ray, hit), arrival) in rays.iter().zip(&hits).zip(arrivals) {
            let ground = self.setting.ground.and_then(|ground| Some((ground, ground.meet(ray)?)));
            match (ground, hit) {
                (Some((ground, t)), hit) if hit.is_none_or(|hit| t < hit.t) => {
                    points.push(self.setting.point_of_floor(&ground, ray, t, self.footprint, arrival));
                    candidates.push(None);
                }
                (_, Some(hit)) => {
                    points.push(self.point_of_hit(ray, hit, arrival));
                    candidates.push(Some(hit.candidate));
                }
                (_, None) => {
                    let sky = self.setting.sky(ray.direction);
                    colors[arrival.pixel] += arrival.weight * sky;
                }
            }
        }
        self.hits = hits;
        for light in self.setting.surroundings.lights.iter().filter(|light| is_point(light)) {
            self.add_point_light(light, rays.len(), &points, &candidates, colors);
        }
        let others = self.setting.lights().filter(|(_, light)| !is_point(light));
        lighting::add_light(self.setting, &points, &others, true, colors, &mut self.taken);
        points
    }

    fn look(&mut self, candidate: u32) -> &Look<'a> {
        let place = candidate as usize;
        if self.looks.len() <= place {
            self.looks.resize(self.beam.candidates.len(), None);
        }
        let (scene, beam) = (self.setting.scene, &self.beam);
        self.looks[place].get_or_insert_with(|| {
            let candidate = &beam.candidates[place];
            let path = Rc::new(beam.path(place as u32));
            let (primitive, material) = match candidate.kind {
                Kind::Primitive(primitive) => {
                    let material = scene.primitives[primitive as usize].material;
                    (Some(primitive), MaterialRef::Scene(&scene.materials[material as usize]))
                }
                Kind::StandIn => (None, MaterialRef::Mean(Rc::new(scene.stand_in_material(&path)))),
            };
            Look { world_from_unit: candidate.world_from_unit(), material, primitive, path }
        })
    }

    /// The surface at a hit.
    fn point_of_hit(&mut self, ray: &Ray, hit: &BeamHit, arrival: Arrival) -> SurfacePoint<'a> {
        let footprint = at_surface(self.footprint, ray, hit.t);
        let unit_from_world = self.beam.candidates[hit.candidate as usize].unit_from_world;
        let scene = self.setting.scene;
        let look = self.look(hit.candidate);
        let own_error = 4.0 * f64::EPSILON * hit.unit_point.abs().max_element();
        let normal = unit_vector(unit_from_world.matrix3.transpose() * hit.gradient).unwrap_or(DVec3::Z);
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
    fn add_point_light(
        &mut self,
        light: &Light,
        rays: usize,
        points: &[SurfacePoint<'_>],
        candidates: &[Option<u32>],
        colors: &mut [DVec3],
    ) {
        let Some(place) = light.position() else { return };
        let mut shadow_rays: Vec<Option<Ray>> = vec![None; rays];
        let mut starts = vec![(NO_CANDIDATE, RayStart::Free); rays];
        let mut widths = vec![0.0; rays];
        let mut lit: Vec<(usize, DVec3)> = Vec::new();
        let mut least_width = f64::INFINITY;
        for (number, (point, candidate)) in points.iter().zip(candidates).enumerate() {
            let Some(way) = LightWay::to_middle(light, point.position) else { continue };
            let Some(color) = lighting::lit(point, &way) else { continue };
            let ray =
                Ray { origin: point.position, direction: way.direction, origin_error: point.position_error };
            let past_ground = self.setting.share_past_ground(&ray, candidate.is_none(), 1.0);
            if past_ground == 0.0 {
                continue;
            }
            let pixel = point.arrival.pixel;
            shadow_rays[pixel] = Some(ray);
            if let Some(candidate) = *candidate {
                starts[pixel] = (candidate, point.start(way.direction));
            }
            widths[pixel] = point.footprint.width;
            least_width = least_width.min(point.footprint.width);
            lit.push((number, past_ground * point.arrival.weight * color));
        }
        if lit.is_empty() {
            return;
        }
        self.taken.rays.shadow += lit.len() as u64;
        let shadow = Shadow { rays: &shadow_rays, starts: &starts, widths: &widths };
        let footprint = Footprint { width: least_width, spread: 0.0 };
        let occluded = self.beam.occluded(place, &shadow, footprint);
        let mut dimmed = ShadowRays::default();
        for (number, color) in lit {
            let point = &points[number];
            let pixel = point.arrival.pixel;
            if occluded[pixel / LANES] >> (pixel % LANES) & 1 == 0 {
                let way = (place - point.position).length();
                colors[pixel] += color * point.arrival.media.transmittance(way);
            } else if self.setting.lets_light_through {
                dimmed.push(point, lighting::toward(point, place - point.position), color);
            }
        }
        lighting::add_dimmed(self.setting, dimmed, 1.0, colors, &mut self.taken);
    }
}

/// Whether shadow rays of a tile can go as a beam: the light shines from one point.
fn is_point(light: &Light) -> bool {
    light.radius == 0.0 && light.position().is_some()
}
