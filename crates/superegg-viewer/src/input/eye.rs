//! The viewer's eye: the scene's camera after arcball, pan and zoom.

use superegg_geom::Aabb;
use superegg_geom::glam::{DAffine3, DMat3, DQuat, DVec2, DVec3};
use superegg_scene::{Camera, Light};

use super::arcball::Arcball;

/// A change of the scene's camera: the scene seems to rotate about a pivot while the camera zooms
/// and pans.
///
/// ```
/// use superegg_geom::glam::DVec2;
/// use superegg_scene::Camera;
/// use superegg_viewer::Eye;
///
/// let home = Camera::default();
/// let mut eye = Eye::new(&home);
/// eye.magnify(2.0);
/// let distance = |camera: &Camera| (camera.position - camera.target).length();
/// assert_eq!(distance(&eye.camera()), 0.5 * distance(&home));
/// eye.press(DVec2::ZERO);
/// eye.drag(DVec2::new(0.3, 0.1));
/// eye.release();
/// // The camera orbits the pivot, which stays in the middle of the picture.
/// assert!((eye.camera().target - home.target).length() < 1e-12);
/// eye.go_home();
/// assert_eq!(eye.camera(), home);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Eye {
    home: Camera,
    arcball: Arcball,
    /// Centre of rotation, in world units.
    pivot: DVec3,
    /// From the eye to the plane of the pivot, in world units.
    distance: f64,
    /// Shift of the pivot on the screen, right and up, in world units.
    pan: DVec2,
    /// Nothing has been changed: the camera is `home` to the bit.
    is_home: bool,
}

/// Range of the distance from eye to pivot, in world units.
const DISTANCES: std::ops::RangeInclusive<f64> = 1e-150..=1e150;
/// Factor on the distance that leaves a margin around a framed box.
const FRAME_MARGIN: f64 = 1.08;

impl Eye {
    /// The scene's own camera.
    pub fn new(home: &Camera) -> Self {
        Self {
            home: *home,
            arcball: Arcball::default(),
            pivot: home.target,
            distance: (home.position - home.target).length(),
            pan: DVec2::ZERO,
            is_home: true,
        }
    }

    /// The scene's own camera.
    pub fn home(&self) -> &Camera {
        &self.home
    }

    /// Returns to the scene's own camera.
    pub fn go_home(&mut self) {
        *self = Self::new(&self.home);
    }

    /// The arcball, read only.
    pub fn arcball(&self) -> &Arcball {
        &self.arcball
    }

    /// Starts to rotate the scene, at a point in radii of the arcball.
    pub fn press(&mut self, point: DVec2) {
        self.arcball.press(point);
    }

    /// Rotates the scene to a point in radii of the arcball.
    pub fn drag(&mut self, point: DVec2) {
        self.arcball.drag(point);
        self.is_home = false;
    }

    /// Ends the rotation.
    pub fn release(&mut self) {
        self.arcball.release();
    }

    /// Enlarges the scene on the screen by a factor > 0, about the pivot.
    pub fn magnify(&mut self, factor: f64) {
        self.go_to_distance(self.distance / factor);
    }

    fn go_to_distance(&mut self, distance: f64) {
        // Below this distance rounding leaves no direction from eye to pivot.
        let least = DISTANCES.start().max(1e-9 * self.pivot.abs().max_element());
        if !distance.is_nan() {
            self.distance = distance.max(least).min(*DISTANCES.end());
            self.is_home = false;
        }
    }

    /// Moves the scene on the screen by pixels right and down, in a picture of this height in
    /// pixels.
    pub fn move_by(&mut self, pixels: DVec2, height_px: f64) {
        let moved = self.pan + DVec2::new(pixels.x, -pixels.y) * self.unit_per_pixel(height_px);
        if moved.is_finite() {
            self.pan = moved;
            self.is_home = false;
        }
    }

    /// Moves so that the bounding sphere of a box fills a picture of this aspect ratio (width /
    /// height). The rotation stays. An empty or infinite box changes nothing.
    pub fn frame(&mut self, bounds: &Aabb, aspect: f64) {
        let radius = bounds.half_extent().length();
        if bounds.is_empty() || !radius.is_finite() || !bounds.center().is_finite() {
            return;
        }
        self.pivot = bounds.center();
        self.pan = DVec2::ZERO;
        if let Some(height) = self.home.ortho_height {
            let wanted = 2.0 * FRAME_MARGIN * radius / aspect.min(1.0);
            self.go_to_distance(self.home_distance() * wanted / height);
            return;
        }
        let half_height = 0.5 * self.home.fov_deg.to_radians();
        let half_angle = half_height.min((half_height.tan() * aspect).atan());
        self.go_to_distance(FRAME_MARGIN * radius / half_angle.sin());
    }

