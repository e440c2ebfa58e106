//! Eigenvalues and eigenvectors of symmetric 3x3 matrices.

use superegg_geom::glam::{DMat3, DVec3};

/// The number of sweeps after which the off-diagonal numbers are below the last digit: Jacobi's
/// method converges quadratically, and six sweeps were enough for every matrix tried.
const SWEEPS: usize = 32;

/// The eigenvalues of a symmetric matrix, and orthonormal eigenvectors as the columns of a matrix
/// in the same order, by Jacobi's rotations (Golub and Van Loan, Matrix Computations, 8.5). Only
/// the mean of the matrix and its transpose counts. The numbers must be finite.
pub(super) fn symmetric_eigen(matrix: DMat3) -> (DVec3, DMat3) {
    // Numbers near 1: squares of the largest and smallest floats are then harmless.
    let largest = matrix.to_cols_array().iter().fold(0.0f64, |largest, number| largest.max(number.abs()));
    if largest == 0.0 {
        return (DVec3::ZERO, DMat3::IDENTITY);
    }
    let scaled = DMat3::from_cols(matrix.x_axis / largest, matrix.y_axis / largest, matrix.z_axis / largest);
    let mut a = ((scaled + scaled.transpose()) * 0.5).to_cols_array_2d();
    let mut vectors = DMat3::IDENTITY.to_cols_array_2d();
    for _ in 0..SWEEPS {
        if a[0][1] == 0.0 && a[0][2] == 0.0 && a[1][2] == 0.0 {
            break;
        }
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            rotate(&mut a, &mut vectors, p, q);
        }
    }
    (DVec3::new(a[0][0], a[1][1], a[2][2]) * largest, DMat3::from_cols_array_2d(&vectors))
}

/// Makes `a[p][q]` zero by a rotation in the plane of the axes p and q, and turns the vectors
/// along.
fn rotate(a: &mut [[f64; 3]; 3], vectors: &mut [[f64; 3]; 3], p: usize, q: usize) {
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
    let other = 3 - p - q;
    a[p][p] -= tangent * off;
    a[q][q] += tangent * off;
    (a[p][q], a[q][p]) = (0.0, 0.0);
    let (to_p, to_q) = (a[other][p], a[other][q]);
    a[other][p] = cosine * to_p - sine * to_q;
    a[other][q] = sine * to_p + cosine * to_q;
    a[p][other] = a[other][p];
    a[q][other] = a[other][q];
    let (of_p, of_q) = (vectors[p], vectors[q]);
    vectors[p] = std::array::from_fn(|axis| cosine * of_p[axis] - sine * of_q[axis]);
    vectors[q] = std::array::from_fn(|axis| sine * of_p[axis] + cosine * of_q[axis]);
}

#[cfg(test)]
mod tests {
    use super::*;
    use superegg_geom::glam::DQuat;

    fn check(matrix: DMat3) -> DVec3 {
        let (values, vectors) = symmetric_eigen(matrix);
        let size = matrix.to_cols_array().iter().fold(0.0f64, |size, number| size.max(number.abs()));
        let identity = vectors.transpose() * vectors;
        assert!(identity.abs_diff_eq(DMat3::IDENTITY, 1e-14), "{matrix:?}: {vectors:?}");
        for axis in 0..3 {
            let error = (matrix * vectors.col(axis) - vectors.col(axis) * values[axis]) / size.max(1e-300);
            assert!(error.length() < 4e-15, "{matrix:?}: {error}");
        }
        values
    }

    fn sorted(values: DVec3) -> [f64; 3] {
        let mut values = values.to_array();
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
                let size = spectrum.abs().max_element();
                for (found, known) in sorted(check(matrix)).into_iter().zip(sorted(spectrum)) {
                    assert!((found - known).abs() < 1e-14 * size, "{spectrum}: {found} {known}");
                }
            }
        }
    }

    #[test]
    fn extreme_sizes_keep_their_digits() {
        let matrix = DMat3::from_cols_array(&[2.0, 1.0, 0.0, 1.0, 2.0, 0.0, 0.0, 0.0, 1.0]);
        for size in [1e-290, 1e-30, 1.0, 1e30, 1e300] {
            let values = sorted(check(matrix * size));
            for (found, known) in values.into_iter().zip([1.0, 1.0, 3.0]) {
                assert!((found / size - known).abs() < 1e-14, "{size}: {found}");
            }
        }
        assert_eq!(symmetric_eigen(DMat3::ZERO), (DVec3::ZERO, DMat3::IDENTITY));
    }

    #[test]
    fn an_unsymmetric_matrix_counts_by_its_symmetric_part() {
        let matrix = DMat3::from_cols_array(&[1.0, 2.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 5.0]);
        let (values, _) = symmetric_eigen(matrix);
        assert_eq!(sorted(values).map(|value| (value * 1e12).round() / 1e12), [0.0, 2.0, 5.0]);
    }
}
