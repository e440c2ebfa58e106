//! The bounding box of the shape under an affine map.

use crate::math::aabb::Aabb;
use crate::math::transform::Transform;
use crate::superquadric::Superquadric;

impl Superquadric {
    /// The smallest axis-aligned box around the shape's image under an affine map, for every pair
    /// of exponents:
    ///
    /// ```text
    /// center = translation,   half edge along i = h(radii * row i of the linear part)
    /// ```
    ///
    /// with the support function h ([`crate::NormForm::support`]). The faces are right to a few
    /// ulps of their coordinates; [`Aabb::rounded_outward`] makes the box a strict bound.
    ///
    /// ```
    /// use superegg_geom::{Superquadric, Transform, TransformStep, glam::DVec3};
    /// let steps = [
    ///     TransformStep::Rotate { axis: DVec3::Z, angle_deg: 30.0 },
    ///     TransformStep::Translate(DVec3::new(5.0, 0.0, 0.0)),
    /// ];
    /// let bounds = Superquadric::unit_sphere().bounds_under(&Transform::from_steps(&steps)?);
    /// assert!((bounds.min - DVec3::new(4.0, -1.0, -1.0)).length() < 1e-15);
    /// # Ok::<(), superegg_geom::TransformError>(())
    /// ```
    pub fn bounds_under(&self, transform: &Transform) -> Aabb {
        let map = transform.forward();
        Aabb::around(map.translation, self.half_extent_under(&map.matrix3))
    }
}