    fn home_distance(&self) -> f64 {
        (self.home.position - self.home.target).length()
    }

    /// The height of the picture of an orthographic camera: it follows the distance.
    fn ortho_height(&self) -> Option<f64> {
        self.home.ortho_height.map(|height| height * self.distance / self.home_distance())
    }

    /// Turns so that the eye is in this direction from the pivot, with `up` up on the screen. The two
    /// are perpendicular unit vectors.
    pub fn look_from(&mut self, direction: DVec3, up: DVec3) {
        let wanted = DMat3::from_cols(up.cross(direction), up, direction);
        self.arcball.set_rotation(DQuat::from_mat3(&(wanted.transpose() * self.home_axes())));
        self.is_home = false;
    }

    /// World units per pixel at the distance of the pivot.
    pub fn unit_per_pixel(&self, height_px: f64) -> f64 {
        if let Some(height) = self.ortho_height() {
            return height / height_px.max(1.0);
        }
        2.0 * (0.5 * self.home.fov_deg.to_radians()).tan() * self.distance / height_px.max(1.0)
    }

    /// Maps the screen's axes (right, up, towards the eye) at home to the world's.
    fn home_axes(&self) -> DMat3 {
        let (right, up, forward) = self.home.frame();
        DMat3::from_cols(right, up, -forward)
    }

    /// The rotation of the scene about the pivot, in the world's axes.
    pub fn world_rotation(&self) -> DQuat {
        let axes = DQuat::from_mat3(&self.home_axes());
        axes * self.arcball.rotation() * axes.inverse()
    }

    /// The camera that sees the resting scene as the eye sees the rotated one. At home it is the
    /// scene's, to the bit.
    pub fn camera(&self) -> Camera {
        if self.is_home {
            return self.home;
        }
        let axes = self.home_axes() * DMat3::from_quat(self.arcball.rotation().inverse());
        let target = self.pivot - axes.x_axis * self.pan.x - axes.y_axis * self.pan.y;
        Camera {
            position: target + axes.z_axis * self.distance,
            target,
            up: axes.y_axis,
            ortho_height: self.ortho_height(),
            ..self.home
        }
    }

    /// The lights in the resting scene: unchanged if they turn with it, or rotated back about the
    /// pivot if they stay with the eye.
    pub fn lights(&self, lights: &[Light], lights_turn: bool) -> Vec<Light> {
        if lights_turn || self.is_home {
            return lights.to_vec();
        }
        let map = self.light_map();
        lights.iter().map(|light| light.through(&map)).collect()
    }

