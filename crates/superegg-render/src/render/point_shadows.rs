//! Shadow rays to a point light from first hits that are shaded in f64.

use superegg_geom::Ray;
use superegg_geom::glam::DVec3;
use superegg_scene::Light;
use superegg_trace::packet::{LANES, ShadowRay, ShadowStart};

use crate::render::primary_hits::PrimaryPoints;
use crate::render::shadow_queue::ShadowQueue;
use crate::shade::context::RenderContext;
use crate::shade::light_sample::{LightSample, toward, unoccluded_light};
use crate::shade::lit_points::{LitPoints, SampledLight};
use crate::shade::point::SurfacePoint;
use crate::shade::shadow_batch::ShadowBatch;

/// The queued shadow rays of points. They follow the rays of lanes in the [`ShadowQueue`].
pub(crate) struct PointShadows {
    /// The index of the point of each ray, and the colour that the light adds if unoccluded.
    queued: Vec<(u32, DVec3)>,
    lit: LitPoints,
    samples: Vec<SampledLight>,
}

impl PointShadows {
    pub(crate) fn new() -> Self {
        Self { queued: Vec::new(), lit: LitPoints::default(), samples: Vec::new() }
    }

    /// Queues the shadow rays of all points that face a light. Returns the least width of a ray.
    pub(crate) fn queue(
        &mut self,
        context: &RenderContext<'_>,
        hits: &PrimaryPoints<'_>,
        (light_index, light): (u32, &Light),
        light_position: DVec3,
        queue: &mut ShadowQueue,
    ) -> f64 {
        let Self { queued, lit, samples } = self;
        queued.clear();
        lit.clear();
        let mut least_width = f64::INFINITY;
        let mut push = |index: usize, color: DVec3| {
            let (point, own) = (&hits.points[index], hits.candidates[index]);
            let ShadowRay { ray, width } = shadow_ray(point, light_position);
            let past_floor = context.transmittance_past_floor(&ray, own.is_none(), 1.0);
            if past_floor > 0.0 {
                least_width = least_width.min(width);
                queue.push(ray.direction, ShadowStart { own, start: point.start(ray.direction) });
                queued.push((index as u32, past_floor * color));
            }
        };
        let mut push_single = |index: usize| {
            let point = &hits.points[index];
            let sample = LightSample::to_centre(light, point.position);
            let color = sample.and_then(|sample| unoccluded_light(context, point, &sample));
            color.into_iter().for_each(|color| push(index, point.state.weight * color));
        };
        for (index, point) in hits.points.iter().enumerate() {
            // Facets and bumps are not shaded in lanes.
            if context.has_facets(point) || point.bump.is_some() {
                push_single(index);
            } else {
                lit.add(index, point);
            }
        }
        lit.find(light, 1, push_single);
        lit.sample((light_index, light));
        lit.list_samples(0.0, samples);
        for &SampledLight { point, color, .. } in &*samples {
            push(point, color);
        }
        least_width
    }

    /// The shadow ray at an index among the rays of points.
    pub(crate) fn ray(&self, index: usize, points: &[SurfacePoint<'_>], light: DVec3) -> ShadowRay {
        shadow_ray(&points[self.queued[index].0 as usize], light)
    }

    /// Adds the light of unoccluded rays to the colours. The first ray of a point has index `first`
    /// among the bits of `occluded`. Returns the occluded rays if surfaces may transmit light.
    pub(crate) fn add_unoccluded(
        &self,
        context: &RenderContext<'_>,
        points: &[SurfacePoint<'_>],
        light: DVec3,
        (first, occluded): (usize, &[u32]),
        colors: &mut [DVec3],
    ) -> ShadowBatch {
        let mut dimmed = ShadowBatch::default();
        for (i, &(point, color)) in (first..).zip(&self.queued) {
            let point = &points[point as usize];
            if occluded[i / LANES] >> (i % LANES) & 1 == 0 {
                let media = &point.state.media;
                colors[point.state.pixel] += color * media.transmittance_between(point.position, light);
            } else if context.has_transmission {
                dimmed.push(point, toward(point, light - point.position), color);
            }
        }
        dimmed
    }
}

/// The ray from a point to a light.
fn shadow_ray(point: &SurfacePoint<'_>, light: DVec3) -> ShadowRay {
    let direction = light - point.position;
    let ray = Ray { origin: point.position, direction, origin_error: point.position_error };
    ShadowRay { ray, width: point.footprint.width }
}
