//! Rays.

use glam::{DAffine3, DVec3};

use crate::math::transform::{Transform, error_through};

/// The half line `origin + t direction`, t >= 0. The direction need not be of unit length; every
/// `t` of this crate counts in its length, so that a ray keeps its `t` through any affine map.
///
/// ```
/// use superegg_geom::{Ray, Transform, TransformStep, glam::DVec3};
/// let ray = Ray::new(DVec3::ZERO, DVec3::new(2.0, 0.0, 0.0));
/// assert_eq!(ray.point_at(1.5), DVec3::new(3.0, 0.0, 0.0));
/// let doubled = Transform::from_steps(&[TransformStep::Scale(DVec3::splat(2.0))])?;
/// assert_eq!(ray.to_local(&doubled).point_at(1.5), DVec3::new(1.5, 0.0, 0.0));
/// # Ok::<(), superegg_geom::TransformError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Where the ray starts.
    pub origin: DVec3,
    /// Where it goes; any length but zero.
    pub direction: DVec3,
    /// A bound on the rounding error of each coordinate of `origin`, in the units of the ray's
    /// space: 0 for a ray from user input, a few ulps for one that starts at a computed point of a
    /// surface. It is used for one thing: a start that lies within it of *another* surface counts
    /// as on that surface, so that two coincident surfaces do not shadow each other.
    pub origin_error: f64,
}

impl Ray {
    /// A ray from an exact origin.
    pub fn new(origin: DVec3, direction: DVec3) -> Self {
        Self { origin, direction, origin_error: 0.0 }
    }

    /// The point `origin + t direction`.
    pub fn point_at(&self, t: f64) -> DVec3 {
        self.origin + t * self.direction
    }

    /// The same ray in the local space of `world_from_local`: the same `t` means the same point.
    pub fn to_local(&self, world_from_local: &Transform) -> Self {
        self.through(world_from_local.inverse())
    }

    /// The same ray in the space that a map leads to: the same `t` means the same point.
    #[inline]
    pub fn through(&self, map: &DAffine3) -> Self {
        Self {
            origin: map.transform_point3(self.origin),
            direction: map.transform_vector3(self.direction),
            origin_error: if self.origin_error > 0.0 {
                error_through(map, self.origin, self.origin_error)
            } else {
                0.0
            },
        }
    }
}

/// The position of a ray's start relative to one shape.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RayStart {
    /// Unknown: the coordinates of the origin decide.
    Free,
    /// The origin is on the shape's surface and the ray leaves to the outside. It does not hit a
    /// convex shape again.
    SurfaceOutward,
    /// The origin is on the shape's surface and the ray goes into the shape: its first crossing is
    /// an exit.
    SurfaceInward,
}
