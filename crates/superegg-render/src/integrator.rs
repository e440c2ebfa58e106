//! Whitted's integrator: local light with hard shadows, mirror reflection, refraction (Whitted 1980).

use std::ops::AddAssign;

use superegg_geom::Ray;
use superegg_geom::glam::DVec3;
use superegg_scene::Light;

use crate::compiled::CompiledScene;
use crate::footprint::Footprint;
use crate::interaction::SurfaceInteraction;
use crate::shading::{self, Shares};
use crate::traverse::Departure;

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

/// What a picture is made of, and the count of what it took so far.
pub(crate) struct Integrator<'a> {
    pub(crate) scene: &'a CompiledScene,
    pub(crate) lights: &'a [Light],
    pub(crate) background: DVec3,
    pub(crate) counts: RayCounts,
    /// How many rays ended at a group that stands in as a whole.
    pub(crate) stand_ins: u64,
}

impl Integrator<'_> {
    /// The linear colour along a ray that goes on from a surface, whose result will be weighted by at most `weight`.
    fn radiance(
        &mut self,
        ray: &Ray,
        departure: &Departure,
        bounces: u32,
        weight: f64,
        footprint: Footprint,
    ) -> DVec3 {
        let hit = self.scene.intersect_footprint(ray, Some(departure), footprint);
        let Some(hit) = hit else { return self.background };
        self.stand_ins += u64::from(hit.path.is_stand_in());
        let surface = self.scene.interaction(&hit);
        let direction = ray.direction.normalize();
        let shares = Shares::of(&surface.material);
        let footprint = Footprint { width: footprint.at(hit.t), ..footprint };
        self.local_light(&surface, &shares, -direction, footprint)
            + self.further_light(&surface, &shares, direction, bounces, weight, footprint)
    }

    /// What a surface mirrors and lets through to where a ray of this unit direction came from.
    pub(crate) fn further_light(
        &mut self,
        surface: &SurfaceInteraction<'_>,
        shares: &Shares,
        direction: DVec3,
        bounces: u32,
        weight: f64,
        footprint: Footprint,
    ) -> DVec3 {
        if shares.mirror == 0.0 && shares.through == 0.0 {
            return DVec3::ZERO;
        }
        let mut color = DVec3::ZERO;
        let normal = surface.facing_normal();
        let ratio = if surface.leaving { surface.material.index } else { 1.0 / surface.material.index };
        let refracted = if shares.through > 0.0 { shading::refract(direction, normal, ratio) } else { None };
        let reflectance = refracted.map_or(1.0, |(_, reflectance)| reflectance);

        let mirror_share = shares.mirror + shares.through * reflectance;
        if mirror_share * weight > LEAST_WEIGHT {
            self.counts.reflection += 1;
            let mirrored = shading::mirror(direction, normal);
            color += mirror_share * self.follow(surface, mirrored, bounces, weight * mirror_share, footprint);
        }
        if let Some((through, _)) = refracted {
            let share = shares.through * (1.0 - reflectance);
            let tint = surface.material.color.map(f64::sqrt);
            if share * weight > LEAST_WEIGHT {
                self.counts.refraction += 1;
                color += share * tint * self.follow(surface, through, bounces, weight * share, footprint);
            }
        }
        color
    }

    /// The light along a ray that goes on from a surface.
    fn follow(
        &mut self,
        surface: &SurfaceInteraction<'_>,
        direction: DVec3,
        bounces: u32,
        weight: f64,
        footprint: Footprint,
    ) -> DVec3 {
        if bounces >= MAX_BOUNCES {
            return self.background;
        }
        let (ray, departure) = surface.spawn_ray(direction);
        self.radiance(&ray, &departure, bounces + 1, weight, footprint)
    }

    /// Ambient light and that of the lights which reach the surface.
    fn local_light(
        &mut self,
        surface: &SurfaceInteraction<'_>,
        shares: &Shares,
        to_eye: DVec3,
        footprint: Footprint,
    ) -> DVec3 {
        let normal = surface.facing_normal();
        let mut color = shading::ambient(&surface.material, shares);
        for light in self.lights {
            let Some((to_light, light_color)) = shading::towards(light, surface.position) else { continue };
            if normal.dot(to_light) <= 0.0 {
                continue;
            }
            self.counts.shadow += 1;
            // Not the unit direction: t = 1 is the light's own place.
            let (ray, departure) = surface.spawn_ray(light.position - surface.position);
            let width = Footprint { spread: 0.0, ..footprint };
            if !self.scene.occluded_footprint(&ray, Some(&departure), 1.0, width) {
                color += shading::direct(&surface.material, shares, light_color, normal, to_eye, to_light);
            }
        }
        color
    }
}
