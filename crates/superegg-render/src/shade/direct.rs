//! Direct light and ambient light at surface points.

use superegg_geom::glam::DVec3;
use superegg_scene::{AmbientOcclusion, Light};

use crate::camera::sobol::cosine_direction;
use crate::shade::context::RenderContext;
use crate::shade::grouped_light::GroupedLight;
use crate::shade::light_sample::toward;
use crate::shade::phong;
use crate::shade::point::SurfacePoint;
use crate::shade::shadow_batch::{add_transmitted, add_unoccluded};
use crate::shade::state::ShadingState;
use crate::stats::TraceStats;

/// Adds direct light at the points to the colours. `is_first` marks first hits, which
/// get more samples than hits after a reflection or refraction.
pub(crate) fn add_light<'l>(
    context: RenderContext<'_>,
    points: &[SurfacePoint<'_>],
    lights: &(impl Iterator<Item = (u32, &'l Light)> + Clone),
    is_first: bool,
    shading: &mut ShadingState<'_, '_>,
) {
    let mut grouped = GroupedLight::new(context, points, is_first);
    for (index, light) in lights.clone() {
        grouped.add_light(points, (index, light), shading);
    }
    for (end, rays) in grouped.into_rays() {
        add_unoccluded(context, rays.single, end, shading);
        add_transmitted(context, rays.dimmed, end, shading);
    }
}

/// Adds the light that the surfaces of the points give off.
pub(crate) fn add_emission(points: &[SurfacePoint<'_>], shading: &mut ShadingState<'_, '_>) {
    for point in points.iter().filter(|point| point.material.emission > 0.0) {
        shading.colors[point.state.pixel] +=
            point.state.weight * phong::emitted(&point.material, point.albedo);
    }
}

/// A branch of a [`crate::camera::sobol::SampleKey`].
const AMBIENT: u32 = 1;

/// Adds emission and the reflected ambient light: white from all directions, or with ambient occlusion the sky in the
/// unoccluded directions.
pub(crate) fn add_ambient(
    context: RenderContext<'_>,
    points: &[SurfacePoint<'_>],
    is_first: bool,
    shading: &mut ShadingState<'_, '_>,
) {
    add_emission(points, shading);
    let parts = points
        .iter()
        .map(|point| point.state.weight * phong::ambient(&point.material, &point.weights, point.albedo));
    let Some(occlusion) = context.environment.ambient_occlusion else {
        for (point, part) in points.iter().zip(parts) {
            shading.colors[point.state.pixel] += part;
        }
        return;
    };
    // Points after a reflection or refraction get a quarter of the samples.
    let count = if is_first { occlusion.samples.max(1) } else { occlusion.samples.div_ceil(4).max(1) };
    let parts: Vec<DVec3> = parts.collect();
    let is_lit = |i: usize| parts[i].max_element() > 0.0;
    for (i, direction) in open_directions(context, points, is_lit, count, occlusion.distance, shading.stats) {
        let sky = context.environment.sky.map_or(DVec3::ONE, |sky| sky.color(direction));
        shading.colors[points[i].state.pixel] += parts[i] * sky / f64::from(count);
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
            let direction = cosine_direction(key.point(sample, count), point.shading_normal());
            if point.open_part(direction) == 0.0 {
                continue;
            }
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
