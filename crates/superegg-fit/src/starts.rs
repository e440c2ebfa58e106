//! Shapes to start from.

use superegg_geom::glam::{DMat3, DQuat, DVec3};
use superegg_geom::{SplitMix, symmetric_eigen};

use crate::alike::with_third_axis;
use crate::parameters::{Bounds, Parameters};

/// The ratio of semi-axes below which any axes are possible.
const ROUND: f64 = 1.3;
/// Steps to the scatter matrix.
const STEPS: usize = 8;

/// The ellipsoid that fits the directions of the points best, whatever their distances (D. Tyler,
/// A distribution-free M-estimator of multivariate scatter, 1987), scaled to their median.
pub(crate) fn robust_ellipsoid(points: &[DVec3]) -> Parameters {
    let mut center = median(points);
    let mut scatter = DMat3::IDENTITY;
    for _ in 0..STEPS {
        let inverse = scatter.inverse();
        let (mut sum, mut shift, mut total) = (DMat3::ZERO, DVec3::ZERO, 0.0);
        for &point in points {
            let off = point - center;
            let square = off.dot(inverse * off).max(1e-12);
            sum += outer(off * (1.0 / square), off);
            let weight = 1.0 / square.sqrt();
            (shift, total) = (shift + weight * off, total + weight);
        }
        let trace = sum.x_axis.x + sum.y_axis.y + sum.z_axis.z;
        // A little of a sphere keeps the matrix regular.
        scatter = sum * (3.0 / trace) + DMat3::from_diagonal(DVec3::splat(1e-6));
        center += shift / total;
    }
    let (values, axes) = principal_axes(&scatter);
    let inverse = scatter.inverse();
    let mut lengths: Vec<f64> = points
        .iter()
        .map(|&point| {
            let off = point - center;
            off.dot(inverse * off).sqrt()
        })
        .collect();
    let middle = lengths.len() / 2;
    let (_, &mut length, _) = lengths.select_nth_unstable_by(middle, f64::total_cmp);
    let radii = DVec3::from_array(values.to_array().map(|value| value.sqrt() * length));
    Parameters { center, axes, radii: radii.max(DVec3::splat(1e-3)), exponents: [1.0, 1.0] }
}

fn outer(a: DVec3, b: DVec3) -> DMat3 {
    DMat3::from_cols(a * b.x, a * b.y, a * b.z)
}

fn median(points: &[DVec3]) -> DVec3 {
    let of = |axis: usize| {
        let mut values: Vec<f64> = points.iter().map(|point| point[axis]).collect();
        let middle = values.len() / 2;
        *values.select_nth_unstable_by(middle, f64::total_cmp).1
    };
    DVec3::new(of(0), of(1), of(2))
}

/// The eigenvalues of a symmetric matrix, the largest first, and a rotation to its eigenvectors.
fn principal_axes(matrix: &DMat3) -> (DVec3, DMat3) {
    let (values, vectors) = symmetric_eigen(matrix.to_cols_array_2d());
    let mut order = [0, 1, 2];
    order.sort_by(|&i, &j| values[j].total_cmp(&values[i]));
    let [x, y, _] = order.map(|index| DVec3::from_array(vectors[index]));
    (DVec3::from_array(order.map(|index| values[index])), DMat3::from_cols(x, y, x.cross(y)))
}

/// Exponents to begin with: a sphere, a box, a cylinder, and sections of diamonds.
const EXPONENTS: [[f64; 2]; 5] = [[1.0, 1.0], [0.4, 0.4], [1.0, 0.3], [1.6, 1.0], [0.4, 1.6]];
/// Exponents to begin with in random directions.
const RANDOM_EXPONENTS: [[f64; 2]; 2] = [[0.6, 0.6], [1.0, 0.3]];

/// The shapes from which the search starts: the ellipsoid with each axis as the third one.
pub(crate) fn starts(ellipsoid: &Parameters, bounds: Bounds) -> Vec<Parameters> {
    let mut shapes = Vec::new();
    for z in 0..3 {
        let shape = with_third_axis(ellipsoid, z);
        shapes.extend(EXPONENTS.map(|exponents| shape.with_exponents(exponents, bounds)));
    }
    shapes
}

/// Whether the axes of an ellipsoid are those of its points by chance alone.
pub(crate) fn is_round(ellipsoid: &Parameters) -> bool {
    ellipsoid.radii.max_element() < ROUND * ellipsoid.radii.min_element()
}

/// More starts, in random directions.
pub(crate) fn random_starts(
    ellipsoid: &Parameters,
    bounds: Bounds,
    count: usize,
    random: &mut SplitMix,
) -> Vec<Parameters> {
    let mut gaussian = || {
        let radius = (-2.0 * (1.0 - random.unit()).ln()).sqrt();
        radius * (std::f64::consts::TAU * random.unit()).cos()
    };
    let mut start = |index: usize| {
        let turn = DQuat::from_xyzw(gaussian(), gaussian(), gaussian(), gaussian()).normalize();
        let round = Parameters {
            axes: ellipsoid.axes * DMat3::from_quat(turn),
            radii: DVec3::splat(ellipsoid.size()),
            ..*ellipsoid
        };
        round.with_exponents(RANDOM_EXPONENTS[index % RANDOM_EXPONENTS.len()], bounds)
    };
    (0..count).map(&mut start).collect()
}
