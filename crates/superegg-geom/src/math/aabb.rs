//! Axis-aligned boxes.

use glam::{DMat3, DVec3};

use crate::math::ray::Ray;
use crate::math::transform::Transform;

/// The box `min..=max`. Empty where `min > max` in some coordinate.
///
/// ```
/// use superegg_geom::{Aabb, Ray, glam::DVec3};
/// let unit = Aabb::around(DVec3::ZERO, DVec3::ONE);
/// assert!(unit.contains(DVec3::ONE) && Aabb::EMPTY.union(&unit) == unit);
/// let ray = Ray::new(DVec3::new(-3.0, 0.0, 0.0), DVec3::X);
/// assert_eq!(unit.clip(&(&ray).into(), f64::INFINITY), Some(2.0));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aabb {
    /// The corner with the smallest coordinates.
    pub min: DVec3,
    /// The corner with the largest coordinates.
    pub max: DVec3,
}

impl Aabb {
    /// The box that holds nothing: the neutral element of [`Aabb::union`].
    pub const EMPTY: Self = Self { min: DVec3::INFINITY, max: DVec3::NEG_INFINITY };

    /// The box `center - half_extent ..= center + half_extent`.
    #[inline]
    pub fn around(center: DVec3, half_extent: DVec3) -> Self {
        Self { min: center - half_extent, max: center + half_extent }
    }

    /// Whether the box holds no point.
    pub fn is_empty(&self) -> bool {
        !self.min.cmple(self.max).all()
    }

    /// Whether the point lies in the box, its faces included.
    pub fn contains(&self, point: DVec3) -> bool {
        self.min.cmple(point).all() && point.cmple(self.max).all()
    }

    /// Whether the two have a point in common, their faces included.
    pub fn intersects(&self, other: &Self) -> bool {
        self.min.cmple(other.max).all() && other.min.cmple(self.max).all()
    }

    /// The smallest box that holds both.
    #[must_use]
    #[inline]
    pub fn union(&self, other: &Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// The middle of the box.
    pub fn center(&self) -> DVec3 {
        0.5 * self.min + 0.5 * self.max
    }

    /// Half of the box's edges.
    pub fn half_extent(&self) -> DVec3 {
        0.5 * self.max - 0.5 * self.min
    }

    /// Half of its surface area; 0 for an empty box.
    pub fn half_area(&self) -> f64 {
        let edges = (self.max - self.min).max(DVec3::ZERO);
        edges.x * edges.y + edges.y * edges.z + edges.z * edges.x
    }

    /// The box around the image of this one. It grows where the map turns the box.
    #[must_use]
    pub fn transformed(&self, transform: &Transform) -> Self {
        if self.is_empty() {
            return Self::EMPTY;
        }
        let linear = transform.forward().matrix3;
        let absolute = DMat3::from_cols(linear.x_axis.abs(), linear.y_axis.abs(), linear.z_axis.abs());
        let image =
            Self::around(transform.forward().transform_point3(self.center()), absolute * self.half_extent());
        // Beyond the range of f64 nothing is known, and a box must hold what it bounds.
        let known = |x: f64, otherwise: f64| if x.is_nan() { otherwise } else { x };
        Self {
            min: image.min.map(|x| known(x, f64::NEG_INFINITY)),
            max: image.max.map(|x| known(x, f64::INFINITY)),
        }
    }

    /// The box grown by the rounding error that may have gone into it, so that a bound stays a
    /// bound.
    #[must_use]
    pub fn rounded_outward(&self) -> Self {
        let slack = 16.0 * f64::EPSILON * self.min.abs().max(self.max.abs());
        Self { min: self.min - slack, max: self.max + slack }
    }

    /// The part `t_in..=t_out` of `0..=t_max` for which the ray is in the box, or `None`.
    /// Conservative: rounding never turns a meeting into a miss (Ize 2013).
    pub fn clip(&self, ray: &RayReciprocal, t_max: f64) -> Option<f64> {
        let to_min = (self.min - ray.origin) * ray.inverse_direction;
        let to_max = (self.max - ray.origin) * ray.inverse_direction;
        let slab = |a: f64, b: f64| {
            // The sum is NaN for a ray within the planes of the slab, or in one of them: no bound
            // from this axis.
            if (a + b).is_nan() { (f64::NEG_INFINITY, f64::INFINITY) } else { (a.min(b), a.max(b)) }
        };
        let (near_x, far_x) = slab(to_min.x, to_max.x);
        let (near_y, far_y) = slab(to_min.y, to_max.y);
        let (near_z, far_z) = slab(to_min.z, to_max.z);
        let near = near_x.max(near_y).max(near_z).max(0.0);
        let far = far_x.min(far_y).min(far_z);
        let far = (far * (1.0 + 8.0 * f64::EPSILON)).min(t_max);
        (near <= far).then_some(near)
    }
}

/// A ray with the reciprocals that box tests divide by.
#[derive(Clone, Copy, Debug)]
pub struct RayReciprocal {
    origin: DVec3,
    inverse_direction: DVec3,
}

impl From<&Ray> for RayReciprocal {
    fn from(ray: &Ray) -> Self {
        Self { origin: ray.origin, inverse_direction: ray.direction.recip() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn empty_is_neutral_and_holds_nothing() {
        let unit = Aabb::around(DVec3::ZERO, DVec3::ONE);
        assert_eq!(Aabb::EMPTY.union(&unit), unit);
        assert!(Aabb::EMPTY.is_empty() && !Aabb::EMPTY.contains(DVec3::ZERO));
    }

    #[test]
    fn clip_meets_a_face_from_within_its_plane() {
        let unit = Aabb::around(DVec3::ZERO, DVec3::ONE);
        let hit =
            |o: [f64; 3], d: [f64; 3]| unit.clip(&(&Ray::new(o.into(), d.into())).into(), f64::INFINITY);
        assert_eq!(hit([-3.0, 0.0, 0.0], [1.0, 0.0, 0.0]), Some(2.0));
        assert_eq!(hit([-3.0, 1.0, 0.0], [1.0, 0.0, 0.0]), Some(2.0));
        assert_eq!(hit([-3.0, 1.1, 0.0], [1.0, 0.0, 0.0]), None);
        assert_eq!(hit([3.0, 0.0, 0.0], [1.0, 0.0, 0.0]), None);
        assert_eq!(hit([0.0, 0.0, 0.0], [1.0, 0.0, 0.0]), Some(0.0));
    }
}
