//! The intersection of rays with the floor.

use superegg_geom::Ray;
use superegg_geom::glam::DVec3;
use superegg_scene::{Floor, Material};

/// An infinite plane.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FloorPlane<'a> {
    axes: [DVec3; 3],
    height: f64,
    pub(crate) material: &'a Material,
}

impl<'a> FloorPlane<'a> {
    pub(crate) fn new(floor: &Floor, material: &'a Material) -> Self {
        Self { axes: floor.axes(), height: floor.height, material }
    }

    /// The upward unit normal.
    pub(crate) fn up(&self) -> DVec3 {
        self.axes[2]
    }

    /// The height of a point above the plane.
    pub(crate) fn height_of(&self, point: DVec3) -> f64 {
        point.dot(self.up()) - self.height
    }

    /// The t > 0 of the hit of a ray that does not start on the plane.
    pub(crate) fn intersect(&self, ray: &Ray) -> Option<f64> {
        let above = self.height_of(ray.origin);
        let t = -above / ray.direction.dot(self.up());
        (t > 0.0 && t.is_finite()).then_some(t)
    }

    /// The projection of a nearby point onto the plane, and a bound on the rounding error of each
    /// coordinate.
    pub(crate) fn project(&self, point: DVec3) -> (DVec3, f64) {
        let point = point - self.height_of(point) * self.up();
        (point, 8.0 * f64::EPSILON * (point.abs().max_element() + self.height.abs()))
    }

    /// The coordinates in the plane, relative to its point nearest to the world's origin. The third
    /// is 0.
    pub(crate) fn local(&self, point: DVec3) -> DVec3 {
        DVec3::new(point.dot(self.axes[0]), point.dot(self.axes[1]), 0.0)
    }

    /// The axes of the local coordinates. The third is the normal.
    pub(crate) fn axes(&self) -> [DVec3; 3] {
        self.axes
    }
}
