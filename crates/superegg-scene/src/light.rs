//! Lights.

use superegg_geom::glam::DVec3;

/// A point light. At distance d its light has fallen to `color / (1 + k d^2)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Light {
    /// Where it stands, in world units.
    pub position: DVec3,
    /// Its linear colour, each part >= 0; 1 1 1 is white, larger is brighter.
    pub color: DVec3,
    /// The k of the falloff, >= 0, per square of a world unit.
    pub falloff: f64,
}

impl Light {
    /// The light of a scene that names none: white at (3, 4, 5) with k = 0.01.
    pub const DEFAULT: Self = Self { position: DVec3::new(3.0, 4.0, 5.0), color: DVec3::ONE, falloff: 0.01 };

    /// The light's colour at a squared distance.
    pub fn color_at(&self, distance_squared: f64) -> DVec3 {
        // Not 0 times infinity for a light beyond the root of the largest number.
        let falloff = if self.falloff == 0.0 { 0.0 } else { self.falloff * distance_squared };
        self.color / (1.0 + falloff)
    }
}
