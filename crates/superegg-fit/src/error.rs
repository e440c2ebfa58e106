//! Why points have no fit.

use thiserror::Error;

/// The fewest distinct points of a fit: one more than a superquadric in space has parameters.
pub const LEAST_POINTS: usize = 12;

/// Why points have no fit.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum FitError {
    /// There are fewer distinct points than parameters.
    #[error(
        "a superquadric has 11 parameters, so a fit needs at least {LEAST_POINTS} different points; found \
         {distinct} different of {count}"
    )]
    TooFewPoints {
        /// The number of points.
        count: usize,
        /// The number of different points.
        distinct: usize,
    },
    /// A coordinate is not a finite number.
    #[error("point {index} has a coordinate that is not finite; leave it out")]
    NotFinite {
        /// The index of the first such point, from 0.
        index: usize,
    },
    /// The points are too far apart or too close together for the range of f64.
    #[error(
        "the points are about {extent:.0e} apart; choose a unit that makes this a number from 1e-95 to 1e95"
    )]
    Scale {
        /// The median distance from the middle point.
        extent: f64,
    },
    /// All points lie on a line.
    #[error("all points lie on a line; a fit needs points of a surface that is seen from more than one side")]
    OnLine,
    /// All points lie on a plane.
    #[error("all points lie on a plane; a fit needs points of at least one more side of the surface")]
    OnPlane,
    /// A weight or an option is out of its range.
    #[error("{0}")]
    Option(&'static str),
}
