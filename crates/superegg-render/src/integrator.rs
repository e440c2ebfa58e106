//! Whitted's integrator (1980): light straight from lights, mirrored rays, refracted rays; with lights of some extent, ambient occlusion and
//! blurred mirrors by more rays (Cook, Porter and Carpenter 1984).

use std::ops::AddAssign;
use std::rc::Rc;

use superegg_geom::glam::DVec3;
use superegg_geom::{Aabb, Ray, inverse_of};
use superegg_scene::{Light, Material, Pattern, Picture};

use crate::ground::Ground;
use crate::lighting;
use crate::medium::Media;
use crate::point::{Arrival, MaterialRef, Place, Seen, SurfacePoint, albedo_of_floor, albedo_of_shape};
use crate::render::{RenderSettings, Surroundings};
use crate::sequence::power_cosine_direction;
use crate::shading::{self, Shares};
use superegg_trace::beam::Kind;
use superegg_trace::{CompiledScene, FlightRay, Footprint, Hit, InstancePath, SurfaceInteraction};

/// How many rays of each kind were traced.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RayCounts {
    /// From the camera.
    pub camera: u64,
    /// From surfaces to lights.
    pub shadow: u64,
    /// From surfaces to all sides, for ambient occlusion.
    pub ambient: u64,
    /// Mirrored, total internal reflection included.
    pub reflection: u64,
    /// Transmitted.
    pub refraction: u64,
}

impl AddAssign for RayCounts {
    fn add_assign(&mut self, other: Self) {
        self.camera += other.camera;
        self.shadow += other.shadow;
        self.ambient += other.ambient;
        self.reflection += other.reflection;
        self.refraction += other.refraction;
    }
}

/// What tracing took.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Taken {
    /// The rays.
    pub rays: RayCounts,
    /// How many of them ended at a group that was too small to be opened, and saw its average ([`crate::LEAST_FOOTPRINT`]).
    pub stand_ins: u64,
}

impl AddAssign for Taken {
    fn add_assign(&mut self, other: Self) {
        self.rays += other.rays;
        self.stand_ins += other.stand_ins;
    }
}

/// What a picture is made of.
#[derive(Clone, Copy)]
pub(crate) struct Setting<'a> {
    pub(crate) scene: &'a CompiledScene,
    pub(crate) surroundings: &'a Surroundings,
    pub(crate) picture: &'a Picture,
    pub(crate) ground: Option<Ground<'a>>,
    /// Whether any surface does, so that shadows may be coloured.
    pub(crate) lets_light_through: bool,
}

fn lets_light_through(material: &Material) -> bool {
    material.refracted.is_some_and(|share| share > 0.0)
}

impl<'a> Setting<'a> {
    pub(crate) fn new(scene: &'a CompiledScene, settings: &'a RenderSettings) -> Self {
        let ground =
            settings.surroundings.floor.as_ref().map(|(floor, material)| Ground::new(floor, material));
        Self {
            scene,
            surroundings: &settings.surroundings,
            picture: &settings.picture,
            ground,
            lets_light_through: scene.materials().iter().any(lets_light_through),
        }
    }

    /// The lights with their numbers.
    pub(crate) fn lights(&self) -> impl Iterator<Item = (u32, &'a Light)> + Clone + use<'a> {
        (0..).zip(&self.surroundings.lights)
    }

    /// What is seen in a direction, of any length, where nothing is.
    pub(crate) fn sky(&self, direction: DVec3) -> DVec3 {
        match &self.surroundings.sky {
            Some(sky) => sky.color(direction.normalize_or_zero()),
            None => self.surroundings.background,
        }
    }

    /// The share of light that the floor lets by on the way of a ray before t = `end`.
    pub(crate) fn share_past_ground(&self, ray: &Ray, is_from_floor: bool, end: f64) -> f64 {
        let ground = self.ground.filter(|_| !is_from_floor);
        match ground.and_then(|ground| Some((ground, ground.meet(ray)?))) {
            Some((ground, t)) if t < end => ground.material.refracted.unwrap_or(0.0).min(1.0),
            _ => 1.0,
        }
    }

    /// The transparent shapes that a point is in.
    pub(crate) fn media_at(&self, point: DVec3) -> Media {
        // So many shapes around one point are asked at most.
        const MOST_SHAPES: usize = 4096;
        if !self.lets_light_through {
            return Media::default();
        }
        let around = self.scene.query_box(&Aabb { min: point, max: point }, MOST_SHAPES);
        let mut holding: Vec<(f64, InstancePath, &Material)> = around
            .into_iter()
            .filter_map(|path| {
                let (unit_from_world, kind) = self.scene.unit_from_world(&path);
                let Kind::Primitive(primitive) = kind else { return None };
                let primitive = self.scene.primitive(primitive);
                let material = self.scene.material_of(primitive);
                let local = unit_from_world.transform_point3(point);
                (primitive.unit_shape().inside_outside(local) < 0.0 && lets_light_through(material))
                    .then(|| (unit_from_world.matrix3.determinant().abs(), path, material))
            })
            .collect();
        // The largest first: it holds the others.
        holding.sort_by(|a, b| a.0.total_cmp(&b.0));
        holding
            .into_iter()
            .fold(Media::default(), |media, (_, path, material)| media.within(&Rc::new(path), material))
    }

    /// What a ray meets that goes from a surface or from the camera: the point ready to be shaded.
    pub(crate) fn arrive(
        &self,
        ray: &FlightRay,
        hit: Option<&Hit>,
        arrival: Arrival,
        taken: &mut Taken,
    ) -> Option<SurfacePoint<'a>> {
        let FlightRay { ray: way, footprint, .. } = ray;
        let ground = self.ground.filter(|_| !arrival.is_from_floor);
        if let Some((ground, t)) = ground.and_then(|ground| Some((ground, ground.meet(way)?)))
            && hit.is_none_or(|hit| t < hit.t)
        {
            return Some(self.point_of_floor(&ground, way, t, *footprint, arrival));
        }
        let hit = hit?;
        taken.stand_ins += u64::from(hit.path.is_stand_in());
        let surface = self.scene.interaction(hit);
        Some(self.point_of_hit(surface, hit, way, *footprint, arrival))
    }

