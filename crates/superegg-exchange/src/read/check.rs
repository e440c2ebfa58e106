//! Checks that all readers share: sizes, exponents, rotations and ids of particles.

use std::collections::HashSet;

use superegg_geom::glam::{DMat3, DQuat, DVec3};

use super::options::ReadOptions;
use super::particles::Particles;

/// A quaternion whose length differs from 1 by more than this is reported.
const FAR_OFF: f64 = 1e-3;
/// A quaternion whose length differs from 1 by less than this stays as it is.
const NEAR: f64 = 2e-5;
/// A rotation matrix whose columns differ from an orthonormal basis by more than this is rejected.
const NOT_A_ROTATION: f64 = 0.05;

/// Semi-axes above 0, raised to [`ReadOptions::min_axis`] if that is set.
///
/// # Errors
/// A message about a number that is not finite or not above 0.
pub(super) fn semi_axes(radii: DVec3, options: &ReadOptions) -> Result<DVec3, String> {
    if !radii.is_finite() {
        return Err("a semi-axis is not a finite number".to_owned());
    }
    let radii = match options.min_axis {
        Some(least) if radii.min_element() >= 0.0 => radii.max(DVec3::splat(least)),
        Some(_) | None => radii,
    };
    if radii.min_element() > 0.0 {
        return Ok(radii);
    }
    let least = radii.min_element();
    Err(format!("a semi-axis of {least} is not above 0; --min-axis X raises small ones"))
}

/// Exponents (e, n), finite and not below 0.
///
/// # Errors
/// A message about a number that is not.
pub(super) fn exponents(e: f64, n: f64) -> Result<[f64; 2], String> {
    let is_valid = |x: f64| x.is_finite() && x >= 0.0;
    if is_valid(e) && is_valid(n) {
        // 0 is the limit: a box or a cylinder. Adding 0 turns -0 into 0.
        Ok([e + 0.0, n + 0.0])
    } else {
        Err(format!("the exponents e = {e}, n = {n} are not finite numbers from 0 up"))
    }
}

/// Exponents from the powers of programs that write |x|^N: e = 2 / `across`, n = 2 / `along`.
///
/// # Errors
/// A message about a power below 2, which those programs refuse.
pub(super) fn exponents_of_blockiness(along: f64, across: f64) -> Result<[f64; 2], String> {
    for power in [along, across] {
        if !power.is_finite() || power < 2.0 {
            return Err(format!("a blockiness of {power} is not a number from 2 up"));
        }
    }
    exponents(2.0 / across, 2.0 / along)
}

/// A quaternion of unit length to the file's digits from four numbers, and whether they were far from
/// one. Numbers that are near enough stay as they are, so that tables store them in few bytes.
///
/// # Errors
/// A message about numbers that have no direction.
pub(super) fn rotation(w: f64, x: f64, y: f64, z: f64) -> Result<(DQuat, bool), String> {
    let largest = w.abs().max(x.abs()).max(y.abs()).max(z.abs());
    let are_finite = [w, x, y, z].iter().all(|number| number.is_finite());
    if !are_finite || largest == 0.0 {
        return Err(format!("the quaternion {w} {x} {y} {z} has no direction"));
    }
    // Squares of extreme numbers leave the range of f64.
    let scale = if (1e-100..1e100).contains(&largest) { 1.0 } else { largest };
    let scaled = DQuat::from_xyzw(x / scale, y / scale, z / scale, w / scale);
    let length = scaled.length();
    let off = (length * scale - 1.0).abs();
    if off < NEAR {
        return Ok((DQuat::from_xyzw(x, y, z, w), false));
    }
    Ok((scaled / length, off > FAR_OFF))
}

