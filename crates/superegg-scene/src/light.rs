//! Point lights, spot lights and directional lights.

use superegg_geom::glam::{DAffine3, DVec3};
use superegg_geom::unit_vector;

/// The position and direction of a light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LightKind {
    /// A point light: shines in all directions.
    Point {
        /// The position, in world units.
        position: DVec3,
    },
    /// A spot light: shines into a cone.
    Spot {
        /// The position, in world units.
        position: DVec3,
        /// A point on the axis of the cone; differs from `position`.
        target: DVec3,
        /// The full opening angle of the cone, in degrees, in (0, 180].
        cone_deg: f64,
        /// The fraction of the angle over which the light fades towards the rim, in [0, 1]: 0 gives
        /// a sharp rim, 1 fades from the axis on.
        soft: f64,
    },
    /// A directional light: parallel light from infinity.
    Sun {
        /// The direction towards the light; not zero, of any length.
        direction: DVec3,
    },
}

/// A light. Its attenuation at distance d is `1 / (1 + k d^2)`; a directional light has none.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Light {
    /// Position and direction.
    pub kind: LightKind,
    /// The linear colour, each channel >= 0; (1, 1, 1) is white, larger is brighter.
    pub color: DVec3,
    /// The attenuation coefficient k, >= 0, in 1 / (world unit)^2.
    pub falloff: f64,
    /// The radius of a spherical area light, >= 0, in world units; 0 gives hard shadows. For a
    /// directional light, the tangent of its angular radius (0.0047 for the sun).
    pub radius: f64,
}

impl Light {
    /// The light of a scene without lights: white, at (3, 4, 5), with k = 0.01.
    pub const DEFAULT: Self = Self {
        kind: LightKind::Point { position: DVec3::new(3.0, 4.0, 5.0) },
        color: DVec3::ONE,
        falloff: 0.01,
        radius: 0.0,
    };

    /// The position; `None` for a directional light.
    pub fn position(&self) -> Option<DVec3> {
        match self.kind {
            LightKind::Point { position } | LightKind::Spot { position, .. } => Some(position),
            LightKind::Sun { .. } => None,
        }
    }

    /// The unit direction from a point to the centre of the light; `None` if the point is the
    /// centre, or the difference overflows.
    #[inline]
    pub fn direction_from(&self, point: DVec3) -> Option<DVec3> {
        match self.kind {
            LightKind::Point { position } | LightKind::Spot { position, .. } => {
                let to_light = position - point;
                unit_vector(to_light).filter(|_| to_light.is_finite())
            }
            LightKind::Sun { direction } => unit_vector(direction),
        }
    }

    /// The unshadowed colour at a point, after attenuation and the cone. It is that of the centre
    /// of the light, whatever the radius.
    #[inline]
    pub fn color_at(&self, point: DVec3) -> DVec3 {
        let Some(position) = self.position() else { return self.color };
        let color = self.color * self.cone_factor(point);
        // Avoids 0 * infinity for a light so far away that the square overflows.
        if self.falloff == 0.0 {
            return color;
        }
        color / (1.0 + self.falloff * (position - point).length_squared())
    }

    /// The light with its points and directions transformed by `map`.
    pub fn through(&self, map: &DAffine3) -> Self {
        let kind = match self.kind {
            LightKind::Point { position } => LightKind::Point { position: map.transform_point3(position) },
            LightKind::Spot { position, target, cone_deg, soft } => LightKind::Spot {
                position: map.transform_point3(position),
                target: map.transform_point3(target),
                cone_deg,
                soft,
            },
            LightKind::Sun { direction } => LightKind::Sun { direction: map.transform_vector3(direction) },
        };
        Self { kind, ..*self }
    }

    /// The factor of the cone at a point, in [0, 1]: 1 except for spots, whose rim fades as 3 s^2 - 2 s^3.
    pub fn cone_factor(&self, point: DVec3) -> f64 {
        let LightKind::Spot { position, target, cone_deg, soft } = self.kind else { return 1.0 };
        let axis = unit_vector(target - position).unwrap_or(DVec3::NEG_Z);
        let Some(to_point) = unit_vector(point - position) else { return 1.0 };
        let half_rad = 0.5 * cone_deg.to_radians();
        // The arc cosine is inexact near the axis.
        let angle_rad = 2.0 * (0.5 * (to_point - axis).length()).clamp(0.0, 1.0).asin();
        if angle_rad >= half_rad {
            return 0.0;
        }
        let s = (half_rad - angle_rad) / (soft * half_rad);
        if s < 1.0 { s * s * (3.0 - 2.0 * s) } else { 1.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_spot_is_bright_on_its_axis_fades_to_its_rim_and_is_dark_beyond() {
        let spot = |soft| Light {
            kind: LightKind::Spot { position: DVec3::Z, target: DVec3::ZERO, cone_deg: 90.0, soft },
            falloff: 0.0,
            ..Light::DEFAULT
        };
        let at = |soft, x: f64| spot(soft).color_at(DVec3::new(x, 0.0, 0.0)).x;
        assert_eq!([at(0.0, 0.0), at(0.0, 0.99), at(0.0, 1.01)], [1.0, 1.0, 0.0]);
        assert_eq!([at(0.5, 0.0), at(0.5, 0.2), at(0.5, 1.01)], [1.0, 1.0, 0.0]);
        // Half of the way from 22.5 to 45 degrees.
        assert!((at(0.5, 33.75f64.to_radians().tan()) - 0.5).abs() < 1e-9);
        assert!(at(1.0, 0.1) < 1.0);
    }

    #[test]
    fn a_sun_does_not_fall_off() {
        let sun = Light { kind: LightKind::Sun { direction: DVec3::Y * 7.0 }, ..Light::DEFAULT };
        assert_eq!(sun.color_at(DVec3::splat(1e200)), DVec3::ONE);
        assert_eq!(sun.direction_from(DVec3::X), Some(DVec3::Y));
    }
}
