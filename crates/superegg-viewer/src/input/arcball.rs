//! Shoemake's arcball: a drag across a ball is a rotation.

use superegg_geom::glam::{DQuat, DVec2, DVec3};

/// A rotation changed by drags (Shoemake, "ARCBALL", Graphics Interface 1992).
///
/// A point of the screen, in radii of the ball with x to the right and y up, maps to a point of the
/// unit sphere. A drag from point a to point b rotates by the quaternion `b a*` = (a . b, a x b):
/// about their common normal by twice the angle between them. Hence a drag depends on its ends
/// alone, dragging back restores the rotation to the bit, and a closed polygon of drags is no
/// rotation.
///
/// ```
/// use superegg_geom::glam::{DQuat, DVec2, DVec3};
/// use superegg_viewer::Arcball;
///
/// let mut ball = Arcball::default();
/// ball.press(DVec2::ZERO);
/// ball.drag(DVec2::new(0.5, 0.0));
/// // The point that faced the eye follows the pointer to the right.
/// assert!((ball.rotation() * DVec3::Z).x > 0.0);
/// // Back at the start nothing has turned.
/// ball.drag(DVec2::ZERO);
/// ball.release();
/// assert_eq!(ball.rotation(), DQuat::IDENTITY);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Arcball {
    rotation: DQuat,
    drag: Option<Drag>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Drag {
    from: DVec3,
    /// The rotation at the start of the drag.
    before: DQuat,
}

impl Default for Arcball {
    fn default() -> Self {
        Self { rotation: DQuat::IDENTITY, drag: None }
    }
}

impl Arcball {
    /// The rotation: a unit quaternion in the axes of the screen, x right, y up, z towards the eye.
    pub fn rotation(&self) -> DQuat {
        self.rotation
    }

    /// Takes this rotation and ends a drag.
    pub fn set_rotation(&mut self, rotation: DQuat) {
        *self = Self { rotation: rotation.normalize(), drag: None };
    }

    /// Whether a drag is in progress.
    pub fn is_dragged(&self) -> bool {
        self.drag.is_some()
    }

    /// Starts a drag at a point in radii of the ball.
    pub fn press(&mut self, point: DVec2) {
        self.drag = Some(Drag { from: on_ball(point), before: self.rotation });
    }

    /// Moves the end of the drag. Without a drag it does nothing.
    pub fn drag(&mut self, point: DVec2) {
        let Some(Drag { from, before }) = self.drag else { return };
        let to = on_ball(point);
        let axis = from.cross(to);
        let turn = DQuat::from_xyzw(axis.x, axis.y, axis.z, from.dot(to));
        // At the start point the axis is exactly zero, and the rotation must be exact too.
        self.rotation = if axis == DVec3::ZERO { before } else { (turn * before).normalize() };
    }

    /// Ends the drag.
    pub fn release(&mut self) {
        self.drag = None;
    }
}

/// The point of the unit sphere in front of a point of the screen, or the nearest one of the rim. A
/// point that is not finite counts as the centre.
fn on_ball(point: DVec2) -> DVec3 {
    let point = if point.is_finite() { point } else { DVec2::ZERO };
    let square = point.length_squared();
    if square > 1.0 {
        // In two steps: the square of a far point may be infinite.
        let point = (point / point.abs().max_element()).normalize();
        point.extend(0.0)
    } else {
        point.extend((1.0 - square).sqrt())
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn point() -> impl Strategy<Value = DVec2> {
        let coordinate = prop_oneof![8 => -1.5..1.5f64, 1 => Just(0.0), 1 => Just(-0.0), 1 => Just(1.0), 1 => -1e300..1e300];
        (coordinate.clone(), coordinate).prop_map(DVec2::from)
    }

    fn dragged(ball: &mut Arcball, points: &[DVec2]) {
        ball.press(points[0]);
        points.iter().for_each(|point| ball.drag(*point));
        ball.release();
    }

    /// A point of the screen within the ball and off its rim, where two directions meet.
    fn inner() -> impl Strategy<Value = DVec2> {
        (-0.7..0.7f64, -0.7..0.7f64).prop_map(DVec2::from)
    }

    proptest! {
        #[test]
        fn there_and_back_is_the_identity_to_the_bit(before in prop::collection::vec(point(), 1..4), path in prop::collection::vec(point(), 1..6)) {
            let mut ball = Arcball::default();
            dragged(&mut ball, &before);
            let rotation = ball.rotation();
            let there_and_back: Vec<DVec2> = path.iter().chain([&path[0]]).copied().collect();
            dragged(&mut ball, &there_and_back);
            prop_assert_eq!(ball.rotation(), rotation);
        }

        #[test]
        fn a_drag_depends_on_its_ends_alone(path in prop::collection::vec(point(), 2..6)) {
            let (mut whole, mut short) = (Arcball::default(), Arcball::default());
            dragged(&mut whole, &path);
            dragged(&mut short, &[path[0], path[path.len() - 1]]);
            prop_assert_eq!(whole, short);
        }

        #[test]
        fn a_closed_triangle_is_no_rotation_of_its_first_point(a in inner(), b in inner(), c in inner()) {
            // Shoemake's arcs add: a to b and b to c is a to c, up to a rotation about the end
            // point.
            let mut ball = Arcball::default();
            dragged(&mut ball, &[a, b]);
            dragged(&mut ball, &[b, a]);
            prop_assert!(ball.rotation().angle_between(DQuat::IDENTITY) < 1e-7);
            dragged(&mut ball, &[a, c]);
            dragged(&mut ball, &[c, a]);
            prop_assert!(ball.rotation().angle_between(DQuat::IDENTITY) < 1e-7);
        }

        #[test]
        fn a_drag_through_the_centre_rotates_by_twice_the_arc(radius in 0.0..1.0f64, angle in -3.1..3.1f64) {
            let direction = DVec2::from_angle(angle);
            let mut ball = Arcball::default();
            dragged(&mut ball, &[-radius * direction, radius * direction]);
            // Each side of the centre is an arc of asin(radius); the rotation is twice their sum.
            let expected = 4.0 * radius.asin();
            let axis = DVec3::new(-direction.y, direction.x, 0.0);
            let turned = DQuat::from_axis_angle(axis, expected);
            prop_assert!(ball.rotation().dot(turned).abs() > 1.0 - 1e-12, "{:?} {turned:?}", ball.rotation());
        }

        #[test]
        fn it_stays_a_rotation(paths in prop::collection::vec(prop::collection::vec(point(), 1..4), 0..8)) {
            let mut ball = Arcball::default();
            paths.iter().for_each(|path| dragged(&mut ball, path));
            prop_assert!((ball.rotation().length() - 1.0).abs() < 1e-9);
        }
    }

    #[test]
    fn the_front_follows_the_pointer() {
        let mut ball = Arcball::default();
        dragged(&mut ball, &[DVec2::ZERO, DVec2::new(0.1, 0.0)]);
        let front = ball.rotation() * DVec3::Z;
        assert!(front.x > 0.0 && front.y.abs() < 1e-12, "{front}");
    }

    #[test]
    fn points_that_are_not_finite_are_harmless() {
        let mut ball = Arcball::default();
        dragged(&mut ball, &[DVec2::NAN, DVec2::INFINITY, DVec2::new(f64::NEG_INFINITY, 0.0)]);
        assert!(ball.rotation().is_finite());
    }
}
