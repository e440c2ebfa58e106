//! The light that comes to points of surfaces straight from lights and from all around.

use std::rc::Rc;

use superegg_geom::glam::DVec3;
use superegg_geom::unit_vector;
use superegg_scene::{AmbientOcclusion, Light};
use superegg_trace::{Footprint, Side, TraceRay};

use crate::camera::sobol::{SampleKey, cosine_direction, disc};
use crate::shade::context::RenderContext;
use crate::shade::medium::Media;
use crate::shade::phong;
use crate::shade::point::{PathState, SurfacePoint, SurfaceView};
use crate::stats::TraceStats;

/// A way from a point to a light.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LightSample {
    /// To the light: t = 1 is its place; a unit vector to a sun.
    pub(crate) direction: DVec3,
    /// The same as a unit vector.
    pub(crate) unit: DVec3,
    /// The light's colour as it comes to the point.
    pub(crate) color: DVec3,
}

impl LightSample {
    /// The way to the middle of a light; `None` where none of its light comes, whatever is between.
    pub(crate) fn to_middle(light: &Light, point: DVec3) -> Option<Self> {
        let color = light.color_at(point);
        let unit = light.direction_from(point).filter(|_| color.max_element() > 0.0)?;
        let direction = light.position().map_or(unit, |position| position - point);
        Some(Self { direction, unit, color })
    }

    /// The way to a place on the disc that a light of some radius shows to the point.
    fn to_disc(self, radius: f64, key: SampleKey, place: u32, count: u32) -> Self {
        let on_disc = radius * disc(key.point(place, count));
        let (across, down) = self.unit.any_orthonormal_pair();
        let direction = self.direction + on_disc.x * across + on_disc.y * down;
        Self { direction, unit: unit_vector(direction).unwrap_or(self.unit), ..self }
    }
}

/// Rays to lights, and what each adds where nothing is between.
#[derive(Default)]
pub(crate) struct ShadowBatch {
    flights: Vec<TraceRay>,
    adds: Vec<Contribution>,
}

/// What a shadow ray adds to a pixel, and what it is in.
struct Contribution {
    pixel: usize,
    color: DVec3,
    media: Media,
}

impl ShadowBatch {
    /// Takes a ray from a point.
    pub(crate) fn push(&mut self, point: &SurfacePoint<'_>, flight: TraceRay, color: DVec3) {
        self.flights.push(flight);
        let PathState { pixel, media, .. } = &point.state;
        self.adds.push(Contribution { pixel: *pixel, color, media: media.clone() });
    }

    /// Each ray with what it adds.
    fn into_pairs(self) -> impl Iterator<Item = (Contribution, TraceRay)> {
        self.adds.into_iter().zip(self.flights)
    }
}

impl Contribution {
    /// What is left of it at the end of a way, in world units.
    fn add_after(&self, way: f64, colors: &mut [DVec3]) {
        colors[self.pixel] += self.color * self.media.transmittance(way);
    }
}

