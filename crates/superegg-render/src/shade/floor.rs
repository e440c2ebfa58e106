//! The floor of a scene as rays meet it.

use superegg_geom::Ray;
use superegg_geom::glam::DVec3;
use superegg_scene::{Floor, Material};

/// A plane without end, ready to be met.
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

    /// The unit normal upwards.
    pub(crate) fn up(&self) -> DVec3 {
        self.axes[2]
    }

    /// Where a ray that does not start on it crosses it, t > 0.
    pub(crate) fn meet(&self, ray: &Ray) -> Option<f64> {
        let above = ray.origin.dot(self.up()) - self.height;
        let t = -above / ray.direction.dot(self.up());
        (t > 0.0 && t.is_finite()).then_some(t)
    }

    /// The point of the plane nearest to a point that is on it but for rounding, and a bound on the rounding of its coordinates.
    pub(crate) fn settle(&self, point: DVec3) -> (DVec3, f64) {
        let point = point - (point.dot(self.up()) - self.height) * self.up();
        (point, 8.0 * f64::EPSILON * (point.abs().max_element() + self.height.abs()))
    }

    /// The coordinates along the plane, from the point nearest to the origin on; the third is 0.
    pub(crate) fn place(&self, point: DVec3) -> DVec3 {
        DVec3::new(point.dot(self.axes[0]), point.dot(self.axes[1]), 0.0)
    }

    /// The directions of those coordinates.
    pub(crate) fn axes(&self) -> [DVec3; 3] {
        self.axes
    }
}
