//! The numbers that make a shape, and the answer of a ray query: what every solver shares.

use glam::DVec3;
use thiserror::Error;

/// The two shape parameters of a superquadric, both finite and 0 or above. 1 and 1 make an
/// ellipsoid, 0 and 0 a box (the limit, exactly), 1 and 0 a cylinder along z, 2 and 2 an octahedron, larger ones a star. The shape is convex for
/// e, n <= 2.
///
/// ```
/// use superegg_geom::{Exponents, ShapeError};
/// let exponents = Exponents::new(1.0, 0.8)?;
/// assert_eq!((exponents.e(), exponents.n()), (1.0, 0.8));
/// assert_eq!(Exponents::new(1.0, f64::NAN), Err(ShapeError::Exponent));
/// # Ok::<(), ShapeError>(())
/// ```
///
/// The fields are private, so exponents that no superquadric has cannot be written:
///
/// ```compile_fail,E0451
/// let invalid = superegg_geom::Exponents { e: -1.0, n: 0.0 };
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Exponents {
    e: f64,
    n: f64,
}

impl Exponents {
    /// e = n = 1: the exponents of a sphere.
    pub const ROUND: Self = Self { e: 1.0, n: 1.0 };

    /// The exponents `e` and `n`.
    ///
    /// # Errors
    /// [`ShapeError::Exponent`] if one of them is negative or not finite.
    pub fn new(e: f64, n: f64) -> Result<Self, ShapeError> {
        let is_exponent = |x: f64| x.is_finite() && x >= 0.0;
        if is_exponent(e) && is_exponent(n) {
            // Adding 0 turns -0 into 0, whose reciprocal is positive.
            Ok(Self { e: e + 0.0, n: n + 0.0 })
        } else {
            Err(ShapeError::Exponent)
        }
    }

    /// East-west (longitude): the shape of the cross-section with the xy plane. >= 0.
    pub fn e(self) -> f64 {
        self.e
    }

    /// North-south (latitude): the shape of the profile towards z. >= 0.
    pub fn n(self) -> f64 {
        self.n
    }

    /// The exponents, neither above 2: those of a convex superquadric that holds this one.
    #[must_use]
    pub fn convexified(self) -> Self {
        Self { e: self.e.min(2.0), n: self.n.min(2.0) }
    }

    /// Whether the shape is convex: e <= 2 and n <= 2.
    pub fn are_convex(self) -> bool {
        self.e <= 2.0 && self.n <= 2.0
    }
}

impl Default for Exponents {
    /// Those of a sphere.
    fn default() -> Self {
        Self::ROUND
    }
}

/// Whether a number is finite and above 0.
pub(crate) fn is_positive(x: f64) -> bool {
    x.is_finite() && x > 0.0
}

/// The reason why numbers do not make a superquadric.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
#[non_exhaustive]
pub enum ShapeError {
    /// A semi-axis is not a positive finite number.
    #[error(
        "every semi-axis must be a finite number above 0; a small one, such as 0.001, makes a thin shape"
    )]
    Radius,
    /// An exponent is negative or not finite.
    #[error("both exponents must be finite numbers, 0 or above")]
    Exponent,
}

/// The first crossing of a ray with the surface of a shape.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShapeHit {
    /// The ray parameter of the crossing, >= 0, in lengths of the ray's direction.
    pub t: f64,
    /// The point in the shape's own space. It is more exact than `ray.point_at(t)` where a
    /// coordinate is small: normals on the spikes and creases of shapes with e or n > 2 need that.
    pub point: DVec3,
    /// Whether the ray leaves the shape here.
    pub leaving: bool,
}
