//! Direct light and ambient light at surface points.

use superegg_geom::glam::DVec3;
use superegg_geom::{Aabb, Ray};
use superegg_scene::{AmbientOcclusion, Light};

use crate::shade::context::RenderContext;
use crate::shade::grouped_light::{GroupedLight, RemainingRays};
use crate::shade::hemisphere::{Hemispheres, MOST_DIRECTIONS};
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
    let mut grouped = GroupedLight::new(context, is_first);
    grouped.add_light(points, lights, shading);
    for (RemainingRays { single, dimmed }, end) in grouped.remaining() {
        add_unoccluded(context, single, end, shading);
        add_transmitted(context, dimmed, end, shading);
    }
    grouped.finish();
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
    let parts: Vec<DVec3> = parts.map(|part| part / f64::from(count)).collect();
    let is_lit = |i: usize| parts[i].max_element() > 0.0;
    let sky = context.environment.sky.map(|sky| (sky, sky.unit_up()));
    for (i, direction) in open_directions(context, points, is_lit, count, occlusion.distance, shading.stats) {
        let sky = sky.map_or(DVec3::ONE, |(sky, up)| sky.color_at(direction.dot(up)));
        shading.colors[points[i].state.pixel] += parts[i] * sky;
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
    let bounds = context.scene.bounds();
    let mut samples =
        (0..points.len()).filter(|&i| is_sampled(i)).flat_map(|i| (0..count).map(move |sample| (i, sample)));
    let mut drawn = Vec::with_capacity(MOST_DIRECTIONS);
    let mut hemispheres = Hemispheres::new();
    let (mut rays, mut directions, mut clear) = (Vec::new(), Vec::new(), Vec::new());
    loop {
        drawn.clear();
        drawn.extend(samples.by_ref().take(MOST_DIRECTIONS));
        if drawn.is_empty() {
            break;
        }
        rays.reserve(drawn.len());
        for &(i, sample) in &drawn {
            let key = points[i].state.key.branch(AMBIENT);
            hemispheres.push(key, (sample, count), points[i].shading_normal());
        }
        for (&(i, _), direction) in drawn.iter().zip(hemispheres.draw()) {
            let point = &points[i];
            let ray = Ray::new(point.position, distance * direction);
            let is_open = point.open_part(direction) > 0.0
                && context.transmittance_past_floor(&ray, point.is_on_floor(), 1.0) > 0.0;
            if is_open && bounds.is_some_and(|bounds| is_near(&bounds, point, distance)) {
                rays.push(toward(point, ray.direction));
                directions.push((i, direction));
            } else if is_open {
                clear.push((i, direction));
            }
        }
    }
    stats.rays.ambient += (rays.len() + clear.len()) as u64;
    let occluded = context.scene.occluded_many_counted(&rays, 1.0, &mut stats.coarsened);
    let open = directions.into_iter().zip(occluded).filter(|(_, occluded)| !occluded);
    clear.into_iter().chain(open.map(|(open, _)| open))
}

/// Whether a ray of this length from a point may reach a box.
fn is_near(bounds: &Aabb, point: &SurfacePoint<'_>, length: f64) -> bool {
    let position = point.position;
    let between = position - position.clamp(bounds.min, bounds.max);
    // Directions are unit vectors to the precision of f32. NaN counts as near.
    let is_far = between.length() > (1.0 + 1e-5) * length + 2.0 * point.position_error;
    !is_far
}
