//! Samples of a light from a surface point.

use superegg_geom::glam::DVec3;
use superegg_geom::unit_vector;
use superegg_scene::Light;
use superegg_trace::{Footprint, TraceRay};

use crate::camera::sobol::{SampleKey, disc};
use crate::shade::context::RenderContext;
use crate::shade::phong;
use crate::shade::point::SurfacePoint;

/// A branch of a [`SampleKey`]. The index of a light is added.
pub(crate) const LIGHTS: u32 = 1 << 16;

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

/// The direction to the centre of a light, which is a unit vector for a sun, and its attenuated colour at the point. `None` if
/// the light does not shine towards the point.
#[inline]
pub(crate) fn toward_centre(light: &Light, point: DVec3) -> Option<(DVec3, DVec3)> {
    let color = light.color_at(point);
    let direction = match light.position() {
        Some(position) => position - point,
        None => light.direction_from(point)?,
    };
    let is_lit = color.max_element() > 0.0 && direction != DVec3::ZERO && direction.is_finite();
    is_lit.then_some((direction, color))
}

impl LightSample {
    /// The sample at the centre of a light. `None` if the light does not shine towards the point.
    pub(crate) fn to_centre(light: &Light, point: DVec3) -> Option<Self> {
        let (direction, color) = toward_centre(light, point)?;
        Some(Self { direction, unit: unit_vector(direction)?, color })
    }

    /// Sample `index` of `count` on the disc that an area light of this radius presents to the
    /// point.
    pub(crate) fn to_disc(self, radius: f64, key: SampleKey, index: u32, count: u32) -> Self {
        let on_disc = radius * disc(key.point(index, count));
        let (across, down) = self.unit.any_orthonormal_pair();
        let direction = self.direction + on_disc.x * across + on_disc.y * down;
        Self { direction, unit: unit_vector(direction).unwrap_or(self.unit), ..self }
    }
}

/// The reflected light of an unoccluded light sample. `None` if the point faces away from it.
pub(crate) fn unoccluded_light(
    context: &RenderContext<'_>,
    point: &SurfacePoint<'_>,
    sample: &LightSample,
) -> Option<DVec3> {
    let normal = point.shading_normal();
    let open = point.open_part(sample.unit);
    (open > 0.0 && point.facing_normal().dot(sample.unit) > 0.0).then_some(())?;
    if let Some(surface) = context.microfacets(point) {
        return Some(sample.color * surface.lit_by_lamp(sample.unit));
    }
    (normal.dot(sample.unit) > 0.0).then(|| {
        phong::direct(
            &point.material,
            &point.weights,
            point.albedo,
            open * sample.color,
            normal,
            point.to_eye,
            sample.unit,
        )
    })
}

/// A ray from a point whose width does not grow.
pub(crate) fn toward(point: &SurfacePoint<'_>, direction: DVec3) -> TraceRay {
    point.spawn(direction, Footprint { spread: 0.0, ..point.footprint })
}
