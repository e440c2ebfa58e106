//! Eigenvalues and eigenvectors of small symmetric matrices.

/// The number of sweeps after which the off-diagonal numbers are below the last digit: Jacobi's
/// method converges quadratically, and seven sweeps were enough for every matrix tried.
const SWEEPS: usize = 32;

/// The eigenvalues of a symmetric matrix in no order, and orthonormal eigenvectors in the same order, by
/// Jacobi's rotations (Golub and Van Loan, Matrix Computations, 8.5). Only the mean of the matrix and its
/// transpose counts. The numbers must be finite.
///
/// ```
/// let (values, vectors) = superegg_geom::symmetric_eigen([[2.0, 1.0], [1.0, 2.0]]);
/// let largest = if values[0] > values[1] { 0 } else { 1 };
/// assert!((values[largest] - 3.0_f64).abs() < 1e-15);
/// let [x, y] = vectors[largest];
/// assert!((x - y).abs() < 1e-15 && (x * x + y * y - 1.0_f64).abs() < 1e-15);
/// ```
pub fn symmetric_eigen<const N: usize>(matrix: [[f64; N]; N]) -> ([f64; N], [[f64; N]; N]) {
    let mut vectors: [[f64; N]; N] =
        std::array::from_fn(|i| std::array::from_fn(|j| if i == j { 1.0 } else { 0.0 }));
    // Numbers near 1: squares of the largest and smallest floats are then harmless.
    let largest = matrix.as_flattened().iter().fold(0.0f64, |largest, number| largest.max(number.abs()));
    if largest == 0.0 {
        return ([0.0; N], vectors);
    }
    let mut a: [[f64; N]; N] = std::array::from_fn(|i| {
        std::array::from_fn(|j| (matrix[i][j] / largest + matrix[j][i] / largest) * 0.5)
    });
    for _ in 0..SWEEPS {
        let mut is_diagonal = true;
        for p in 0..N {
            for q in p + 1..N {
                if a[p][q] != 0.0 {
                    is_diagonal = false;
                    rotate(&mut a, &mut vectors, p, q);
                }
            }
        }
        if is_diagonal {
            break;
        }
    }
    (std::array::from_fn(|i| a[i][i] * largest), vectors)
}

/// Makes `a[p][q]` zero by a rotation in the plane of the axes p and q, and turns the vectors
/// along.
fn rotate<const N: usize>(a: &mut [[f64; N]; N], vectors: &mut [[f64; N]; N], p: usize, q: usize) {
    let off = a[p][q];
    // Below the last digit of both diagonal numbers.
    if off.abs() <= f64::EPSILON * 0.25 * a[p][p].abs().min(a[q][q].abs()) || off.abs() < 1e-300 {
        (a[p][q], a[q][p]) = (0.0, 0.0);
        return;
    }
    let theta = (a[q][q] - a[p][p]) / (2.0 * off);
    let tangent = theta.signum() / (theta.abs() + theta.hypot(1.0));
    let cosine = 1.0 / tangent.hypot(1.0);
    let sine = tangent * cosine;
    a[p][p] -= tangent * off;
    a[q][q] += tangent * off;
    (a[p][q], a[q][p]) = (0.0, 0.0);
    for other in (0..N).filter(|&other| other != p && other != q) {
        let (to_p, to_q) = (a[other][p], a[other][q]);
        a[other][p] = cosine * to_p - sine * to_q;
        a[other][q] = sine * to_p + cosine * to_q;
        a[p][other] = a[other][p];
        a[q][other] = a[other][q];
    }
    let (of_p, of_q) = (vectors[p], vectors[q]);
    vectors[p] = std::array::from_fn(|axis| cosine * of_p[axis] - sine * of_q[axis]);
    vectors[q] = std::array::from_fn(|axis| sine * of_p[axis] + cosine * of_q[axis]);
}

#[cfg(test)]
mod tests {
    use glam::{DMat3, DQuat, DVec3};

