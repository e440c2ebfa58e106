//! From places in the picture to rays.

use superegg_geom::Ray;
use superegg_geom::glam::{DVec2, DVec3};
use superegg_scene::Camera;

use crate::footprint::Footprint;

/// A camera with a picture size: the map from film coordinates to rays.
#[derive(Clone, Copy, Debug)]
pub struct View {
    position: DVec3,
    /// The direction to the top left corner, and the steps of one pixel right and down.
    to_corner: DVec3,
    pixel_right: DVec3,
    pixel_down: DVec3,
}

impl View {
    /// The view of a camera on a picture of `width` by `height` pixels, which are square.
    pub fn new(camera: &Camera, width: u32, height: u32) -> Self {
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

    /// The width of a ray that stands for one of some samples of a pixel.
    pub fn footprint(&self, samples: u32) -> Footprint {
        let pixel = self.pixel_right.length();
        Footprint { width: 0.0, spread: pixel / f64::from(samples.max(1)).sqrt() }
    }

    /// The ray through a place on the film, in pixels from the top left corner: the centre of the first pixel is (0.5, 0.5). Its direction
    /// has a length of at least 1.
    pub fn ray(&self, film_px: DVec2) -> Ray {
        Ray::new(self.position, self.to_corner + film_px.x * self.pixel_right + film_px.y * self.pixel_down)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn corners_and_centre_of_the_default_camera() {
        let view = View::new(&Camera::default(), 200, 100);
        let half_height = 30f64.to_radians().tan();
        let close = |film: (f64, f64), expected: DVec3| {
            let ray = view.ray(film.into());
            assert!((ray.direction - expected).length() < 1e-12, "{film:?}: {:?}", ray.direction);
        };
        close((100.0, 50.0), DVec3::NEG_Z);
        close((0.0, 0.0), DVec3::new(-2.0 * half_height, half_height, -1.0));
        close((200.0, 100.0), DVec3::new(2.0 * half_height, -half_height, -1.0));
    }
}
