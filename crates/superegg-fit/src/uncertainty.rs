//! How well points determine a shape.

use superegg_geom::symmetric_eigen;

use crate::normal_equations::Matrix;
use crate::parameters::COUNT;

/// The part of the largest eigenvalue below which a direction is undetermined.
const UNDETERMINED: f64 = 1e-10;
/// The first of the parameters whose derivatives are the same in all octants.
const FIRST_EVEN: usize = 6;

/// How well points determine a shape, in the unit and the parameters of the search.
pub(crate) struct Uncertainty {
    /// The covariance of the parameters. Directions that the points do not determine at all, such as
    /// rotations of a sphere, have no part in it.
    pub(crate) covariance: Matrix,
    /// The standard error of the surface, its root mean square over the whole of it.
    pub(crate) surface: f64,
    /// The root mean square of the derivative of the distance by each parameter.
    pub(crate) slopes: [f64; COUNT],
    /// Whether each parameter is part of a direction that the points do not determine at all.
    pub(crate) is_free: [bool; COUNT],
}

impl Uncertainty {
    /// From the sum of the squared derivatives of the distances, the sum of weights, and the standard
    /// deviation of the distances.
    ///
    /// The error of the surface in a parameter is the derivative of the distance. Over a whole surface
    /// the derivatives have the squares that they have at the points and in their mirror images, where
    /// those by the centre and the rotation change signs: so mixed sums with them vanish.
    pub(crate) fn of(information: &Matrix, total: f64, sigma: f64) -> Self {
        let (values, vectors) = symmetric_eigen(*information);
        let least = UNDETERMINED * values.iter().fold(0.0, |a: f64, b| a.max(*b));
        let mut covariance = [[0.0; COUNT]; COUNT];
        let mut is_free = [false; COUNT];
        for (value, vector) in values.iter().zip(vectors) {
            for i in 0..COUNT {
                if *value <= least {
                    is_free[i] |= vector[i].abs() > 0.5;
                    continue;
                }
                for j in 0..COUNT {
                    covariance[i][j] += sigma * sigma * vector[i] * vector[j] / value;
                }
            }
        }
        let mut square = 0.0;
        for i in 0..COUNT {
            for j in 0..COUNT {
                if i == j || (i >= FIRST_EVEN && j >= FIRST_EVEN) {
                    square += covariance[i][j] * information[i][j] / total;
                }
            }
        }
        let slopes = std::array::from_fn(|i| (information[i][i] / total).sqrt());
        Self { covariance, surface: square.max(0.0).sqrt(), slopes, is_free }
    }
}
