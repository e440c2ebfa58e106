//! A pinhole camera for tests: rays through the pixels of a square or oblong picture.

use superegg_geom::Ray;
use superegg_geom::glam::{DVec2, DVec3};
use superegg_scene::Camera;

use crate::ray::footprint::Footprint;

#[derive(Clone)]
pub(crate) struct TestCamera {
    position: DVec3,
    to_corner: DVec3,
    pixel_right: DVec3,
    pixel_down: DVec3,
}

impl TestCamera {
    pub(crate) fn new(camera: &Camera, width: u32, height: u32) -> Self {
        let (right, up, forward) = camera.frame();
        let (width, height) = (f64::from(width), f64::from(height));
        let pixel = 2.0 * (0.5 * camera.fov_deg.to_radians()).tan() / height;
        Self {
            position: camera.position,
            to_corner: forward + 0.5 * pixel * (height * up - width * right),
            pixel_right: pixel * right,
            pixel_down: -pixel * up,
        }
    }

    pub(crate) fn ray(&self, film_px: DVec2) -> Ray {
        Ray::new(self.position, self.to_corner + film_px.x * self.pixel_right + film_px.y * self.pixel_down)
    }

    /// The width of a ray that stands for one of some samples of a pixel.
    pub(crate) fn footprint(&self, samples: u32) -> Footprint {
        Footprint { width: 0.0, spread: self.pixel_right.length() / f64::from(samples.max(1)).sqrt() }
    }
}