/// The rotation of a matrix whose columns are the images of the body's axes. A mirror is undone by
/// turning one axis around, which changes no superquadric.
///
/// # Errors
/// A message about a matrix that is no rotation.
pub(super) fn rotation_of_matrix(matrix: DMat3) -> Result<DQuat, String> {
    let columns = [matrix.x_axis, matrix.y_axis, matrix.z_axis];
    let [x, y, z] = columns;
    let off = columns.iter().map(|column| (column.length() - 1.0).abs()).fold(0.0, f64::max);
    let skew = x.dot(y).abs().max(x.dot(z).abs()).max(y.dot(z).abs());
    // Written so that a number that is not finite is rejected.
    if !(off < NOT_A_ROTATION && skew < NOT_A_ROTATION) {
        return Err("the matrix is no rotation".to_owned());
    }
    let z = if matrix.determinant() < 0.0 { -z } else { z };
    // Averages the errors of single precision over the columns.
    let mut rotation = DMat3::from_cols(x, y, z);
    for _ in 0..4 {
        rotation = (rotation + rotation.inverse().transpose()) * 0.5;
    }
    Ok(DQuat::from_mat3(&rotation).normalize())
}

/// A position of finite numbers.
///
/// # Errors
/// A message about a number that is not finite.
pub(super) fn position(position: DVec3) -> Result<DVec3, String> {
    if position.is_finite() { Ok(position) } else { Err("a coordinate is not a finite number".to_owned()) }
}

/// A warning about ids that occur more than once.
pub(super) fn repeated_ids(particles: &Particles) -> Option<String> {
    let ids = &particles.ids;
    // Ids in order, as in most files, need no set.
    if ids.windows(2).all(|pair| pair[0] < pair[1]) {
        return None;
    }
    let mut seen = HashSet::with_capacity(ids.len());
    let repeated = ids.iter().filter(|id| !seen.insert(**id)).count();
    (repeated > 0).then(|| format!("{repeated} particles have an id that another one has"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rotations_are_made_exact_or_refused() {
        let turn = DQuat::from_axis_angle(DVec3::new(1.0, 2.0, 3.0).normalize(), 0.7);
        let matrix = DMat3::from_quat(turn);
        let rounded = DMat3::from_cols_array(&matrix.to_cols_array().map(|x| f64::from(x as f32)));
        let found = rotation_of_matrix(rounded).unwrap();
        assert!(found.angle_between(turn) < 1e-6 && found.is_normalized());
        let mirrored = matrix * DMat3::from_diagonal(DVec3::new(1.0, 1.0, -1.0));
        assert!(rotation_of_matrix(mirrored).unwrap().angle_between(turn) < 1e-12);
        for wrong in [DMat3::ZERO, DMat3::from_diagonal(DVec3::new(2.0, 1.0, 1.0)), DMat3::NAN] {
            assert!(rotation_of_matrix(wrong).is_err());
        }
    }

    #[test]
    fn quaternions_of_any_length_are_normalized_and_far_ones_reported() {
        for scale in [1.0, 1e-300, 1e300, -2.0] {
            let (found, far) = rotation(0.5 * scale, 0.5 * scale, -0.5 * scale, 0.5 * scale).unwrap();
            assert!(found.is_normalized());
            assert_eq!(far, scale != 1.0);
        }
        assert!(rotation(0.0, 0.0, 0.0, 0.0).is_err() && rotation(f64::NAN, 0.0, 0.0, 1.0).is_err());
    }

    #[test]
    fn sizes_and_exponents_out_of_range_are_refused() {
        let options = ReadOptions::default();
        for radii in [DVec3::ZERO, DVec3::NEG_ONE, DVec3::NAN, DVec3::new(1.0, 0.0, 1.0)] {
            assert!(semi_axes(radii, &options).is_err());
        }
        let raised = ReadOptions { min_axis: Some(0.1), ..options };
        assert_eq!(semi_axes(DVec3::new(1.0, 0.0, 1.0), &raised), Ok(DVec3::new(1.0, 0.1, 1.0)));
        assert!(semi_axes(DVec3::NEG_ONE, &raised).is_err());
        assert!(exponents_of_blockiness(1.9, 2.0).is_err() && exponents(-1.0, 1.0).is_err());
        assert_eq!(exponents_of_blockiness(8.0, 2.0), Ok([1.0, 0.25]));
    }
}
