//! The doubts that a fit leaves.

use std::fmt;

use superegg_geom::Superquadric;
use superegg_geom::glam::{DQuat, DVec3};

/// The doubts that a fit leaves.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum FitWarning {
    /// Turning the shape about one of its axes changes the distances of the points by less than their
    /// noise: its section is round, or nearly so.
    Turnable {
        /// The axis: 0 for x, 1 for y, 2 for z.
        axis: usize,
    },
    /// Another shape fits the points as well, as for some views of one side.
    Ambiguous {
        /// The distance between both surfaces over the mean semi-axis, its root mean square.
        relative_distance: f64,
        /// The other shape.
        other: Superquadric,
        /// The rotation from the other shape's own axes to those of the points.
        rotation: DQuat,
        /// The centre of the other shape.
        center: DVec3,
    },
    /// The points leave the surface uncertain, as those of one side do.
    Uncertain {
        /// The standard error of the surface over the mean semi-axis, its root mean square.
        relative_error: f64,
    },
    /// An exponent is at the end of its range.
    AtBound {
        /// The exponent: 'e' or 'n'.
        exponent: char,
        /// Its value.
        value: f64,
    },
    /// More points are outliers than not.
    ManyOutliers {
        /// The share of outliers.
        share: f64,
    },
    /// The shape is a thin plate or needle: the points hardly determine its thickness.
    Thin {
        /// The least semi-axis over the largest.
        ratio: f64,
    },
    /// The distances are large: a superquadric is not the shape of these points, or the noise is high.
    Misfit {
        /// The standard deviation of the distances over the mean semi-axis.
        relative_noise: f64,
    },
}

impl fmt::Display for FitWarning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Turnable { axis } => write!(
                f,
                "the points do not determine the rotation about the shape's {} axis: it is round there",
                ["x", "y", "z"][*axis]
            ),
            Self::Ambiguous { relative_distance, other, .. } => {
                let ([x, y, z], exponents) = (other.radii().to_array(), other.exponents());
                write!(
                    f,
                    "another shape fits the points as well: semi-axes {x:.4} {y:.4} {z:.4}, exponents {:.3} {:.3}; the \
                     surfaces are {:.0} % of the size apart",
                    exponents.e(),
                    exponents.n(),
                    100.0 * relative_distance
                )
            }
            Self::Uncertain { relative_error } => write!(
                f,
                "the points do not determine the shape: its surface is uncertain by {:.1} % of its size, most of \
                 it where there are no points",
                100.0 * relative_error
            ),
            Self::AtBound { exponent, value } => write!(
                f,
                "the exponent {exponent} is at the end of its range, {value}; a wider range may fit better"
            ),
            Self::ManyOutliers { share } => {
                write!(f, "{:.0} % of the points are outliers; check that they show one shape", 100.0 * share)
            }
            Self::Thin { ratio } => write!(
                f,
                "the shape is thin: its least semi-axis is {ratio:.1e} of the largest; the points may show one \
                 side only"
            ),
            Self::Misfit { relative_noise } => write!(
                f,
                "the points are {:.0} % of the size away from the surface: they may not show a superquadric",
                100.0 * relative_noise
            ),
        }
    }
}