    /// The map that lights go through if they stay with the eye: the scene's rotation back about the
    /// pivot.
    pub fn light_map(&self) -> DAffine3 {
        let back = self.world_rotation().inverse();
        DAffine3::from_translation(self.pivot)
            * DAffine3::from_quat(back)
            * DAffine3::from_translation(-self.pivot)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use superegg_scene::LightKind;

    use super::*;

    fn vector(size: f64) -> impl Strategy<Value = DVec3> {
        (-size..size, -size..size, -size..size).prop_map(DVec3::from)
    }

    fn camera() -> impl Strategy<Value = Camera> {
        (vector(20.0), vector(20.0), vector(1.0), 5.0..120.0f64)
            .prop_filter("a line of sight", |(position, target, up, _)| {
                (*position - *target).length() > 0.1 && up.length() > 0.1
            })
            .prop_map(|(position, target, up, fov_deg)| Camera {
                position,
                target,
                up,
                fov_deg,
                ..Camera::default()
            })
    }

    fn point() -> impl Strategy<Value = DVec2> {
        (-1.2..1.2f64, -1.2..1.2f64).prop_map(DVec2::from)
    }

    /// A point in the axes of a camera: right, up and forward.
    fn seen(camera: &Camera, point: DVec3) -> DVec3 {
        let (right, up, forward) = camera.frame();
        let to = point - camera.position;
        DVec3::new(to.dot(right), to.dot(up), to.dot(forward))
    }

    #[test]
    fn a_view_from_a_direction_has_the_eye_there() {
        let home = Camera { position: DVec3::new(3.0, -4.0, 5.0), target: DVec3::ONE, ..Camera::default() };
        for (direction, up) in [(DVec3::Z, DVec3::Y), (DVec3::X, DVec3::Y), (DVec3::Y, DVec3::NEG_Z)] {
            let mut eye = Eye::new(&home);
            eye.look_from(direction, up);
            let camera = eye.camera();
            let (_, seen_up, forward) = camera.frame();
            assert!((forward + direction).length() < 1e-9 && (seen_up - up).length() < 1e-9, "{direction}");
            assert!((camera.target - home.target).length() < 1e-9);
        }
    }

    proptest! {
        #[test]
        fn a_drag_there_and_back_sees_the_same(camera in camera(), from in point(), to in point(), point in vector(5.0)) {
            let mut eye = Eye::new(&camera);
            eye.press(from);
            eye.drag(to);
            eye.drag(from);
            eye.release();
            let shift = (seen(&eye.camera(), point) - seen(&camera, point)).length();
            prop_assert!(shift < 1e-10 * (1.0 + camera.position.length()), "{shift}");
        }

        #[test]
        fn the_moved_camera_sees_the_scene_as_the_camera_sees_the_rotated_one(camera in camera(), from in point(), to in point(), point in vector(5.0)) {
            let mut eye = Eye::new(&camera);
            eye.press(from);
            eye.drag(to);
            let rotated = camera.target + eye.world_rotation() * (point - camera.target);
            let shift = (seen(&eye.camera(), point) - seen(&camera, rotated)).length();
            prop_assert!(shift < 1e-9, "{shift}");
        }

        #[test]
        fn lights_that_stay_are_seen_where_they_were(camera in camera(), from in point(), to in point(), position in vector(9.0)) {
            let light = Light { kind: LightKind::Point { position }, ..Light::DEFAULT };
            let mut eye = Eye::new(&camera);
            eye.press(from);
            eye.drag(to);
            let staying = eye.lights(&[light], false)[0].position().unwrap();
            prop_assert!((seen(&eye.camera(), staying) - seen(&camera, position)).length() < 1e-9);
            prop_assert_eq!(eye.lights(&[light], true)[0], light);
        }

        #[test]
        fn larger_and_smaller_undo_each_other(camera in camera(), steps in 1..20i32) {
            let mut eye = Eye::new(&camera);
            (0..steps).for_each(|_| eye.magnify(1.1));
            (0..steps).for_each(|_| eye.magnify(1.0 / 1.1));
            prop_assert!((eye.camera().position - camera.position).length() < 1e-9);
        }

        #[test]
        fn a_pan_moves_the_pivot_by_that_many_pixels(camera in camera(), x in -300.0..300.0f64, y in -300.0..300.0f64, from in point(), to in point()) {
            let mut eye = Eye::new(&camera);
            eye.press(from);
            eye.drag(to);
            eye.move_by(DVec2::new(x, y), 600.0);
            let seen = seen(&eye.camera(), camera.target);
            let pixel = 2.0 * (0.5 * camera.fov_deg.to_radians()).tan() / 600.0;
            let on_screen = DVec2::new(seen.x, -seen.y) / seen.z / pixel;
            prop_assert!((on_screen - DVec2::new(x, y)).length() < 1e-6);
        }

        #[test]
        fn the_frame_holds_the_whole_box(camera in camera(), center in vector(50.0), half in vector(5.0), aspect in 0.3..3.0f64) {
            let bounds = Aabb::around(center, half.abs());
            let mut eye = Eye::new(&camera);
            eye.frame(&bounds, aspect);
            let camera = eye.camera();
            let half_height = (0.5 * camera.fov_deg.to_radians()).tan();
            for corner in 0..8 {
                let pick = |bit: i32| if corner >> bit & 1 == 0 { -1.0 } else { 1.0 };
                let corner = center + half.abs() * DVec3::new(pick(0), pick(1), pick(2));
                let seen = seen(&camera, corner);
                prop_assert!(seen.z > 0.0 && seen.y.abs() <= half_height * seen.z && seen.x.abs() <= aspect * half_height * seen.z);
            }
        }
    }

    #[test]
    fn home_is_the_scenes_camera_to_the_bit() {
        let camera = Camera { position: DVec3::new(0.1, 0.2, 7.3), ..Camera::default() };
        let mut eye = Eye::new(&camera);
        eye.magnify(3.0);
        assert_ne!(eye.camera(), camera);
        eye.go_home();
        assert_eq!(eye.camera(), camera);
    }

    #[test]
    fn hostile_moves_keep_it_finite() {
        let mut eye = Eye::new(&Camera::default());
        eye.magnify(0.0);
        eye.magnify(f64::NAN);
        eye.move_by(DVec2::new(f64::INFINITY, f64::NAN), 0.0);
        eye.frame(&Aabb::EMPTY, 1.0);
        eye.frame(&Aabb::around(DVec3::INFINITY, DVec3::ONE), 1.0);
        eye.frame(&Aabb::around(DVec3::ZERO, DVec3::ZERO), 0.0);
        let camera = eye.camera();
        assert!(camera.position.is_finite() && camera.position != camera.target);
    }
}
