//! Direct light and ambient light at surface points.

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

/// A direction from a point to a light, with the light from there.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LightSample {
    /// To the light, which is at t = 1; a unit vector for a directional light.
    pub(crate) direction: DVec3,
    /// The unit vector of `direction`.
    pub(crate) unit: DVec3,
    /// The attenuated colour of the light at the point.
    pub(crate) color: DVec3,
}

impl LightSample {
    /// The sample at the centre of a light. `None` if the light does not shine towards the point.
    pub(crate) fn to_centre(light: &Light, point: DVec3) -> Option<Self> {
        let color = light.color_at(point);
        let unit = light.direction_from(point).filter(|_| color.max_element() > 0.0)?;
        let direction = light.position().map_or(unit, |position| position - point);
        Some(Self { direction, unit, color })
    }

    /// Sample `index` of `count` on the disc that an area light of this radius presents to the
    /// point.
    fn to_disc(self, radius: f64, key: SampleKey, index: u32, count: u32) -> Self {
        let on_disc = radius * disc(key.point(index, count));
        let (across, down) = self.unit.any_orthonormal_pair();
        let direction = self.direction + on_disc.x * across + on_disc.y * down;
        Self { direction, unit: unit_vector(direction).unwrap_or(self.unit), ..self }
    }
}

/// Shadow rays, and the contribution of each if it is unoccluded.
#[derive(Default)]
pub(crate) struct ShadowBatch {
    rays: Vec<TraceRay>,
    contributions: Vec<Contribution>,
}

/// The contribution of a shadow ray to a pixel.
struct Contribution {
    pixel: usize,
    color: DVec3,
    /// The media that the ray passes.
    media: Media,
}

impl ShadowBatch {
    /// Adds a ray from a point. `color` is its unoccluded contribution.
    pub(crate) fn push(&mut self, point: &SurfacePoint<'_>, ray: TraceRay, color: DVec3) {
        self.rays.push(ray);
        let PathState { pixel, media, .. } = &point.state;
        self.contributions.push(Contribution { pixel: *pixel, color, media: media.clone() });
    }

    /// Each ray with its contribution.
    fn into_pairs(self) -> impl Iterator<Item = (Contribution, TraceRay)> {
        self.contributions.into_iter().zip(self.rays)
    }
}

impl Contribution {
    /// Adds the contribution, dimmed by the media over a distance in world units.
    fn add_after(&self, distance: f64, colors: &mut [DVec3]) {
        colors[self.pixel] += self.color * self.media.transmittance(distance);
    }
}