    use super::*;
    use crate::SplitMix;

    /// Checks the vectors, and returns the values in ascending order.
    fn check<const N: usize>(matrix: [[f64; N]; N], tolerance: f64) -> [f64; N] {
        let (mut values, vectors) = symmetric_eigen(matrix);
        let size = matrix.as_flattened().iter().fold(1e-300f64, |size, number| size.max(number.abs()));
        let dot = |a: &[f64; N], b: &[f64; N]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        for (i, vector) in vectors.iter().enumerate() {
            for (j, other) in vectors.iter().enumerate() {
                let expected = if i == j { 1.0 } else { 0.0 };
                assert!((dot(vector, other) - expected).abs() < 1e-14, "{matrix:?}: {vectors:?}");
            }
            for (row, number) in matrix.iter().zip(vector) {
                let error = (dot(row, vector) - values[i] * number) / size;
                assert!(error.abs() < tolerance, "{matrix:?}: {error}");
            }
        }
        values.sort_by(f64::total_cmp);
        values
    }

    #[test]
    fn eigenvalues_and_rotations_are_found_again() {
        let spectra = [
            DVec3::new(3.0, 2.0, 1.0),
            DVec3::new(1.0, 1.0, 1.0),
            DVec3::new(5.0, 5.0, -2.0),
            DVec3::new(1e-9, 1.0, 1e9),
            DVec3::new(1.0, 1.0 + 1e-12, 0.0),
            DVec3::new(0.0, 0.0, 7.0),
            DVec3::new(-1.0, 0.0, 1.0),
        ];
        for (turn, spectrum) in spectra.into_iter().enumerate() {
            for step in 0..50u32 {
                let angle = f64::from(step) * 0.7 + turn as f64;
                let axis =
                    DVec3::new(angle.sin(), (2.0 * angle).cos(), (3.0 * angle).sin() + 0.1).normalize();
                let rotation = DMat3::from_quat(DQuat::from_axis_angle(axis, angle));
                let matrix = rotation * DMat3::from_diagonal(spectrum) * rotation.transpose();
                let mut known = spectrum.to_array();
                known.sort_by(f64::total_cmp);
                for (found, known) in check(matrix.to_cols_array_2d(), 4e-15).into_iter().zip(known) {
                    assert!(
                        (found - known).abs() < 1e-14 * spectrum.abs().max_element(),
                        "{spectrum}: {found}"
                    );
                }
            }
        }
    }

    #[test]
    fn large_matrices_have_their_vectors() {
        let mut random = SplitMix::new(1);
        for _ in 0..50 {
            let any: [[f64; 11]; 11] = std::array::from_fn(|_| std::array::from_fn(|_| random.unit() - 0.5));
            let symmetric: [[f64; 11]; 11] =
                std::array::from_fn(|i| std::array::from_fn(|j| any[i.max(j)][i.min(j)]));
            check(symmetric, 2e-14);
        }
    }

    #[test]
    fn extreme_sizes_keep_their_digits() {
        for size in [1e-290, 1e-30, 1.0, 1e30, 1e300] {
            let matrix = [[2.0, 1.0, 0.0], [1.0, 2.0, 0.0], [0.0, 0.0, 1.0]].map(|row| row.map(|x| x * size));
            for (found, known) in check(matrix, 4e-15).into_iter().zip([1.0, 1.0, 3.0]) {
                assert!((found / size - known).abs() < 1e-14, "{size}: {found}");
            }
        }
        assert_eq!(symmetric_eigen([[0.0; 2]; 2]), ([0.0; 2], [[1.0, 0.0], [0.0, 1.0]]));
    }

    #[test]
    fn an_unsymmetric_matrix_counts_by_its_symmetric_part() {
        let (mut values, _) = symmetric_eigen([[1.0, 2.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 5.0]]);
        values.sort_by(f64::total_cmp);
        assert_eq!(values.map(|value| (value * 1e12).round() / 1e12), [0.0, 2.0, 5.0]);
    }
}
