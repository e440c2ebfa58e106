//! The environment of a scene: sky, floor, ambient occlusion.

use std::sync::Arc;

use superegg_geom::glam::DVec3;
use superegg_geom::unit_vector;

/// The colour of rays that hit nothing: a gradient from the horizon to the zenith.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sky {
    /// The linear colour at the horizon and below it, each channel >= 0.
    pub horizon: DVec3,
    /// The linear colour at the zenith, each channel >= 0.
    pub zenith: DVec3,
    /// The direction of the zenith; not zero, of any length.
    pub up: DVec3,
}

impl Sky {
    /// The colour in a unit direction: linear in the sine of the elevation.
    pub fn color(&self, direction: DVec3) -> DVec3 {
        self.color_at(direction.dot(self.unit_up()))
    }

    /// The colour at the sine of an elevation.
    pub fn color_at(&self, sine: f64) -> DVec3 {
        self.horizon.lerp(self.zenith, sine.clamp(0.0, 1.0))
    }

    /// The unit direction of the zenith.
    pub fn unit_up(&self) -> DVec3 {
        unit_vector(self.up).unwrap_or(DVec3::Y)
    }
}

/// Light from far away in all directions. It replaces sky and background, and lights surfaces by
/// [`LightModel::Path`](crate::LightModel).
#[derive(Clone, Debug, PartialEq)]
pub enum EnvironmentLight {
    /// Sun and sky.
    Daylight(Daylight),
    /// A picture of the surroundings.
    Picture(EnvironmentPicture),
}

/// Sun and sky, by the formulas of Preetham et al. (1999).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Daylight {
    /// The angle of the sun above the horizon in degrees, 0 to 90.
    pub elevation_deg: f64,
    /// How hazy the air is, 1.7 to 10: 2 is clear, 6 hazy.
    pub turbidity: f64,
    /// The angle of the sun to the right of the direction -z (where y is up), in degrees.
    pub azimuth_deg: f64,
}

/// A picture of the surroundings, in a file.
#[derive(Clone, Debug, PartialEq)]
pub struct EnvironmentPicture {
    /// The name of the file, as it was given.
    pub file: Arc<str>,
    /// The angle by which it is turned to the right around the up direction, in degrees.
    pub rotation_deg: f64,
    /// The factor of its values, >= 0.
    pub scale: f64,
}

/// An infinite two-sided plane.
#[derive(Clone, Debug, PartialEq)]
pub struct Floor {
    /// The height above the origin along `up`, in world units.
    pub height: f64,
    /// The normal; not zero, of any length.
    pub up: DVec3,
    /// The primitive whose material the floor has; the default material if `None` or unknown.
    pub surface: Option<Arc<str>>,
}

impl Floor {
    /// A right-handed orthonormal frame: two axes in the floor, then its normal. For a normal of y
    /// it is (z, x, y).
    pub fn axes(&self) -> [DVec3; 3] {
        let up = unit_vector(self.up).unwrap_or(DVec3::Y);
        // The axis after the largest component of up, so that y gives z.
        let towards = match up.abs().max_position() {
            0 => DVec3::Y,
            1 => DVec3::Z,
            _ => DVec3::X,
        };
        let first = unit_vector(towards - towards.dot(up) * up).unwrap_or(DVec3::X);
        [first, up.cross(first), up]
    }
}

/// Ambient occlusion: ambient light is scaled by the fraction of hemisphere rays that are free up
/// to a distance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AmbientOcclusion {
    /// Rays for each visible point, at least 1.
    pub samples: u32,
    /// The length of the rays in world units, above 0: surfaces farther away do not occlude.
    pub distance: f64,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sky_goes_over_from_horizon_to_zenith() {
        let sky = Sky { horizon: DVec3::X, zenith: DVec3::Y, up: DVec3::Z * 3.0 };
        assert_eq!(
            [sky.color(DVec3::Z), sky.color(DVec3::X), sky.color(DVec3::NEG_Z)],
            [DVec3::Y, DVec3::X, DVec3::X]
        );
        assert!(
            (sky.color(DVec3::new(0.0, 0.75f64.sqrt(), 0.5)) - DVec3::new(0.5, 0.5, 0.0)).length() < 1e-12
        );
    }

    #[test]
    fn the_axes_of_a_floor_are_right_handed() {
        for up in [DVec3::Y, DVec3::Z, DVec3::NEG_X, DVec3::new(1.0, 1.0, 1.0), DVec3::new(-1e-9, 3.0, 1e300)]
        {
            let [a, b, c] = Floor { height: 0.0, up, surface: None }.axes();
            assert!((a.cross(b) - c).length() < 1e-12 && a.is_normalized() && b.is_normalized(), "{up}");
        }
        assert_eq!(Floor { height: 0.0, up: DVec3::Y, surface: None }.axes(), [DVec3::Z, DVec3::X, DVec3::Y]);
    }
}