/// Adds to the colours what lights bring to points, and what comes from all around.
pub(crate) fn add_light<'l>(
    context: RenderContext<'_>,
    points: &[SurfacePoint<'_>],
    lights: &(impl Iterator<Item = (u32, &'l Light)> + Clone),
    is_first: bool,
    colors: &mut [DVec3],
    stats: &mut TraceStats,
) {
    let (mut ending, mut endless) = (ShadowBatch::default(), ShadowBatch::default());
    for point in points {
        for (number, light) in lights.clone() {
            let rays = if light.position().is_some() { &mut ending } else { &mut endless };
            sample_light(context, point, number, light, is_first, rays);
        }
    }
    add_unoccluded(context, ending, 1.0, colors, stats);
    add_unoccluded(context, endless, f64::INFINITY, colors, stats);
    add_ambient(context, points, is_first, colors, stats);
}

/// The rays from a point to a light: one, or some where it has a radius.
fn sample_light(
    context: RenderContext<'_>,
    point: &SurfacePoint<'_>,
    number: u32,
    light: &Light,
    is_first: bool,
    asked: &mut ShadowBatch,
) {
    let Some(middle) = LightSample::to_middle(light, point.position) else { return };
    let end = if light.position().is_some() { 1.0 } else { f64::INFINITY };
    let count = if light.radius > 0.0 && is_first { context.picture.light_rays.max(1) } else { 1 };
    let key = point.state.key.branch(LIGHTS + number);
    for place in 0..count {
        let way = if light.radius > 0.0 { middle.to_disc(light.radius, key, place, count) } else { middle };
        let Some(color) = unoccluded_light(point, &way) else { continue };
        let flight = toward(point, way.direction);
        let past_floor = context.transmittance_past_floor(&flight.ray, point.is_on_floor(), end);
        if past_floor > 0.0 {
            asked.push(point, flight, past_floor * point.state.weight * color / f64::from(count));
        }
    }
}

/// Choices of a [`SampleKey`]; a light's number is added to the first.
const LIGHTS: u32 = 1 << 16;
const AMBIENT: u32 = 1;

/// What a light adds to a point that nothing hides from it; `None` where it shines on the other side.
pub(crate) fn unoccluded_light(point: &SurfacePoint<'_>, way: &LightSample) -> Option<DVec3> {
    let normal = point.facing_normal();
    (normal.dot(way.unit) > 0.0).then(|| {
        phong::direct(
            &point.material,
            &point.weights,
            point.albedo,
            way.color,
            normal,
            point.to_eye,
            way.unit,
        )
    })
}

/// Traces shadow rays up to t = `end`, and adds what comes through.
fn add_unoccluded(
    context: RenderContext<'_>,
    asked: ShadowBatch,
    end: f64,
    colors: &mut [DVec3],
    stats: &mut TraceStats,
) {
    stats.rays.shadow += asked.flights.len() as u64;
    let stopped = context.scene.occluded_many(&asked.flights, end);
    let mut dimmed = ShadowBatch::default();
    for ((addition, flight), stopped) in asked.into_pairs().zip(stopped) {
        if !stopped {
            addition.add_after(flight.ray.direction.length(), colors);
        } else if context.lets_light_through {
            dimmed.flights.push(flight);
            dimmed.adds.push(addition);
        }
    }
    add_transmitted(context, dimmed, end, colors, stats);
}

/// Follows rays that something stops straight on through what lets light through: each surface takes its share and colours the rest, each inside
/// takes what it absorbs. Each also mirrors its part away, which makes the rim of a glass ball's shadow dark; but light is not bent on this way, so there is
/// no bright focus in it.
pub(crate) fn add_transmitted(
    context: RenderContext<'_>,
    mut rays: ShadowBatch,
    end: f64,
    colors: &mut [DVec3],
    stats: &mut TraceStats,
) {
    for _ in 0..=context.picture.bounces {
        if rays.flights.is_empty() {
            return;
        }
        let hits = context.scene.intersect_many(&rays.flights);
        stats.rays.shadow += hits.len() as u64;
        let mut next = ShadowBatch::default();
        for ((addition, flight), hit) in rays.into_pairs().zip(hits) {
            let Some(hit) = hit.filter(|hit| hit.t < end) else {
                addition.add_after(flight.ray.direction.length(), colors);
                continue;
            };
            let surface = context.scene.interaction(&hit);
            let direction = flight.ray.direction;
            let way = (surface.position - flight.ray.origin).length();
            let seen = SurfaceView {
                normal: surface.normal,
                direction: unit_vector(direction).unwrap_or(surface.normal),
                width: flight.footprint.width,
            };
            let albedo = context.albedo(&surface.material, &hit, &seen);
            let cos = seen.direction.dot(surface.normal).abs();
            let weights = phong::LobeWeights::of(&surface.material, cos);
            let path = Rc::new(hit.path);
            let (before, beyond) = addition.media.across(&path, &surface.material, surface.leaving);
            let ratio = beyond.index() / before;
            let clear = 1.0 - phong::reflectance(cos, ratio.max(ratio.recip()));
            let color = addition.color
                * addition.media.transmittance(way)
                * weights.transmitted
                * clear
                * albedo.map(f64::sqrt);
            if color.max_element() > context.picture.least_weight {
                // t = 1 stays the place of the light.
                let rest =
                    if end.is_finite() { flight.ray.point_at(1.0) - surface.position } else { direction };
                let mut ray = surface.spawn_ray(rest).with_footprint(flight.footprint);
                if let Some(start) = &mut ray.start {
                    start.side = if surface.leaving { Side::Outward } else { Side::Inward };
                }
                next.flights.push(ray);
                next.adds.push(Contribution { pixel: addition.pixel, color, media: beyond });
            }
        }
        rays = next;
    }
}

/// Adds the ambient part: of white light from all sides, or with ambient occlusion of what comes from the sky within its distance.
fn add_ambient(
    context: RenderContext<'_>,
    points: &[SurfacePoint<'_>],
    is_first: bool,
    colors: &mut [DVec3],
    stats: &mut TraceStats,
) {
    let parts = points
        .iter()
        .map(|point| point.state.weight * phong::ambient(&point.material, &point.weights, point.albedo));
    let Some(occlusion) = context.environment.ambient_occlusion else {
        for (point, part) in points.iter().zip(parts) {
            colors[point.state.pixel] += part;
        }
        return;
    };
    // What is seen in mirrors and through glass gets fewer.
    let count = if is_first { occlusion.samples.max(1) } else { occlusion.samples.div_ceil(4).max(1) };
    let parts: Vec<DVec3> = parts.collect();
    let lit = |i: usize| parts[i].max_element() > 0.0;
    for (i, direction) in open_directions(context, points, lit, count, occlusion.distance, stats) {
        let sky = context.environment.sky.map_or(DVec3::ONE, |sky| sky.color(direction));
        colors[points[i].state.pixel] += parts[i] * sky / f64::from(count);
    }
}

/// Of rays from each point to all sides of its surface the share that gets as far as it should.
pub(crate) fn open_fractions(
    context: RenderContext<'_>,
    occlusion: AmbientOcclusion,
    points: &[SurfacePoint<'_>],
    stats: &mut TraceStats,
) -> Vec<f64> {
    let count = occlusion.samples.max(1);
    let mut weights = vec![0.0; points.len()];
    for (i, _) in open_directions(context, points, |_| true, count, occlusion.distance, stats) {
        weights[i] += 1.0 / f64::from(count);
    }
    weights
}

/// The unit directions to all sides of the points that are asked for in which nothing is within the distance, with the numbers of the points.
fn open_directions(
    context: RenderContext<'_>,
    points: &[SurfacePoint<'_>],
    is_asked: impl Fn(usize) -> bool,
    count: u32,
    distance: f64,
    stats: &mut TraceStats,
) -> impl Iterator<Item = (usize, DVec3)> {
    let (mut rays, mut ways) = (Vec::new(), Vec::new());
    for (i, point) in points.iter().enumerate().filter(|(i, _)| is_asked(*i)) {
        let key = point.state.key.branch(AMBIENT);
        for place in 0..count {
            let direction = cosine_direction(key.point(place, count), point.facing_normal());
            let ray = toward(point, distance * direction);
            if context.transmittance_past_floor(&ray.ray, point.is_on_floor(), 1.0) > 0.0 {
                rays.push(ray);
                ways.push((i, direction));
            }
        }
    }
    stats.rays.ambient += rays.len() as u64;
    let stopped = context.scene.occluded_many(&rays, 1.0);
    ways.into_iter().zip(stopped).filter(|(_, stopped)| !stopped).map(|(way, _)| way)
}

/// A ray from a point to a light.
pub(crate) fn toward(point: &SurfacePoint<'_>, direction: DVec3) -> TraceRay {
    point.spawn(direction, Footprint { spread: 0.0, ..point.footprint })
}