/// Adds direct and ambient light at the points to the colours. `is_first` marks first hits, which
/// get more samples than hits after a reflection or refraction.
pub(crate) fn add_light<'l>(
    context: RenderContext<'_>,
    points: &[SurfacePoint<'_>],
    lights: &(impl Iterator<Item = (u32, &'l Light)> + Clone),
    is_first: bool,
    colors: &mut [DVec3],
    stats: &mut TraceStats,
) {
    let (mut finite, mut infinite) = (ShadowBatch::default(), ShadowBatch::default());
    for point in points {
        for (index, light) in lights.clone() {
            let batch = if light.position().is_some() { &mut finite } else { &mut infinite };
            sample_light(context, point, (index, light), is_first, batch);
        }
    }
    add_unoccluded(context, finite, 1.0, colors, stats);
    add_unoccluded(context, infinite, f64::INFINITY, colors, stats);
    add_ambient(context, points, is_first, colors, stats);
}

/// Adds the shadow rays from a point to a light: one, or several for an area light.
fn sample_light(
    context: RenderContext<'_>,
    point: &SurfacePoint<'_>,
    (index, light): (u32, &Light),
    is_first: bool,
    batch: &mut ShadowBatch,
) {
    let Some(centre) = LightSample::to_centre(light, point.position) else { return };
    let end = if light.position().is_some() { 1.0 } else { f64::INFINITY };
    let count = if light.radius > 0.0 && is_first { context.picture.light_rays.max(1) } else { 1 };
    let key = point.state.key.branch(LIGHTS + index);
    for i in 0..count {
        let sample = if light.radius > 0.0 { centre.to_disc(light.radius, key, i, count) } else { centre };
        let Some(color) = unoccluded_light(point, &sample) else { continue };
        let ray = toward(point, sample.direction);
        let past_floor = context.transmittance_past_floor(&ray.ray, point.is_on_floor(), end);
        if past_floor > 0.0 {
            batch.push(point, ray, past_floor * point.state.weight * color / f64::from(count));
        }
    }
}

/// Branches of a [`SampleKey`]. The index of a light is added to the first.
const LIGHTS: u32 = 1 << 16;
const AMBIENT: u32 = 1;

/// The reflected light of an unoccluded light sample. `None` if the point faces away from it.
pub(crate) fn unoccluded_light(point: &SurfacePoint<'_>, sample: &LightSample) -> Option<DVec3> {
    let normal = point.facing_normal();
    (normal.dot(sample.unit) > 0.0).then(|| {
        phong::direct(
            &point.material,
            &point.weights,
            point.albedo,
            sample.color,
            normal,
            point.to_eye,
            sample.unit,
        )
    })
}

/// Traces shadow rays up to t = `end` and adds the light that arrives.
fn add_unoccluded(
    context: RenderContext<'_>,
    batch: ShadowBatch,
    end: f64,
    colors: &mut [DVec3],
    stats: &mut TraceStats,
) {
    stats.rays.shadow += batch.rays.len() as u64;
    let occluded = context.scene.occluded_many_counted(&batch.rays, end, &mut stats.coarsened);
    let mut dimmed = ShadowBatch::default();
    for ((contribution, ray), occluded) in batch.into_pairs().zip(occluded) {
        if !occluded {
            contribution.add_after(ray.ray.direction.length(), colors);
        } else if context.has_transmission {
            dimmed.rays.push(ray);
            dimmed.contributions.push(contribution);
        }
    }
    add_transmitted(context, dimmed, end, colors, stats);
}

/// Follows occluded shadow rays through transparent surfaces in a straight line and adds the light
/// that arrives. Each surface tints the light and reflects its Fresnel part, which makes the rim of
/// a glass sphere's shadow dark; each medium absorbs. There is no refraction, so no caustics.
pub(crate) fn add_transmitted(
    context: RenderContext<'_>,
    mut batch: ShadowBatch,
    end: f64,
    colors: &mut [DVec3],
    stats: &mut TraceStats,
) {
    for _ in 0..=context.picture.bounces {
        if batch.rays.is_empty() {
            return;
        }
        let hits = context.scene.intersect_many_counted(&batch.rays, &mut stats.coarsened);
        stats.rays.shadow += hits.len() as u64;
        let mut next = ShadowBatch::default();
        for ((contribution, ray), hit) in batch.into_pairs().zip(hits) {
            let Some(hit) = hit.filter(|hit| hit.t < end) else {
                contribution.add_after(ray.ray.direction.length(), colors);
                continue;
            };
            let surface = context.scene.interaction(&hit);
            let direction = ray.ray.direction;
            let distance = (surface.position - ray.ray.origin).length();
            let view = SurfaceView {
                normal: surface.normal,
                direction: unit_vector(direction).unwrap_or(surface.normal),
                width: ray.footprint.width,
            };
            let albedo = context.albedo(&surface.material, &hit, &view);
            let cos = view.direction.dot(surface.normal).abs();
            let weights = phong::LobeWeights::of(&surface.material, cos);
            let path = Rc::new(hit.path);
            let (before, beyond) = contribution.media.across(&path, &surface.material, surface.leaving);
            let ratio = beyond.index() / before;
            let unreflected = 1.0 - phong::reflectance(cos, ratio.max(ratio.recip()));
            let color = contribution.color
                * contribution.media.transmittance(distance)
                * weights.transmitted
                * unreflected
                * albedo.map(f64::sqrt);
            if color.max_element() > context.picture.least_weight {
                // The light stays at t = 1.
                let to_light =
                    if end.is_finite() { ray.ray.point_at(1.0) - surface.position } else { direction };
                let mut rest = surface.spawn_ray(to_light).with_footprint(ray.footprint);
                if let Some(start) = &mut rest.start {
                    start.side = if surface.leaving { Side::Outward } else { Side::Inward };
                }
                next.rays.push(rest);
                next.contributions.push(Contribution { pixel: contribution.pixel, color, media: beyond });
            }
        }
        batch = next;
    }
}

/// Adds the reflected ambient light: white from all directions, or with ambient occlusion the sky
/// in the unoccluded directions.
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
    // Points after a reflection or refraction get a quarter of the samples.
    let count = if is_first { occlusion.samples.max(1) } else { occlusion.samples.div_ceil(4).max(1) };
    let parts: Vec<DVec3> = parts.collect();
    let is_lit = |i: usize| parts[i].max_element() > 0.0;
    for (i, direction) in open_directions(context, points, is_lit, count, occlusion.distance, stats) {
        let sky = context.environment.sky.map_or(DVec3::ONE, |sky| sky.color(direction));
        colors[points[i].state.pixel] += parts[i] * sky / f64::from(count);
    }
}

/// The fraction of cosine-weighted directions from each point without a hit within the distance.
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

/// Cosine-weighted unit directions without a hit within the distance, each with the index of its
/// point. Only points for which `is_sampled` holds are sampled, with `count` directions each.
fn open_directions(
    context: RenderContext<'_>,
    points: &[SurfacePoint<'_>],
    is_sampled: impl Fn(usize) -> bool,
    count: u32,
    distance: f64,
    stats: &mut TraceStats,
) -> impl Iterator<Item = (usize, DVec3)> {
    let (mut rays, mut directions) = (Vec::new(), Vec::new());
    for (i, point) in points.iter().enumerate().filter(|(i, _)| is_sampled(*i)) {
        let key = point.state.key.branch(AMBIENT);
        for sample in 0..count {
            let direction = cosine_direction(key.point(sample, count), point.facing_normal());
            let ray = toward(point, distance * direction);
            if context.transmittance_past_floor(&ray.ray, point.is_on_floor(), 1.0) > 0.0 {
                rays.push(ray);
                directions.push((i, direction));
            }
        }
    }
    stats.rays.ambient += rays.len() as u64;
    let occluded = context.scene.occluded_many_counted(&rays, 1.0, &mut stats.coarsened);
    directions.into_iter().zip(occluded).filter(|(_, occluded)| !occluded).map(|(open, _)| open)
}

/// A ray from a point whose width does not grow.
pub(crate) fn toward(point: &SurfacePoint<'_>, direction: DVec3) -> TraceRay {
    point.spawn(direction, Footprint { spread: 0.0, ..point.footprint })
}
