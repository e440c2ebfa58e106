//! The camera of a scene.

use superegg_geom::glam::{DQuat, DVec3};
use superegg_geom::unit_vector;

/// A thin lens for depth of field: points off the focus distance blur into discs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lens {
    /// The lens radius in world units, above 0.
    pub radius: f64,
    /// The focus distance along the line of sight, in world units, above 0.
    pub focus: f64,
}

/// A camera. The default is a pinhole at (0, 0, 10) that looks along -z, with +y up and a vertical
/// field of view of 60 degrees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// The position, in world units.
    pub position: DVec3,
    /// The point in the centre of the image; differs from `position`.
    pub target: DVec3,
    /// The direction that is up in the image; not zero. It need not be perpendicular to the line of
    /// sight.
    pub up: DVec3,
    /// The vertical field of view, in degrees, in (0, 180).
    pub fov_deg: f64,
    /// The image height in world units of an orthographic camera, which ignores the field of view;
    /// `None` for a perspective camera.
    pub ortho_height: Option<f64>,
    /// The lens; `None` for a pinhole.
    pub lens: Option<Lens>,
}

impl Camera {
    /// The default field of view, in degrees.
    pub const DEFAULT_FOV_DEG: f64 = 60.0;

    /// The orthonormal frame (right, up, forward) of the camera, with right = forward x up.
    ///
    /// If `up` is parallel to the line of sight, it is replaced by the axis with the smallest
    /// component along that line; y is preferred to z, and z to x.
    pub fn frame(&self) -> (DVec3, DVec3, DVec3) {
        let forward = unit(self.target - self.position);
        let up = if self.looks_along_up() {
            let least = forward.abs().min_element();
            let mut axes = [DVec3::Y, DVec3::Z, DVec3::X].into_iter();
            axes.find(|axis| forward.dot(*axis).abs() == least).unwrap_or(DVec3::Y)
        } else {
            unit(self.up)
        };
        let right = forward.cross(up).normalize();
        (right, right.cross(forward), forward)
    }

    /// The camera rotated about its target by an angle in degrees, right-handed about the up
    /// direction of its frame. Angle 0 returns the camera unchanged.
    #[must_use]
    pub fn orbited(&self, angle_deg: f64) -> Self {
        if angle_deg == 0.0 {
            return *self;
        }
        let up = if self.looks_along_up() { self.frame().1 } else { unit(self.up) };
        let turn = DQuat::from_axis_angle(up, angle_deg.to_radians());
        Self { position: self.target + turn * (self.position - self.target), up, ..*self }
    }

    /// Whether `up` is parallel to the line of sight.
    pub fn looks_along_up(&self) -> bool {
        unit(self.target - self.position).cross(unit(self.up)).length() <= 1e-9
    }
}

/// The direction of a vector that is not zero in a valid scene.
fn unit(v: DVec3) -> DVec3 {
    unit_vector(v).unwrap_or(DVec3::Z)
}

impl Default for Camera {
    fn default() -> Self {
        Self {
            position: DVec3::new(0.0, 0.0, 10.0),
            target: DVec3::ZERO,
            up: DVec3::Y,
            fov_deg: Self::DEFAULT_FOV_DEG,
            ortho_height: None,
            lens: None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn default_frame_is_the_axes() {
        assert_eq!(Camera::default().frame(), (DVec3::X, DVec3::Y, DVec3::NEG_Z));
    }

    #[test]
    fn an_orbit_goes_round_the_target_with_the_same_distance() {
        let camera = Camera { target: DVec3::X, up: DVec3::Y * 3.0, ..Camera::default() };
        assert_eq!(camera.orbited(0.0), camera);
        // From +z to +x, right-handed about y.
        let quarter = camera.orbited(90.0);
        let from = camera.position - camera.target;
        assert!((quarter.position - camera.target - DVec3::Y.cross(from)).length() < 1e-12);
        assert!((camera.orbited(360.0).position - camera.position).length() < 1e-12);
        let down = Camera { position: DVec3::Y * 5.0, ..Camera::default() };
        assert!((down.orbited(180.0).position + down.position).length() < 1e-12);
    }

    #[test]
    fn looking_along_up_still_has_a_frame() {
        let down = Camera { position: DVec3::Y * 5.0, ..Camera::default() };
        let (right, up, forward) = down.frame();
        assert_eq!(forward, DVec3::NEG_Y);
        assert!((right.cross(up) + forward).length() < 1e-12);
        let huge = Camera { position: DVec3::X * 1e300, up: DVec3::Y * 1e-300, ..Camera::default() };
        assert_eq!(huge.frame().2, DVec3::NEG_X);
    }
}
