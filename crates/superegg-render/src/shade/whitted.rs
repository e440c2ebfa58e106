//! Whitted's integrator (1980): light straight from lights, mirrored rays, refracted rays; with lights of some extent, ambient occlusion and
//! blurred mirrors by more rays (Cook, Porter and Carpenter 1984).

use superegg_geom::glam::DVec3;
use superegg_trace::TraceRay;

use crate::camera::sobol::power_cosine_direction;
use crate::shade::context::RenderContext;
use crate::shade::direct;
use crate::shade::medium::Media;
use crate::shade::phong;
use crate::shade::point::{PathState, SurfacePoint};
use crate::stats::TraceStats;

/// Rays that go on from surfaces, all those of one number of bounces at a time.
pub(crate) struct Wavefront<'a> {
    context: RenderContext<'a>,
    rays: Vec<TraceRay>,
    arrivals: Vec<PathState>,
    /// How many surfaces the rays have left.
    bounces: u32,
}

/// Choices of a [`crate::camera::sobol::SampleKey`].
const MIRRORED: u32 = 2;
const TRANSMITTED: u32 = 3;
const BLURRED: u32 = 1 << 20;

impl<'a> Wavefront<'a> {
    /// Rays that have left so many surfaces; none from the camera.
    pub(crate) fn new(context: RenderContext<'a>, bounces: u32) -> Self {
        Self { context, rays: Vec::new(), arrivals: Vec::new(), bounces }
    }

    pub(crate) fn push(&mut self, ray: TraceRay, state: PathState) {
        self.rays.push(ray);
        self.arrivals.push(state);
    }

    /// Takes the rays that a point mirrors and lets through.
    pub(crate) fn scatter(&mut self, point: &SurfacePoint<'_>, colors: &mut [DVec3], stats: &mut TraceStats) {
        let SurfacePoint { state, material, weights, .. } = point;
        if weights.is_local() {
            return;
        }
        if self.bounces > self.context.picture.bounces {
            let rest = DVec3::splat(weights.mirror + weights.transmitted);
            self.terminate(&state.media, -point.to_eye, state.pixel, state.weight * rest, colors);
            return;
        }
        let normal = point.facing_normal();
        let blurred = if self.bounces == 1 {
            self.context.picture.gloss_rays
        } else {
            self.context.picture.gloss_rays.min(1)
        };
        let is_blurred = blurred > 0 && material.gloss > 0.0;
        let mut sharp = if is_blurred { 0.0 } else { weights.mirror };
        if weights.transmitted > 0.0 {
            let (ratio, beyond) = point.beyond();
            let refracted = phong::refract(-point.to_eye, normal, ratio);
            sharp += weights.transmitted * refracted.map_or(1.0, |(_, reflectance)| reflectance);
            if let Some((direction, reflectance)) = refracted {
                let share = weights.transmitted * (1.0 - reflectance) * point.albedo.map(f64::sqrt);
                stats.rays.refraction += self.follow(point, direction, share, TRANSMITTED, beyond, colors);
            }
        }
        let mirrored = phong::mirror(-point.to_eye, normal);
        if sharp > 0.0 {
            let share = DVec3::splat(sharp);
            stats.rays.reflection +=
                self.follow(point, mirrored, share, MIRRORED, state.media.clone(), colors);
        }
        if !is_blurred || weights.mirror == 0.0 {
            return;
        }
        let (key, exponent) = (state.key.branch(BLURRED), material.highlight_exponent());
        for place in 0..blurred {
            let facet = power_cosine_direction(key.point(place, blurred), normal, exponent);
            let spread = phong::mirror(-point.to_eye, facet);
            // A facet that would mirror into the surface is one that others hide.
            let direction = if spread.dot(normal) > 0.0 { spread } else { mirrored };
            let share = DVec3::splat(weights.mirror / f64::from(blurred));
            let choice = BLURRED + 1 + place;
            stats.rays.reflection +=
                self.follow(point, direction, share, choice, state.media.clone(), colors);
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
        let weight = point.state.weight * share;
        if weight.max_element() <= self.context.picture.least_weight {
            self.terminate(&media, direction, point.state.pixel, weight, colors);
            return 0;
        }
        let key = point.state.key.branch(choice);
        let is_from_floor = point.is_on_floor();
        let state = PathState { weight, key, media, is_from_floor, ..point.state };
        self.push(point.spawn(direction, point.footprint), state);
        1
    }

    /// What is followed no further counts as the sky behind, so that clear glass and mirrors lose nothing; what is caught in a coloured inside fades away.
    fn terminate(&self, media: &Media, direction: DVec3, pixel: usize, weight: DVec3, colors: &mut [DVec3]) {
        if !media.absorbs() {
            colors[pixel] += weight * self.context.sky(direction);
        }
    }

    /// Traces the rays: the points that they meet, in their order. What meets nothing adds the sky to the colours.
    pub(crate) fn arrive(&mut self, colors: &mut [DVec3], stats: &mut TraceStats) -> Vec<SurfacePoint<'a>> {
        let hits = self.context.scene.intersect_many(&self.rays);
        let arrivals = std::mem::take(&mut self.arrivals);
        let mut points = Vec::with_capacity(hits.len());
        for ((ray, state), hit) in self.rays.drain(..).zip(arrivals).zip(hits) {
            let (pixel, weight) = (state.pixel, state.weight);
            match self.context.arrive(&ray, hit.as_ref(), state, stats) {
                Some(point) => points.push(point),
                None => colors[pixel] += weight * self.context.sky(ray.ray.direction),
            }
        }
        points
    }

    /// Follows all rays, and those that go on from what they meet, to their ends.
    pub(crate) fn follow_all(mut self, colors: &mut [DVec3], stats: &mut TraceStats) {
        while !self.rays.is_empty() {
            let points = self.arrive(colors, stats);
            let lights = self.context.lights();
            direct::add_light(self.context, &points, &lights, false, colors, stats);
            let mut next = Self::new(self.context, self.bounces + 1);
            points.iter().for_each(|point| next.scatter(point, colors, stats));
            self = next;
        }
    }
}
