//! Whitted's integrator: local light with hard shadows, mirror reflection, refraction (Whitted 1980).

use std::ops::AddAssign;

use superegg_geom::glam::DVec3;
use superegg_scene::Light;

use crate::compiled::CompiledScene;
use crate::flight::FlightRay;
use crate::footprint::Footprint;
use crate::interaction::SurfaceInteraction;
use crate::shading::{self, Shares};

/// How many rays of each kind were traced.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RayCounts {
    /// From the camera.
    pub camera: u64,
    /// From surfaces to lights.
    pub shadow: u64,
    /// Mirrored, total internal reflection included.
    pub reflection: u64,
    /// Transmitted.
    pub refraction: u64,
}

impl AddAssign for RayCounts {
    fn add_assign(&mut self, other: Self) {
        self.camera += other.camera;
        self.shadow += other.shadow;
        self.reflection += other.reflection;
        self.refraction += other.refraction;
    }
}

/// After so many mirrorings and transmissions a ray sees the background.
const MAX_BOUNCES: u32 = 16;
/// A ray that adds less than this to its pixel is not traced: a fifth of the smallest step of an 8-bit picture.
const LEAST_WEIGHT: f64 = 1.0 / 1280.0;

/// What a picture is made of.
#[derive(Clone, Copy)]
pub(crate) struct Setting<'a> {
    pub(crate) scene: &'a CompiledScene,
    pub(crate) lights: &'a [Light],
    pub(crate) background: DVec3,
}

/// What tracing took so far.
#[derive(Clone, Copy, Default)]
pub(crate) struct Taken {
    pub(crate) rays: RayCounts,
    /// How many rays ended at a group that stands in as a whole.
    pub(crate) stand_ins: u64,
}

impl AddAssign for Taken {
    fn add_assign(&mut self, other: Self) {
        self.rays += other.rays;
        self.stand_ins += other.stand_ins;
    }
}

/// Rays that go on from surfaces, all those of one number of bounces at a time.
pub(crate) struct Wave<'a> {
    setting: Setting<'a>,
    /// The rays, and what each adds to: the place of a colour, and its weight there.
    rays: Vec<FlightRay>,
    weights: Vec<(usize, DVec3)>,
    /// How many surfaces the rays have left.
    bounces: u32,
}

impl<'a> Wave<'a> {
    pub(crate) fn new(setting: Setting<'a>) -> Self {
        Self { setting, rays: Vec::new(), weights: Vec::new(), bounces: 1 }
    }

    /// Takes the rays that a surface mirrors and lets through to where a ray of this unit direction came from; their light counts with `weight` in
    /// the colour of a place.
    pub(crate) fn leave(
        &mut self,
        surface: &SurfaceInteraction<'_>,
        direction: DVec3,
        place: usize,
        weight: DVec3,
        footprint: Footprint,
        taken: &mut Taken,
    ) {
        let shares = Shares::of(&surface.material);
        if shares.mirror == 0.0 && shares.through == 0.0 {
            return;
        }
        let normal = surface.facing_normal();
        let ratio = if surface.leaving { surface.material.index } else { 1.0 / surface.material.index };
        let refracted = if shares.through > 0.0 { shading::refract(direction, normal, ratio) } else { None };
        let reflectance = refracted.map_or(1.0, |(_, reflectance)| reflectance);
        let mut follow = |direction: DVec3, weight: DVec3| {
            let (ray, departure) = surface.spawn_ray(direction);
            self.rays.push(FlightRay { ray, departure: Some(departure), footprint });
            self.weights.push((place, weight));
        };
        let largest = weight.max_element();

        let mirror_share = shares.mirror + shares.through * reflectance;
        if mirror_share * largest > LEAST_WEIGHT {
            taken.rays.reflection += 1;
            follow(shading::mirror(direction, normal), mirror_share * weight);
        }
        if let Some((through, _)) = refracted {
            let share = shares.through * (1.0 - reflectance);
            let tint = surface.material.color.map(f64::sqrt);
            if share * largest > LEAST_WEIGHT {
                taken.rays.refraction += 1;
                follow(through, share * tint * weight);
            }
        }
    }

    /// Follows all rays, and those that go on from what they meet, to their ends.
    pub(crate) fn follow(mut self, colors: &mut [DVec3], taken: &mut Taken) {
        while !self.rays.is_empty() {
            let mut next = Self { bounces: self.bounces + 1, ..Self::new(self.setting) };
            let hits = self.setting.scene.intersect_many(&self.rays);
            let mut asked: Vec<FlightRay> = Vec::new();
            let mut lit: Vec<(usize, DVec3)> = Vec::new();
            for ((FlightRay { ray, footprint, .. }, (place, weight)), hit) in
                self.rays.iter().zip(&self.weights).zip(hits)
            {
                let Some(hit) = hit else {
                    colors[*place] += *weight * self.setting.background;
                    continue;
                };
                taken.stand_ins += u64::from(hit.path.is_stand_in());
                let surface = self.setting.scene.interaction(&hit);
                let direction = ray.direction.normalize();
                let footprint = Footprint { width: footprint.at(hit.t), ..*footprint };
                let shares = Shares::of(&surface.material);
                colors[*place] += *weight * shading::ambient(&surface.material, &shares);
                for light in self.setting.lights {
                    if let Some((ray, color)) = light_ray(light, &surface, &shares, -direction, footprint) {
                        asked.push(ray);
                        lit.push((*place, *weight * color));
                    }
                }
                if self.bounces < MAX_BOUNCES {
                    next.leave(&surface, direction, *place, *weight, footprint, taken);
                } else if shares.mirror > 0.0 || shares.through > 0.0 {
                    // What would be followed further counts as the background.
                    let rest = (shares.mirror + shares.through) * self.setting.background;
                    colors[*place] += *weight * rest;
                }
            }
            taken.rays.shadow += asked.len() as u64;
            let stopped = self.setting.scene.occluded_many(&asked, 1.0);
            for ((place, color), _) in lit.into_iter().zip(stopped).filter(|(_, stopped)| !stopped) {
                colors[place] += color;
            }
            self = next;
        }
    }
}

/// The ray from a surface to a light that shines on its side, t = 1 there, and what the light adds where nothing is between.
fn light_ray(
    light: &Light,
    surface: &SurfaceInteraction<'_>,
    shares: &Shares,
    to_eye: DVec3,
    footprint: Footprint,
) -> Option<(FlightRay, DVec3)> {
    let (to_light, color) = shading::towards(light, surface.position)?;
    let normal = surface.facing_normal();
    if normal.dot(to_light) <= 0.0 {
        return None;
    }
    // Not the unit direction: t = 1 is the light's own place.
    let (ray, departure) = surface.spawn_ray(light.position().unwrap_or_default() - surface.position);
    let footprint = Footprint { spread: 0.0, ..footprint };
    let color = shading::direct(&surface.material, shares, color, normal, to_eye, to_light);
    Some((FlightRay { ray, departure: Some(departure), footprint }, color))
}
