//! What is around the objects of a scene: the sky, the floor, the light that comes from everywhere.

use std::sync::Arc;

use superegg_geom::glam::DVec3;
use superegg_geom::unit_vector;

/// What rays see that meet nothing: one colour, or one that goes over into another from the horizon up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sky {
    /// The linear colour at the horizon and below it, each part >= 0.
    pub horizon: DVec3,
    /// The linear colour straight above, each part >= 0.
    pub zenith: DVec3,
    /// The direction that is above; not zero, of any length.
    pub up: DVec3,
}

impl Sky {
    /// The colour in a unit direction: from the horizon to the zenith in proportion to the sine of the height.
    pub fn color(&self, direction: DVec3) -> DVec3 {
        let up = unit_vector(self.up).unwrap_or(DVec3::Y);
        self.horizon.lerp(self.zenith, direction.dot(up).clamp(0.0, 1.0))
    }
}

/// A plane without end, seen from both sides.
#[derive(Clone, Debug, PartialEq)]
pub struct Floor {
    /// Its height above the origin along `up`, in world units.
    pub height: f64,
    /// The direction at right angles to it; not zero, of any length.
    pub up: DVec3,
    /// The primitive whose surface it has; that of a new primitive where there is none of this name.
    pub surface: Option<Arc<str>>,
}

impl Floor {
    /// Three unit vectors: two along the floor and the one up. For y up they are z, x, y.
    pub fn axes(&self) -> [DVec3; 3] {
        let up = unit_vector(self.up).unwrap_or(DVec3::Y);
        // The axis after the largest part of up, so that y gives z.
        let towards = match up.abs().max_position() {
            0 => DVec3::Y,
            1 => DVec3::Z,
            _ => DVec3::X,
        };
        let first = unit_vector(towards - towards.dot(up) * up).unwrap_or(DVec3::X);
        [first, up.cross(first), up]
    }
}

/// How ambient light is kept from corners: the share of rays to all sides that get so far.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AmbientOcclusion {
    /// Rays for each point that is seen, at least 1.
    pub samples: u32,
    /// What is farther away shades no corner, above 0, in world units.
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
