//! Weighted least squares in the eleven parameters.

use superegg_simd::{Arch, Simd, WithSimd};

use crate::parameters::{Bounds, COUNT, FIRST_EXPONENT, Parameters, Step};
use crate::rows::{Row, WIDTH};
use crate::tangent::Linearization;

/// A symmetric matrix; the entries above the diagonal are those below it.
pub(crate) type Matrix = [[f64; COUNT]; COUNT];

/// The normal equations of a weighted linear least-squares problem: matrix * step = -gradient.
#[derive(Clone, Debug)]
pub(crate) struct NormalEquations {
    pub(crate) matrix: Matrix,
    pub(crate) gradient: Step,
}

impl NormalEquations {
    /// From the residuals of points, their derivatives, and weights.
    pub(crate) fn of(linear: &Linearization, weights: &[Row]) -> Self {
        let mut sums = Sums { matrix: [[[0.0; WIDTH]; COUNT]; COUNT], gradient: [[0.0; WIDTH]; COUNT] };
        Arch::new().dispatch(Sum { linear, weights, to: &mut sums });
        let mut matrix = [[0.0; COUNT]; COUNT];
        for i in 0..COUNT {
            for j in 0..=i {
                matrix[i][j] = sums.matrix[i][j].iter().sum();
                matrix[j][i] = matrix[i][j];
            }
        }
        Self { matrix, gradient: sums.gradient.map(|lanes| lanes.iter().sum()) }
    }

    /// Adds a multiple of the gradient of another term of the cost.
    pub(crate) fn add_gradient(&mut self, slopes: &Step, scale: f64) {
        for (sum, slope) in self.gradient.iter_mut().zip(slopes) {
            *sum += scale * slope;
        }
    }

    /// The step of Levenberg and Marquardt at `shape`. An exponent at a bound that the step would
    /// cross is held there. `None` if the equations have no finite solution.
    pub(crate) fn step(&self, damping: f64, shape: &Parameters, bounds: Bounds) -> Option<Step> {
        let mut is_held = [false; COUNT];
        loop {
            let step = self.step_of_free(damping, &is_held)?;
            let crosses = |index: usize| {
                let exponent = shape.exponents[index - FIRST_EXPONENT];
                let is_outward = |bound: f64, sign: f64| exponent == bound && sign * step[index] > 0.0;
                is_outward(bounds.least, -1.0) || is_outward(bounds.most, 1.0)
            };
            match (FIRST_EXPONENT..COUNT).find(|&index| !is_held[index] && crosses(index)) {
                Some(index) => is_held[index] = true,
                None => return Some(step),
            }
        }
    }

    fn step_of_free(&self, damping: f64, is_held: &[bool; COUNT]) -> Option<Step> {
        let largest = (0..COUNT).map(|i| self.matrix[i][i]).fold(0.0, f64::max);
        let mut matrix = self.matrix;
        let mut right = self.gradient.map(|slope| -slope);
        for i in 0..COUNT {
            matrix[i][i] += damping * matrix[i][i] + 1e-12 * largest;
            if is_held[i] {
                for j in 0..COUNT {
                    (matrix[i][j], matrix[j][i]) = (0.0, 0.0);
                }
                (matrix[i][i], right[i]) = (1.0, 0.0);
            }
        }
        let step = solve(&cholesky(&matrix)?, &right);
        step.iter().all(|x| x.is_finite()).then_some(step)
    }
}

/// The sums of each lane.
struct Sums {
    matrix: [[Row; COUNT]; COUNT],
    gradient: [Row; COUNT],
}

struct Sum<'a> {
    linear: &'a Linearization,
    weights: &'a [Row],
    to: &'a mut Sums,
}

impl WithSimd for Sum<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Sums { matrix, gradient } = self.to;
        let rows = self.linear.distances.iter().zip(&self.linear.slopes).zip(self.weights);
        for ((distances, slopes), weights) in rows {
            for i in 0..COUNT {
                let mut weighted = [0.0; WIDTH];
                for lane in 0..WIDTH {
                    weighted[lane] = weights[lane] * slopes[i][lane];
                    gradient[i][lane] += weighted[lane] * distances[lane];
                }
                for j in 0..=i {
                    for lane in 0..WIDTH {
                        matrix[i][j][lane] += weighted[lane] * slopes[j][lane];
                    }
                }
            }
        }
    }
}

/// The lower triangle L with L * transpose(L) = `matrix`; `None` if the matrix is not positive.
pub(crate) fn cholesky(matrix: &Matrix) -> Option<Matrix> {
    let mut lower = [[0.0; COUNT]; COUNT];
    for i in 0..COUNT {
        for j in 0..=i {
            let sum: f64 = (0..j).map(|k| lower[i][k] * lower[j][k]).sum();
            let rest = matrix[i][j] - sum;
            if i == j {
                if !(rest > 0.0 && rest.is_finite()) {
                    return None;
                }
                lower[i][i] = rest.sqrt();
            } else {
                lower[i][j] = rest / lower[j][j];
            }
        }
    }
    Some(lower)
}

/// The solution of L * transpose(L) * x = `right`.
pub(crate) fn solve(lower: &Matrix, right: &Step) -> Step {
    let mut x = *right;
    for i in 0..COUNT {
        let sum: f64 = (0..i).map(|k| lower[i][k] * x[k]).sum();
        x[i] = (x[i] - sum) / lower[i][i];
    }
    for i in (0..COUNT).rev() {
        let sum: f64 = (i + 1..COUNT).map(|k| lower[k][i] * x[k]).sum();
        x[i] = (x[i] - sum) / lower[i][i];
    }
    x
}
