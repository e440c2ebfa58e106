//! The part of the window that shows the scene.

use superegg_geom::glam::DVec2;

/// A rectangle in pixels of the window.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Viewport {
    /// Its top left corner.
    pub corner: DVec2,
    /// Its width and height, at least 1.
    pub size: DVec2,
}

impl Viewport {
    /// Converts a point of the window to radii of the arcball. The ball fills the shorter side.
    pub(super) fn on_ball(&self, point: DVec2) -> DVec2 {
        let from_middle = point - self.corner - 0.5 * self.size;
        from_middle * DVec2::new(1.0, -1.0) / (0.5 * self.size.min_element())
    }

    /// Aspect ratio: width / height.
    pub fn aspect(&self) -> f64 {
        self.size.x / self.size.y
    }
}
