//! The integrator of Whitted (1980): direct light, reflected rays and refracted rays. Area lights,
//! ambient occlusion and glossy reflection take several rays (Cook, Porter and Carpenter 1984).

use superegg_geom::glam::DVec3;
use superegg_trace::TraceRay;

use crate::shade::context::RenderContext;
use crate::shade::direct;
use crate::shade::medium::Media;
use crate::shade::phong::{self, LobeWeights};
use crate::shade::point::{PathState, SurfacePoint};
use crate::shade::state::ShadingState;

/// The reflected and refracted rays of one bounce.
pub(crate) struct Wavefront<'a> {
    context: RenderContext<'a>,
    rays: Vec<TraceRay>,
    states: Vec<PathState>,
    /// The number of surfaces that the rays have left.
    bounces: u32,
    /// The rays whose beams are known to hold shapes.
    beams_tested: usize,
}

/// Branches of a [`crate::camera::sobol::SampleKey`].
pub(crate) const MIRRORED: u32 = 2;
const TRANSMITTED: u32 = 3;
const BLURRED: u32 = 1 << 20;

impl<'a> Wavefront<'a> {
    /// An empty wavefront with room for some rays. `bounces` is 0 for camera rays.
    pub(crate) fn with_capacity(context: RenderContext<'a>, bounces: u32, rays: usize) -> Self {
        Self {
            context,
            rays: Vec::with_capacity(rays),
            states: Vec::with_capacity(rays),
            bounces,
            beams_tested: 0,
        }
    }

