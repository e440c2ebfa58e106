//! A bar of a round length, to compare sizes in a picture with.

use superegg_scene::Camera;

use super::canvas::{Canvas, Rectangle};
use super::glyphs::text_width;
use super::round::{Label, round_length};

/// The part of the picture's width that the bar is near to.
const PART: f64 = 0.2;

/// A bar as long as a round length at the depth of the camera's target.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct ScaleBar {
    length: Label,
    /// The length in pixels.
    pixels: f64,
}

impl ScaleBar {
    /// The bar for a picture of this size; `None` if a pixel has no length at the target.
    pub(super) fn of(camera: &Camera, [width, height]: [f64; 2]) -> Option<Self> {
        let of_pixel = match camera.ortho_height {
            Some(of_picture) => of_picture / height,
            None => {
                let (_, _, forward) = camera.frame();
                let depth = (camera.target - camera.position).dot(forward);
                2.0 * depth * (0.5 * camera.fov_deg.to_radians()).tan() / height
            }
        };
        let length = round_length(PART * width * of_pixel)?;
        let pixels = length.value / of_pixel;
        Some(Self { length, pixels })
    }

    /// Draws the bar in the lower left corner.
    pub(super) fn draw(&self, canvas: &mut Canvas<'_>) {
        let unit = canvas.unit;
        let (margin, pad, thickness) = (6.0 * unit, 4.0 * unit, 2.0 * unit);
        let text = (text_width(&self.length.text) * unit).round();
        let pixels = self.pixels.round();
        let width = pixels.max(text) + 2.0 * pad;
        let height = canvas.text_height() + thickness + 3.0 * unit + 2.0 * pad;
        let [_, bottom] = canvas.size();
        let top = bottom - margin - height;
        canvas.fill(Rectangle { left: margin, top, width, height }, canvas.paper);
        let middle = margin + 0.5 * width;
        let base = top + pad + canvas.text_height();
        canvas.text((middle - 0.5 * text).round(), base, &self.length.text);
        let left = (middle - 0.5 * pixels).round();
        let bar = Rectangle { left, top: base + 3.0 * unit, width: pixels, height: thickness };
        canvas.fill(bar, canvas.ink);
    }
}

#[cfg(test)]
mod tests {
    use superegg_geom::glam::{DVec2, DVec3};
    use superegg_render::{Development, EncodedPicture, Film, View};
    use superegg_scene::Picture;

    use super::*;

    fn black(width: u32, height: u32) -> EncodedPicture {
        Development::of(&Picture::default()).encode(&Film::new(width, height))
    }

    /// The film position of a point by bisection over rays of the camera.
    fn column_of(view: &View, camera: &Camera, point: DVec3, (width, height): (u32, u32)) -> f64 {
        let (right, _, _) = camera.frame();
        let depth = (point - camera.position).dot(camera.frame().2);
        let (mut low, mut high) = (-f64::from(width), 2.0 * f64::from(width));
        for _ in 0..80 {
            let middle = low.midpoint(high);
            let at = view.ray(DVec2::new(middle, 0.5 * f64::from(height))).point_at(depth);
            if at.dot(right) < point.dot(right) { low = middle } else { high = middle }
        }
        low.midpoint(high)
    }

    #[test]
    fn the_drawn_bar_is_as_long_as_the_camera_projects_its_length() {
        let cameras = [
            Camera::default(),
            Camera {
                position: DVec3::new(3e-6, -4e-6, 2e-6),
                up: DVec3::Z,
                fov_deg: 40.0,
                ..Camera::default()
            },
            Camera { position: DVec3::new(500.0, 20.0, 3.0), target: DVec3::Y, ..Camera::default() },
            Camera { ortho_height: Some(0.37), ..Camera::default() },
        ];
        for camera in cameras {
            for size in [(160, 120), (1280, 960), (300, 900), (3840, 2160)] {
                let mut picture = black(size.0, size.1);
                let bar = ScaleBar::of(&camera, [f64::from(size.0), f64::from(size.1)]).unwrap();
                let mut canvas = Canvas::new(&mut picture, false);
                bar.draw(&mut canvas);
                let unit = canvas.unit as u32;
                // The upper one of the two rows of the bar, counted from below.
                let row = size.1 - (6 + 4 + 1) * unit - 1;
                let drawn = (0..size.0).filter(|x| picture.value(*x, row)[0] > 0.9).count() as f64;
                let view = View::new(&camera, size.0, size.1);
                let (right, _, _) = camera.frame();
                let ends = [-0.5, 0.5].map(|part| camera.target + part * bar.length.value * right);
                let [from, to] = ends.map(|end| column_of(&view, &camera, end, size));
                assert!(
                    (to - from - drawn).abs() <= 0.5 + 1e-6,
                    "{camera:?} {size:?}: {drawn}, {}",
                    to - from
                );
                let part = drawn / f64::from(size.0);
                assert!((0.12..0.33).contains(&part), "{part}");
            }
        }
    }

    #[test]
    fn a_camera_without_a_depth_has_no_bar() {
        let at_target = Camera { position: DVec3::ZERO, ..Camera::default() };
        assert_eq!(ScaleBar::of(&at_target, [640.0, 480.0]), None);
        let tiny = Camera { ortho_height: Some(1e-320), ..Camera::default() };
        let huge = Camera { ortho_height: Some(f64::MAX), ..Camera::default() };
        for camera in [tiny, huge] {
            for side in [1, 2, 50] {
                let Some(bar) = ScaleBar::of(&camera, [f64::from(side); 2]) else { continue };
                bar.draw(&mut Canvas::new(&mut black(side, side), true));
            }
        }
    }
}
