//! From the world to pixels of the window.

use superegg_geom::glam::{DVec2, DVec3};
use superegg_scene::Camera;

use super::viewport::Viewport;

/// A camera with the part of the window that it fills.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Projection {
    camera: Camera,
    viewport: Viewport,
    axes: (DVec3, DVec3, DVec3),
}

impl Projection {
    pub(crate) fn new(camera: &Camera, viewport: &Viewport) -> Self {
        Self { camera: *camera, viewport: *viewport, axes: camera.frame() }
    }

    /// The camera's axes: right, up, forward.
    pub(crate) fn axes(&self) -> (DVec3, DVec3, DVec3) {
        self.axes
    }

    /// World units per pixel at the distance of a point. `None` behind the camera.
    pub(crate) fn unit_per_pixel(&self, point: DVec3) -> Option<f64> {
        let height = self.viewport.size.y.max(1.0);
        if let Some(ortho) = self.camera.ortho_height {
            return Some(ortho / height);
        }
        let depth = (point - self.camera.position).dot(self.axes.2);
        let half_height = (0.5 * self.camera.fov_deg.to_radians()).tan();
        (depth > 0.0).then_some(2.0 * half_height * depth / height)
    }

    /// The pixel of a point. `None` behind the camera.
    pub(crate) fn pixel(&self, point: DVec3) -> Option<DVec2> {
        let unit = self.unit_per_pixel(point)?;
        let (right, up, _) = self.axes;
        let from_eye = point - self.camera.position;
        let across = DVec2::new(from_eye.dot(right), -from_eye.dot(up)) / unit;
        let pixel = self.viewport.corner + 0.5 * self.viewport.size + across;
        pixel.is_finite().then_some(pixel)
    }

    /// Whether a direction at a point is towards the eye.
    pub(crate) fn faces_eye(&self, point: DVec3, direction: DVec3) -> bool {
        let to_eye =
            if self.camera.ortho_height.is_some() { -self.axes.2 } else { self.camera.position - point };
        direction.dot(to_eye) > 0.0
    }
}

#[cfg(test)]
mod tests {
    use superegg_render::View;

    use super::*;

    #[test]
    fn a_point_is_at_the_pixel_whose_ray_meets_it() {
        let viewport = Viewport { corner: DVec2::new(30.0, 20.0), size: DVec2::new(400.0, 300.0) };
        for ortho_height in [None, Some(7.0)] {
            let camera = Camera { position: DVec3::new(3.0, 4.0, 9.0), ortho_height, ..Camera::default() };
            let projection = Projection::new(&camera, &viewport);
            for pixel in [DVec2::new(31.0, 21.0), DVec2::new(230.0, 170.0), DVec2::new(400.0, 60.0)] {
                let ray = View::new(&camera, 400, 300).ray(pixel - viewport.corner);
                let seen = projection.pixel(ray.origin + 5.0 * ray.direction).unwrap();
                assert!((seen - pixel).length() < 1e-6, "{seen} {pixel}");
            }
            assert_eq!(projection.pixel(camera.position + 9.0 * DVec3::Z).is_none(), ortho_height.is_none());
        }
    }
}
