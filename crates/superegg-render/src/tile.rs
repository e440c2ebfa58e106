//! A tile of the picture: camera rays as one beam, and for each light the shadow rays as another, seen from the light.

use std::borrow::Cow;

use superegg_geom::glam::{DAffine3, DVec2, DVec3};
use superegg_geom::{Ray, RayStart, error_through, unit_vector};
use superegg_scene::Material;

use crate::beam::{Beam, BeamHit, Kind, Shadow};
use crate::footprint::Footprint;
use crate::integrator::{Setting, Taken, Wave};
use crate::interaction::SurfaceInteraction;
use crate::shading::{self, Shares};
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
    material: Cow<'a, Material>,
    shares: Shares,
}

/// A point of a surface that a camera ray sees.
struct Seen {
    ray: usize,
    candidate: u32,
    position: DVec3,
    position_error: f64,
    /// Outwards.
    normal: DVec3,
    leaving: bool,
    to_eye: DVec3,
    width: f64,
    color: DVec3,
}

impl Seen {
    fn facing_normal(&self) -> DVec3 {
        if self.leaving { -self.normal } else { self.normal }
    }
}

impl<'a> TileTracer<'a> {
    /// For pictures of so many samples a pixel.
    pub(crate) fn new(setting: Setting<'a>, view: &'a View, samples: u32) -> Self {
        let beam = Beam::new(setting.scene);
        let footprint = view.footprint(samples);
        Self { setting, view, footprint, taken: Taken::default(), beam, hits: Vec::new(), looks: Vec::new() }
    }

    /// What each of some samples sees: at most [`crate::beam::MOST_RAYS`] of them, neighbours by the sixteen.
    pub(crate) fn trace(&mut self, samples: &[FilmSample]) -> Vec<Sighting> {
        let rays: Vec<Ray> = samples.iter().map(|sample| self.view.ray(sample.film_px)).collect();
        let footprint = self.footprint;
        self.taken.rays.camera += rays.len() as u64;
        self.beam.start_tile();
        self.looks.clear();
        let mut hits = std::mem::take(&mut self.hits);
        self.beam.closest(&rays, footprint, &mut hits);
        let mut seen: Vec<Seen> = hits
            .iter()
            .enumerate()
            .filter_map(|(i, hit)| Some(self.see(i, &rays[i], footprint, hit.as_ref()?)))
            .collect();
        self.hits = hits;
        for light in self.setting.lights {
            self.add_light(light, rays.len(), &mut seen);
        }
        let mut colors = vec![self.setting.background; rays.len()];
        let mut firsts: Vec<Option<FirstSurface>> = vec![None; rays.len()];
        let mut wave = Wave::new(self.setting);
        for point in &seen {
            colors[point.ray] = point.color;
            let look = self.look(point.candidate);
            firsts[point.ray] = Some(FirstSurface {
                depth: 0.0,
                normal: point.facing_normal(),
                albedo: look.material.color,
                id: 1,
            });
            self.leave(point, &rays[point.ray], footprint, &mut wave);
        }
        wave.follow(&mut colors, &mut self.taken);
        colors.into_iter().zip(firsts).map(|(color, first)| Sighting { color, first }).collect()
    }