    /// The colour of a surface at a hit, pattern and all.
    pub(crate) fn albedo(&self, material: &Material, hit: &Hit, seen: &Seen) -> DVec3 {
        if material.pattern == Pattern::None {
            return material.color;
        }
        let (unit_from_world, _) = self.scene.unit_from_world(&hit.path);
        let primitive = self.scene.primitive(hit.primitive);
        albedo_of_shape(material, primitive, hit.unit_point, &inverse_of(&unit_from_world), seen)
    }

    fn point_of_hit(
        &self,
        surface: SurfaceInteraction<'a>,
        hit: &Hit,
        ray: &Ray,
        footprint: Footprint,
        arrival: Arrival,
    ) -> SurfacePoint<'a> {
        let direction = ray.direction.normalize();
        let footprint = at_surface(footprint, ray, hit.t);
        let material = MaterialRef::from(surface.material);
        let albedo =
            self.albedo(&material, hit, &Seen { normal: surface.normal, direction, width: footprint.width });
        SurfacePoint {
            arrival: arrival.after(ray.origin, surface.position),
            place: Place::Instance(Rc::new(surface.path)),
            position: surface.position,
            position_error: surface.position_error,
            normal: surface.normal,
            leaving: surface.leaving,
            to_eye: -direction,
            footprint,
            albedo,
            shares: Shares::of(&material, direction.dot(surface.normal).abs()),
            material,
        }
    }

    /// The point of the floor on a ray.
    pub(crate) fn point_of_floor(
        &self,
        ground: &Ground<'a>,
        ray: &Ray,
        t: f64,
        footprint: Footprint,
        arrival: Arrival,
    ) -> SurfacePoint<'a> {
        let direction = ray.direction.normalize();
        let footprint = at_surface(footprint, ray, t);
        let (position, position_error) = ground.settle(ray.point_at(t));
        let seen = Seen { normal: ground.up(), direction, width: footprint.width };
        SurfacePoint {
            arrival: arrival.after(ray.origin, position),
            place: Place::Floor,
            position,
            position_error,
            normal: ground.up(),
            leaving: ray.direction.dot(ground.up()) > 0.0,
            to_eye: -direction,
            footprint,
            material: MaterialRef::Scene(ground.material),
            albedo: albedo_of_floor(ground, position, &seen),
            shares: Shares::of(ground.material, direction.dot(ground.up()).abs()),
        }
    }
}

/// The width of a ray where it meets a surface, and what that grows by for each unit of way from there.
pub(crate) fn at_surface(footprint: Footprint, ray: &Ray, t: f64) -> Footprint {
    Footprint { width: footprint.at(t), spread: footprint.spread / ray.direction.length() }
}

/// Rays that go on from surfaces, all those of one number of bounces at a time.
pub(crate) struct Wave<'a> {
    setting: Setting<'a>,
    rays: Vec<FlightRay>,
    arrivals: Vec<Arrival>,
    /// How many surfaces the rays have left.
    bounces: u32,
}

/// Choices of a [`crate::sequence::SampleKey`].
const MIRRORED: u32 = 2;
const TRANSMITTED: u32 = 3;
const BLURRED: u32 = 1 << 20;

impl<'a> Wave<'a> {
    /// Rays that have left so many surfaces; none from the camera.
    pub(crate) fn new(setting: Setting<'a>, bounces: u32) -> Self {
        Self { setting, rays: Vec::new(), arrivals: Vec::new(), bounces }
    }

    pub(crate) fn push(&mut self, ray: FlightRay, arrival: Arrival) {
        self.rays.push(ray);
        self.arrivals.push(arrival);
    }

