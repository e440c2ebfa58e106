//! Lights.

use superegg_geom::glam::{DAffine3, DVec3};
use superegg_geom::unit_vector;

/// Where a light stands and which way it shines.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LightKind {
    /// Shines from a place to all sides.
    Point {
        /// Where it stands, in world units.
        position: DVec3,
    },
    /// Shines from a place into a cone.
    Spot {
        /// Where it stands, in world units.
        position: DVec3,
        /// A point on the axis of the cone; not the position.
        target: DVec3,
        /// The angle of the cone from side to side, in degrees, above 0 and at most 180.
        cone_deg: f64,
        /// The share of that angle over which light fades towards the rim, [0, 1]: 0 is a sharp rim, 1 fades from the axis on.
        soft: f64,
    },
    /// Shines from infinitely far away, everywhere alike.
    Sun {
        /// The direction from which light comes (towards the sun); not zero, of any length.
        direction: DVec3,
    },
}

/// A light. At distance d its light has fallen to `color / (1 + k d^2)`; that of a sun does not fall.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Light {
    /// Where it stands and which way it shines.
    pub kind: LightKind,
    /// Its linear colour, each part >= 0; 1 1 1 is white, larger is brighter.
    pub color: DVec3,
    /// The k of the falloff, >= 0, per square of a world unit.
    pub falloff: f64,
    /// The radius of the ball that shines, >= 0, in world units: shadows are hard at 0. For a sun that of its disc seen at distance 1,
    /// the tangent of half the angle that it fills (0.0047 for ours).
    pub radius: f64,
}

impl Light {
    /// The light of a scene that names none: white at (3, 4, 5) with k = 0.01.
    pub const DEFAULT: Self = Self {
        kind: LightKind::Point { position: DVec3::new(3.0, 4.0, 5.0) },
        color: DVec3::ONE,
        falloff: 0.01,
        radius: 0.0,
    };

    /// Where it stands; `None` for a sun.
    pub fn position(&self) -> Option<DVec3> {
        match self.kind {
            LightKind::Point { position } | LightKind::Spot { position, .. } => Some(position),
            LightKind::Sun { .. } => None,
        }
    }

    /// The unit direction from a point to the middle of the light; `None` where the point is its own place, or the way is too long for a number.
    pub fn direction_from(&self, point: DVec3) -> Option<DVec3> {
        match self.kind {
            LightKind::Point { position } | LightKind::Spot { position, .. } => {
                let way = position - point;
                unit_vector(way).filter(|_| way.is_finite())
            }
            LightKind::Sun { direction } => unit_vector(direction),
        }
    }

    /// The light's colour as it comes to a point, after falloff and the cone, with nothing in the way; from the light's middle, whatever its
    /// radius.
    pub fn color_at(&self, point: DVec3) -> DVec3 {
        let Some(position) = self.position() else { return self.color };
        let color = self.color * self.share_of_cone(point);
        // Not 0 times infinity for a light beyond the root of the largest number.
        if self.falloff == 0.0 {
            return color;
        }
        color / (1.0 + self.falloff * (position - point).length_squared())
    }

    /// The same light with its places and directions carried through a map of space.
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

    /// The share of the light that goes towards a point: 1 but for spots, whose rim fades as 3 s^2 - 2 s^3.
    fn share_of_cone(&self, point: DVec3) -> f64 {
        let LightKind::Spot { position, target, cone_deg, soft } = self.kind else { return 1.0 };
        let axis = unit_vector(target - position).unwrap_or(DVec3::NEG_Z);
        let Some(way) = unit_vector(point - position) else { return 1.0 };
        let half_rad = 0.5 * cone_deg.to_radians();
        // Not the arc cosine, which is inexact near the axis.
        let angle_rad = 2.0 * (0.5 * (way - axis).length()).clamp(0.0, 1.0).asin();
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