    /// The reflected and refracted rays of points, after a number of bounces.
    pub(crate) fn of_points(
        context: RenderContext<'a>,
        bounces: u32,
        points: &[SurfacePoint<'a>],
        shading: &mut ShadingState<'_, 'a>,
    ) -> Self {
        // Glass reflects and refracts.
        let most_rays =
            |weights: &LobeWeights| usize::from(!weights.is_local()) + usize::from(weights.transmitted > 0.0);
        let rays = points.iter().map(|point| most_rays(&point.weights)).sum();
        let mut wave = Self::with_capacity(context, bounces, rays);
        points.iter().for_each(|point| wave.scatter(point, shading));
        wave
    }

    /// With this many rays whose beams are known to hold shapes.
    pub(crate) fn with_beams_tested(self, beams_tested: usize) -> Self {
        Self { beams_tested, ..self }
    }

    /// Adds a ray.
    pub(crate) fn push(&mut self, ray: TraceRay, state: PathState) {
        self.rays.push(ray);
        self.states.push(state);
    }

    /// Adds the reflected and refracted rays of a point.
    fn scatter(&mut self, point: &SurfacePoint<'_>, shading: &mut ShadingState<'_, 'a>) {
        let SurfacePoint { state, material, weights, .. } = point;
        if weights.is_local() {
            return;
        }
        if self.bounces > self.context.picture.bounces {
            let rest = DVec3::splat(weights.mirror + weights.transmitted);
            self.terminate(&state.media, -point.to_eye, state.pixel, state.weight * rest, shading);
            return;
        }
        let normal = point.mirror_normal();
        let blurred = if self.bounces == 1 {
            self.context.picture.gloss_rays
        } else {
            self.context.picture.gloss_rays.min(1)
        };
        let is_blurred = blurred > 0 && material.gloss > 0.0;
        let mut sharp = if is_blurred { 0.0 } else { weights.mirror };
        if weights.transmitted > 0.0 {
            let (ratio, beyond) = point.beyond();
            let refracted = point.refract(ratio);
            sharp += weights.transmitted * refracted.map_or(1.0, |(_, reflectance)| reflectance);
            if let Some((direction, reflectance)) = refracted {
                let share = weights.transmitted * (1.0 - reflectance) * point.albedo.map(f64::sqrt);
                shading.stats.rays.refraction +=
                    self.follow(point, direction, share, TRANSMITTED, beyond, shading);
            }
        }
        let mirrored = phong::mirror(-point.to_eye, normal);
        if sharp > 0.0 {
            let share = DVec3::splat(sharp);
            shading.stats.rays.reflection +=
                self.follow(point, mirrored, share, MIRRORED, state.media.clone(), shading);
        }
        if !is_blurred || weights.mirror == 0.0 {
            return;
        }
        let (key, exponent) = (state.key.branch(BLURRED), material.highlight_exponent());
        for sample in 0..blurred {
            let direction = point.rough_mirror(exponent, key.point(sample, blurred));
            let share = DVec3::splat(weights.mirror / f64::from(blurred));
            let choice = BLURRED + 1 + sample;
            shading.stats.rays.reflection +=
                self.follow(point, direction, share, choice, state.media.clone(), shading);
        }
    }

    /// Adds one ray and returns 1. A ray whose weight is too small is replaced by the sky; the
    /// result is then 0.
    fn follow(
        &mut self,
        point: &SurfacePoint<'_>,
        direction: DVec3,
        share: DVec3,
        choice: u32,
        media: Media,
        shading: &mut ShadingState<'_, 'a>,
    ) -> u64 {
        let weight = point.state.weight * share;
        if weight.max_element() <= self.context.picture.least_weight {
            self.terminate(&media, direction, point.state.pixel, weight, shading);
            return 0;
        }
        let key = point.state.key.branch(choice);
        let is_from_floor = point.is_on_floor();
        let state = PathState { weight, key, media, is_from_floor, ..point.state };
        self.push(point.spawn(direction, point.footprint), state);
        1
    }

    /// Ends a path. It receives the sky, so that clear glass and mirrors lose no energy. Inside an
    /// absorbing medium it receives nothing.
    fn terminate(
        &self,
        media: &Media,
        direction: DVec3,
        pixel: usize,
        weight: DVec3,
        shading: &mut ShadingState<'_, 'a>,
    ) {
        if !media.absorbs() {
            shading.colors[pixel] += weight * self.context.sky(direction);
        }
    }

    /// Traces the rays. Returns the points that they hit, in the order of the rays. Rays without a
    /// hit add the sky to the colours.
    pub(crate) fn trace(&mut self, shading: &mut ShadingState<'_, 'a>) -> Vec<SurfacePoint<'a>> {
        let (scene, coarsened) = (self.context.scene, &mut shading.stats.coarsened);
        // Camera rays are alike too, but few of their beams are empty.
        let hits = if self.bounces == 0 || 2 * self.beams_tested > self.rays.len() {
            scene.intersect_many_counted(&self.rays, coarsened)
        } else {
            scene.intersect_alike(&self.rays, coarsened)
        };
        let mut points = Vec::with_capacity(hits.len());
        // Rays and hits are large, so they stay where they are.
        for ((ray, state), hit) in self.rays.iter().zip(self.states.drain(..)).zip(&hits) {
            let (pixel, weight) = (state.pixel, state.weight);
            match self.context.surface_point(ray, hit.as_ref(), state, shading) {
                Some(point) => points.push(point),
                None => shading.colors[pixel] += weight * self.context.sky(ray.ray.direction),
            }
        }
        self.rays.clear();
        points
    }

    /// Traces all rays, and the rays that they give rise to, to the end of each path. `seen` has points that rays of this
    /// bounce are known to hit.
    pub(crate) fn follow_all(mut self, mut seen: Vec<SurfacePoint<'a>>, shading: &mut ShadingState<'_, 'a>) {
        while !(self.rays.is_empty() && seen.is_empty()) {
            let mut points = self.trace(shading);
            // Points are large, so the shorter list moves.
            if points.len() < seen.len() {
                std::mem::swap(&mut points, &mut seen);
            }
            points.append(&mut seen);
            let lights = self.context.lights();
            direct::add_light(self.context, &points, &lights, false, shading);
            direct::add_ambient(self.context, &points, false, shading);
            self = Self::of_points(self.context, self.bounces + 1, &points, shading);
        }
    }
}
