//! The sides that a scene is seen from.

use superegg_geom::glam::DVec3;
use superegg_geom::unit_vector;

/// The side that the scene is seen from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ViewSide {
    /// The front.
    Front,
    /// The back.
    Back,
    /// The right.
    Right,
    /// The left.
    Left,
    /// The top.
    Top,
    /// The bottom.
    Bottom,
}

impl ViewSide {
    /// The direction of the eye and the one that is up on the screen, in a scene with this direction
    /// up. The front is towards +z, or towards -y if z is up.
    pub fn directions(self, up: DVec3) -> (DVec3, DVec3) {
        let up = unit_vector(up).unwrap_or(DVec3::Y);
        let towards = if up.z.abs() > 0.9 { DVec3::NEG_Y } else { DVec3::Z };
        let front = unit_vector(towards - towards.dot(up) * up).unwrap_or(DVec3::X);
        let right = up.cross(front);
        match self {
            Self::Front => (front, up),
            Self::Back => (-front, up),
            Self::Right => (right, up),
            Self::Left => (-right, up),
            Self::Top => (up, -front),
            Self::Bottom => (-up, front),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sides_of_a_view_are_right_handed() {
        for up in [DVec3::Y, DVec3::Z, DVec3::X, DVec3::new(0.1, 1.0, 0.2)] {
            for side in [ViewSide::Front, ViewSide::Back, ViewSide::Left, ViewSide::Right, ViewSide::Top] {
                let (direction, screen_up) = side.directions(up);
                assert!(direction.is_normalized() && direction.dot(screen_up).abs() < 1e-12, "{up} {side:?}");
            }
        }
        assert_eq!(ViewSide::Front.directions(DVec3::Y), (DVec3::Z, DVec3::Y));
        assert_eq!(ViewSide::Right.directions(DVec3::Y), (DVec3::X, DVec3::Y));
        assert_eq!(ViewSide::Right.directions(DVec3::Z), (DVec3::X, DVec3::Z));
    }
}
