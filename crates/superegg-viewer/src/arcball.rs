//! Shoemake's arcball: a drag over a ball as a turn.

use superegg_geom::glam::{DQuat, DVec2, DVec3};

/// A turn that drags change (Shoemake, "ARCBALL", Graphics Interface 1992).
///
/// A place on the screen, in radii of the ball with x to the right and y up, is taken for a point of the unit sphere. A drag from point a
/// to point b turns by the quaternion `b a*` = (a . b, a x b): about their common normal by twice the angle between them. So a
/// drag depends on its ends alone, going back undoes it to the bit, and a closed polygon of drags is no turn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Arcball {
    turn: DQuat,
    drag: Option<Drag>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Drag {
    from: DVec3,
    /// The turn when the drag began.
    before: DQuat,
}

impl Default for Arcball {
    fn default() -> Self {
        Self { turn: DQuat::IDENTITY, drag: None }
    }
}

impl Arcball {
    /// The turn so far: takes what is seen unturned to what is seen. A unit quaternion in the axes of the screen, z towards the eye.
    pub fn turn(&self) -> DQuat {
        self.turn
    }

    /// Whether a drag is going on.
    pub fn is_dragged(&self) -> bool {
        self.drag.is_some()
    }

    /// Begins a drag at a place in radii of the ball.
    pub fn press(&mut self, place: DVec2) {
        self.drag = Some(Drag { from: on_ball(place), before: self.turn });
    }

    /// Goes on with a drag, if there is one.
    pub fn drag(&mut self, place: DVec2) {
        let Some(Drag { from, before }) = self.drag else { return };
        let to = on_ball(place);
        let axis = from.cross(to);
        let turn = DQuat::from_xyzw(axis.x, axis.y, axis.z, from.dot(to));
        // Back at the start the axis is exactly zero; then nothing is left to rounding.
        self.turn = if axis == DVec3::ZERO { before } else { (turn * before).normalize() };
    }

    /// Ends a drag.
    pub fn release(&mut self) {
        self.drag = None;
    }
}

/// The point of the unit sphere that a place shows: the one in front, or beyond the rim the nearest on it. A place that is not finite is the
/// middle.
fn on_ball(place: DVec2) -> DVec3 {
    let place = if place.is_finite() { place } else { DVec2::ZERO };
    let square = place.length_squared();
    if square > 1.0 {
        // In two steps, since the square of a far place may be infinite.
        let place = (place / place.abs().max_element()).normalize();
        place.extend(0.0)
    } else {
        place.extend((1.0 - square).sqrt())
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn place() -> impl Strategy<Value = DVec2> {
        let coordinate = prop_oneof![8 => -1.5..1.5f64, 1 => Just(0.0), 1 => Just(-0.0), 1 => Just(1.0), 1 => -1e300..1e300];
        (coordinate.clone(), coordinate).prop_map(DVec2::from)
    }

    fn dragged(ball: &mut Arcball, places: &[DVec2]) {
        ball.press(places[0]);
        places.iter().for_each(|place| ball.drag(*place));
        ball.release();
    }

    /// A point of the screen's plane within the ball: none on the rim, where two directions meet.
    fn inner() -> impl Strategy<Value = DVec2> {
        (-0.7..0.7f64, -0.7..0.7f64).prop_map(DVec2::from)
    }

    proptest! {
        #[test]
        fn there_and_back_is_the_identity_to_the_bit(before in prop::collection::vec(place(), 1..4), way in prop::collection::vec(place(), 1..6)) {
            let mut ball = Arcball::default();
            dragged(&mut ball, &before);
            let turn = ball.turn();
            let there_and_back: Vec<DVec2> = way.iter().chain([&way[0]]).copied().collect();
            dragged(&mut ball, &there_and_back);
            prop_assert_eq!(ball.turn(), turn);
        }

        #[test]
        fn a_drag_depends_on_its_ends_alone(way in prop::collection::vec(place(), 2..6)) {
            let (mut whole, mut short) = (Arcball::default(), Arcball::default());
            dragged(&mut whole, &way);
            dragged(&mut short, &[way[0], way[way.len() - 1]]);
            prop_assert_eq!(whole, short);
        }

        #[test]
        fn a_closed_triangle_is_no_turn_of_the_point_it_began_at(a in inner(), b in inner(), c in inner()) {
            // Shoemake's arcs add: a to b and b to c is a to c, up to a turn about where it ends.
            let mut ball = Arcball::default();
            dragged(&mut ball, &[a, b]);
            dragged(&mut ball, &[b, a]);
            prop_assert!(ball.turn().angle_between(DQuat::IDENTITY) < 1e-7);
            dragged(&mut ball, &[a, c]);
            dragged(&mut ball, &[c, a]);
            prop_assert!(ball.turn().angle_between(DQuat::IDENTITY) < 1e-7);
        }

        #[test]
        fn a_drag_through_the_centre_turns_by_twice_the_arc(radius in 0.0..1.0f64, angle in -3.1..3.1f64) {
            let direction = DVec2::from_angle(angle);
            let mut ball = Arcball::default();
            dragged(&mut ball, &[-radius * direction, radius * direction]);
            // Each side of the centre is an arc of asin(radius); the turn is twice their sum.
            let expected = 4.0 * radius.asin();
            let axis = DVec3::new(-direction.y, direction.x, 0.0);
            let turned = DQuat::from_axis_angle(axis, expected);
            prop_assert!(ball.turn().dot(turned).abs() > 1.0 - 1e-12, "{:?} {turned:?}", ball.turn());
        }

        #[test]
        fn it_stays_a_turn(ways in prop::collection::vec(prop::collection::vec(place(), 1..4), 0..8)) {
            let mut ball = Arcball::default();
            ways.iter().for_each(|way| dragged(&mut ball, way));
            prop_assert!((ball.turn().length() - 1.0).abs() < 1e-9);
        }
    }

    #[test]
    fn what_is_in_front_follows_the_pointer() {
        let mut ball = Arcball::default();
        dragged(&mut ball, &[DVec2::ZERO, DVec2::new(0.1, 0.0)]);
        let front = ball.turn() * DVec3::Z;
        assert!(front.x > 0.0 && front.y.abs() < 1e-12, "{front}");
    }

    #[test]
    fn what_is_no_number_is_harmless() {
        let mut ball = Arcball::default();
        dragged(&mut ball, &[DVec2::NAN, DVec2::INFINITY, DVec2::new(f64::NEG_INFINITY, 0.0)]);
        assert!(ball.turn().is_finite());
    }
}