    /// Takes the rays that a point mirrors and lets through.
    pub(crate) fn leave(&mut self, point: &SurfacePoint<'_>, colors: &mut [DVec3], taken: &mut Taken) {
        let SurfacePoint { arrival, material, shares, .. } = point;
        if shares.is_local() {
            return;
        }
        if self.bounces > self.setting.picture.bounces {
            let rest = DVec3::splat(shares.mirror + shares.through);
            self.give_up(&arrival.media, -point.to_eye, arrival.pixel, arrival.weight * rest, colors);
            return;
        }
        let normal = point.facing_normal();
        let blurred = if self.bounces == 1 {
            self.setting.picture.gloss_rays
        } else {
            self.setting.picture.gloss_rays.min(1)
        };
        let is_blurred = blurred > 0 && material.gloss > 0.0;
        let mut sharp = if is_blurred { 0.0 } else { shares.mirror };
        if shares.through > 0.0 {
            let (ratio, beyond) = point.beyond();
            let refracted = shading::refract(-point.to_eye, normal, ratio);
            sharp += shares.through * refracted.map_or(1.0, |(_, reflectance)| reflectance);
            if let Some((direction, reflectance)) = refracted {
                let share = shares.through * (1.0 - reflectance) * point.albedo.map(f64::sqrt);
                taken.rays.refraction += self.follow(point, direction, share, TRANSMITTED, beyond, colors);
            }
        }
        let mirrored = shading::mirror(-point.to_eye, normal);
        if sharp > 0.0 {
            let share = DVec3::splat(sharp);
            taken.rays.reflection +=
                self.follow(point, mirrored, share, MIRRORED, arrival.media.clone(), colors);
        }
        if !is_blurred || shares.mirror == 0.0 {
            return;
        }
        let (key, exponent) = (arrival.key.branch(BLURRED), material.highlight_exponent());
        for place in 0..blurred {
            let facet = power_cosine_direction(key.point(place, blurred), normal, exponent);
            let spread = shading::mirror(-point.to_eye, facet);
            // A facet that would mirror into the surface is one that others hide.
            let direction = if spread.dot(normal) > 0.0 { spread } else { mirrored };
            let share = DVec3::splat(shares.mirror / f64::from(blurred));
            let choice = BLURRED + 1 + place;
            taken.rays.reflection +=
                self.follow(point, direction, share, choice, arrival.media.clone(), colors);
        }
    }

    /// Takes one ray, and returns how many it took: one that adds too little to be followed sees the sky.
    fn follow(
        &mut self,
        point: &SurfacePoint<'_>,
        direction: DVec3,
        share: DVec3,
        choice: u32,
        media: Media,
        colors: &mut [DVec3],
    ) -> u64 {
        let weight = point.arrival.weight * share;
        if weight.max_element() <= self.setting.picture.least_weight {
            self.give_up(&media, direction, point.arrival.pixel, weight, colors);
            return 0;
        }
        let key = point.arrival.key.branch(choice);
        let is_from_floor = point.is_on_floor();
        let arrival = Arrival { weight, key, media, is_from_floor, ..point.arrival };
        self.push(point.spawn(direction, point.footprint), arrival);
        1
    }

    /// What is followed no further counts as the sky behind, so that clear glass and mirrors lose nothing; what is caught in a coloured inside fades away.
    fn give_up(&self, media: &Media, direction: DVec3, pixel: usize, weight: DVec3, colors: &mut [DVec3]) {
        if !media.absorbs() {
            colors[pixel] += weight * self.setting.sky(direction);
        }
    }

    /// Traces the rays: the points that they meet, in their order. What meets nothing adds the sky to the colours.
    pub(crate) fn arrive(&mut self, colors: &mut [DVec3], taken: &mut Taken) -> Vec<SurfacePoint<'a>> {
        let hits = self.setting.scene.intersect_many(&self.rays);
        let arrivals = std::mem::take(&mut self.arrivals);
        let mut points = Vec::with_capacity(hits.len());
        for ((ray, arrival), hit) in self.rays.drain(..).zip(arrivals).zip(hits) {
            let (pixel, weight) = (arrival.pixel, arrival.weight);
            match self.setting.arrive(&ray, hit.as_ref(), arrival, taken) {
                Some(point) => points.push(point),
                None => colors[pixel] += weight * self.setting.sky(ray.ray.direction),
            }
        }
        points
    }

    /// Follows all rays, and those that go on from what they meet, to their ends.
    pub(crate) fn follow_all(mut self, colors: &mut [DVec3], taken: &mut Taken) {
        while !self.rays.is_empty() {
            let points = self.arrive(colors, taken);
            let lights = self.setting.lights();
            lighting::add_light(self.setting, &points, &lights, false, colors, taken);
            let mut next = Self::new(self.setting, self.bounces + 1);
            points.iter().for_each(|point| next.leave(point, colors, taken));
            self = next;
        }
    }
}
