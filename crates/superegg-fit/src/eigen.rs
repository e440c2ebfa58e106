//! Eigenvalues of small symmetric matrices.

/// The sweeps of Jacobi's method; a few are enough.
const SWEEPS: usize = 30;

/// The eigenvalues of a symmetric matrix and their unit eigenvectors, in no order: by Jacobi's method.
pub(crate) fn eigen<const N: usize>(mut a: [[f64; N]; N]) -> ([f64; N], [[f64; N]; N]) {
    let mut vectors = [[0.0; N]; N];
    for (i, vector) in vectors.iter_mut().enumerate() {
        vector[i] = 1.0;
    }
    for _ in 0..SWEEPS {
        let mut is_diagonal = true;
        for i in 0..N {
            for j in i + 1..N {
                if a[i][j].abs() <= f64::EPSILON * 1e-3 * (a[i][i] * a[j][j]).abs().sqrt() {
                    continue;
                }
                is_diagonal = false;
                let theta = 0.5 * (a[j][j] - a[i][i]) / a[i][j];
                let tangent = 1f64.copysign(theta) / (theta.abs() + theta.hypot(1.0));
                let cosine = 1.0 / tangent.hypot(1.0);
                let sine = tangent * cosine;
                let turn = |x: f64, y: f64| (cosine * x - sine * y, sine * x + cosine * y);
                for row in &mut a {
                    (row[i], row[j]) = turn(row[i], row[j]);
                }
                for k in 0..N {
                    (a[i][k], a[j][k]) = turn(a[i][k], a[j][k]);
                    (vectors[i][k], vectors[j][k]) = turn(vectors[i][k], vectors[j][k]);
                }
            }
        }
        if is_diagonal {
            break;
        }
    }
    (std::array::from_fn(|i| a[i][i]), vectors)
}

#[cfg(test)]
mod tests {
    use superegg_geom::SplitMix;

    use super::*;

    #[test]
    fn vectors_are_stretched_by_their_values() {
        let mut random = SplitMix::new(1);
        for _ in 0..50 {
            let mut matrix = [[0.0; 11]; 11];
            for i in 0..11 {
                for j in 0..=i {
                    matrix[i][j] = random.unit() - 0.5;
                    matrix[j][i] = matrix[i][j];
                }
            }
            let (values, vectors) = eigen(matrix);
            for (value, vector) in values.iter().zip(vectors) {
                for (i, row) in matrix.iter().enumerate() {
                    let product: f64 = row.iter().zip(vector).map(|(a, v)| a * v).sum();
                    assert!((product - value * vector[i]).abs() < 1e-13);
                }
            }
        }
    }
}
