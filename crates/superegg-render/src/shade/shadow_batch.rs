//! Shadow rays that are traced through the scene, also through transparent surfaces.

use superegg_geom::glam::DVec3;
use superegg_geom::{Ray, unit_vector};
use superegg_scene::Material;
use superegg_trace::{Side, SurfaceStart, TraceRay};

use crate::shade::context::RenderContext;
use crate::shade::medium::Media;
use crate::shade::phong;
use crate::shade::point::{PathState, SurfacePoint, SurfaceView};
use crate::shade::state::ShadingState;
use crate::shade::surfaces::Located;

/// Shadow rays, and the contribution of each if it is unoccluded.
#[derive(Default)]
pub(crate) struct ShadowBatch {
    rays: Vec<TraceRay>,
    contributions: Vec<Contribution>,
}

/// The contribution of a shadow ray to a pixel.
#[derive(Clone)]
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

    fn clear(&mut self) {
        self.rays.clear();
        self.contributions.clear();
    }

    /// Each contribution with its ray.
    fn pairs(&self) -> impl Iterator<Item = (&Contribution, &TraceRay)> {
        self.contributions.iter().zip(&self.rays)
    }
}

impl Contribution {
    /// Adds the contribution, dimmed by the media over a distance in world units.
    fn add_after(&self, distance: f64, colors: &mut [DVec3]) {
        colors[self.pixel] += self.color * self.media.transmittance(distance);
    }
}

/// Traces shadow rays up to t = `end` and adds the light that arrives. The batch is empty then.
pub(crate) fn add_unoccluded(
    context: RenderContext<'_>,
    batch: &mut ShadowBatch,
    end: f64,
    shading: &mut ShadingState<'_, '_>,
) {
    if batch.rays.is_empty() {
        return;
    }
    shading.stats.rays.shadow += batch.rays.len() as u64;
    let occluded = context.scene.occluded_many_counted(&batch.rays, end, &mut shading.stats.coarsened);
    let mut dimmed = ShadowBatch::default();
    for ((contribution, ray), occluded) in batch.pairs().zip(occluded) {
        if !occluded {
            contribution.add_after(ray.ray.direction.length(), shading.colors);
        } else if context.has_transmission {
            dimmed.rays.push(ray.clone());
            dimmed.contributions.push(contribution.clone());
        }
    }
    batch.clear();
    add_transmitted(context, &mut dimmed, end, shading);
}

/// The part of the light that goes straight through a surface, with the cosine of the angle to its normal, and the ratio of
/// the indices of refraction on both sides.
pub(crate) fn passed_surface(material: &Material, albedo: DVec3, cos: f64, ratio: f64) -> DVec3 {
    let weights = phong::LobeWeights::of(material, cos);
    let unreflected = 1.0 - phong::reflectance(cos, ratio.max(ratio.recip()));
    weights.transmitted * unreflected * albedo.map(f64::sqrt)
}

/// Follows occluded shadow rays through transparent surfaces in a straight line and adds the light
/// that arrives. Each surface tints the light and reflects its Fresnel part, which makes the rim of
/// a glass sphere's shadow dark; each medium absorbs. There is no refraction, so no caustics. The batch is empty then.
pub(crate) fn add_transmitted(
    context: RenderContext<'_>,
    batch: &mut ShadowBatch,
    end: f64,
    shading: &mut ShadingState<'_, '_>,
) {
    let mut next = ShadowBatch::default();
    for _ in 0..=context.picture.bounces {
        if batch.rays.is_empty() {
            return;
        }
        let hits = context.scene.intersect_alike(&batch.rays, &mut shading.stats.coarsened);
        shading.stats.rays.shadow += hits.len() as u64;
        next.clear();
        for ((contribution, ray), hit) in batch.pairs().zip(&hits) {
            let Some(hit) = hit.as_ref().filter(|hit| hit.t < end) else {
                contribution.add_after(ray.ray.direction.length(), shading.colors);
                continue;
            };
            let surface = shading.surfaces.at(hit);
            let Located { position, position_error, normal } = surface.locate(hit);
            let direction = ray.ray.direction;
            let distance = (position - ray.ray.origin).length();
            let view = SurfaceView {
                normal,
                direction: unit_vector(direction).unwrap_or(normal),
                width: ray.footprint.width,
            };
            let albedo = context
                .finish(&surface.material, surface.primitive, hit.unit_point, &surface.world_from_unit, &view)
                .albedo;
            let cos = view.direction.dot(normal).abs();
            let (before, beyond) = contribution.media.across(&surface.path, &surface.material, hit.leaving);
            let color = contribution.color
                * contribution.media.transmittance(distance)
                * passed_surface(&surface.material, albedo, cos, beyond.index() / before);
            if color.max_element() > context.picture.least_weight {
                // The light stays at t = 1.
                let direction = if end.is_finite() { ray.ray.point_at(1.0) - position } else { direction };
                let side = if hit.leaving { Side::Outward } else { Side::Inward };
                let start = Some(SurfaceStart { path: hit.path.clone(), side });
                let onward = Ray { origin: position, direction, origin_error: position_error };
                let rest = TraceRay { ray: onward, start, footprint: ray.footprint };
                next.rays.push(rest);
                next.contributions.push(Contribution { pixel: contribution.pixel, color, media: beyond });
            }
        }
        std::mem::swap(batch, &mut next);
    }
    batch.clear();
}
