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

    /// Whether a point of the window lies in the viewport.
    pub(crate) fn contains(&self, point: DVec2) -> bool {
        let from_corner = point - self.corner;
        from_corner.cmpge(DVec2::ZERO).all() && from_corner.cmplt(self.size).all()
    }

    /// Aspect ratio: width / height.
    pub fn aspect(&self) -> f64 {
        self.size.x / self.size.y
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_of_the_menu_and_the_panel_are_outside() {
        let viewport = Viewport { corner: DVec2::new(0.0, 24.0), size: DVec2::new(700.0, 600.0) };
        let contains = |x: f64, y: f64| viewport.contains(DVec2::new(x, y));
        assert!(contains(0.0, 24.0) && contains(350.0, 300.0) && contains(699.0, 623.0));
        assert!(!contains(350.0, 23.0) && !contains(700.0, 300.0) && !contains(350.0, 624.0));
    }
}