    fn look(&mut self, candidate: u32) -> &Look<'a> {
        let place = candidate as usize;
        if self.looks.len() <= place {
            self.looks.resize(self.beam.candidates.len(), None);
        }
        let (scene, beam) = (self.setting.scene, &self.beam);
        self.looks[place].get_or_insert_with(|| {
            let candidate = &beam.candidates[place];
            let material = match candidate.kind {
                Kind::Primitive(primitive) => {
                    let material = scene.primitives[primitive as usize].material;
                    Cow::Borrowed(&scene.materials[material as usize])
                }
                Kind::StandIn => Cow::Owned(scene.stand_in_material(&beam.path(place as u32))),
            };
            Look { world_from_unit: candidate.world_from_unit(), shares: Shares::of(&material), material }
        })
    }

    /// The surface at a hit, with the part of its light that needs no ray.
    fn see(&mut self, i: usize, ray: &Ray, footprint: Footprint, hit: &BeamHit) -> Seen {
        if self.beam.candidates[hit.candidate as usize].kind == Kind::StandIn {
            self.taken.stand_ins += 1;
        }
        let unit_from_world = self.beam.candidates[hit.candidate as usize].unit_from_world;
        let look = self.look(hit.candidate);
        let own_error = 4.0 * f64::EPSILON * hit.unit_point.abs().max_element();
        let normal = unit_vector(unit_from_world.matrix3.transpose() * hit.gradient);
        Seen {
            ray: i,
            candidate: hit.candidate,
            position: look.world_from_unit.transform_point3(hit.unit_point),
            // Twice, for the rounding that the map itself carries.
            position_error: 2.0 * error_through(&look.world_from_unit, hit.unit_point, own_error),
            normal: normal.unwrap_or(DVec3::Z),
            leaving: hit.leaving,
            to_eye: -ray.direction.normalize(),
            width: footprint.at(hit.t),
            color: shading::ambient(&look.material, &look.shares),
        }
    }

    /// Adds the light of one lamp to all points that it reaches.
    fn add_light(&mut self, light: &superegg_scene::Light, rays: usize, seen: &mut [Seen]) {
        let mut shadow_rays: Vec<Option<Ray>> = vec![None; rays];
        let mut starts = vec![(0, RayStart::Free); rays];
        let mut widths = vec![0.0; rays];
        let mut count = 0;
        let mut least_width = f64::INFINITY;
        for point in seen.iter() {
            let Some((to_light, _)) = shading::towards(light, point.position) else { continue };
            if point.facing_normal().dot(to_light) <= 0.0 {
                continue;
            }
            count += 1;
            // Not the unit direction: t = 1 is the light's own place.
            let direction = light.position().unwrap_or_default() - point.position;
            let start = if point.normal.dot(direction) >= 0.0 {
                RayStart::SurfaceOutward
            } else {
                RayStart::SurfaceInward
            };
            shadow_rays[point.ray] =
                Some(Ray { origin: point.position, direction, origin_error: point.position_error });
            starts[point.ray] = (point.candidate, start);
            widths[point.ray] = point.width;
            least_width = least_width.min(point.width);
        }
        if count == 0 {
            return;
        }
        self.taken.rays.shadow += count;
        let shadow = Shadow { rays: &shadow_rays, starts: &starts, widths: &widths };
        let occluded = self.beam.occluded(
            light.position().unwrap_or_default(),
            &shadow,
            Footprint { width: least_width, spread: 0.0 },
        );
        for point in seen.iter_mut() {
            let i = point.ray;
            let is_asked = shadow_rays[i].is_some();
            if !is_asked || occluded[i / crate::beam::LANES] >> (i % crate::beam::LANES) & 1 == 1 {
                continue;
            }
            if let Some((to_light, color)) = shading::towards(light, point.position) {
                let normal = point.facing_normal();
                let to_eye = point.to_eye;
                let look = self.look(point.candidate);
                point.color += shading::direct(&look.material, &look.shares, color, normal, to_eye, to_light);
            }
        }
    }

    /// Hands on what a point mirrors and lets through.
    fn leave(&mut self, point: &Seen, ray: &Ray, footprint: Footprint, wave: &mut Wave<'_>) {
        let look = self.look(point.candidate);
        if look.shares.mirror == 0.0 && look.shares.through == 0.0 {
            return;
        }
        let surface = SurfaceInteraction {
            position: point.position,
            position_error: point.position_error,
            normal: point.normal,
            leaving: point.leaving,
            material: look.material.clone(),
            path: self.beam.path(point.candidate),
        };
        let spread = footprint.spread / ray.direction.length();
        let footprint = Footprint { width: point.width, spread };
        wave.leave(&surface, -point.to_eye, point.ray, DVec3::ONE, footprint, &mut self.taken);
    }
}
