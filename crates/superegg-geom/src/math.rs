//! Rays, boxes, affine maps and careful arithmetic: what knows no superquadric.

pub(crate) mod aabb;
pub(crate) mod eigen;
pub(crate) mod numeric;
pub(crate) mod random;
pub(crate) mod ray;
pub(crate) mod transform;
