//! Fitted superquadrics: checks and columns that the readers of fits share.

use superegg_geom::glam::{DMat3, DQuat, DVec3};

use crate::read::check;
use crate::read::options::ReadOptions;
use crate::read::particles::Particles;

/// One superquadric as a fit gives it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Fit {
    pub(crate) position: DVec3,
    pub(crate) radii: DVec3,
    /// (e, n).
    pub(crate) exponents: [f64; 2],
    /// From body to world; need not be of unit length.
    pub(crate) rotation: DQuat,
}

/// Appends a superquadric after its checks. `min_axis` raises smaller semi-axes; `false` is
/// returned if one was raised.
///
/// # Errors
/// A number is not finite, a semi-axis is not above 0, an exponent is below 0, or the quaternion
/// has no direction. The text names no position: the caller adds it.
pub(crate) fn push(particles: &mut Particles, fit: Fit, options: &ReadOptions) -> Result<bool, String> {
    let position = check::position(fit.position)?;
    let radii = check::semi_axes(fit.radii, options)?;
    let [e, n] = fit.exponents;
    let exponents = check::exponents(e, n)?;
    let DQuat { x, y, z, w } = fit.rotation;
    // A quaternion as it comes from angles keeps its digits.
    let is_unit = (fit.rotation.length() - 1.0).abs() <= 4.0 * f64::EPSILON;
    let rotation = if is_unit { fit.rotation } else { check::rotation(w, x, y, z)?.0 };
    particles.push(position, radii, exponents, rotation);
    Ok(radii == fit.radii)
}

/// The rotation of a matrix given row by row.
///
/// # Errors
/// A message about a matrix that is no rotation.
pub(crate) fn rotation_of_rows(rows: [f64; 9]) -> Result<DQuat, String> {
    check::rotation_of_matrix(DMat3::from_cols_array(&rows).transpose())
}

/// The warning that semi-axes were raised, if any were.
pub(crate) fn raised_warning(raised: usize) -> Option<String> {
    (raised > 0)
        .then(|| format!("{raised} shapes have semi-axes below the least one, which were raised to it"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fit() -> Fit {
        Fit { position: DVec3::ONE, radii: DVec3::ONE, exponents: [1.0, 0.5], rotation: DQuat::IDENTITY }
    }

    fn message(fit: Fit) -> String {
        push(&mut Particles::default(), fit, &ReadOptions::default()).unwrap_err()
    }

    #[test]
    fn wrong_numbers_are_errors() {
        assert!(message(Fit { position: DVec3::NAN, ..fit() }).contains("coordinate"));
        assert!(message(Fit { radii: DVec3::new(1.0, 0.0, 1.0), ..fit() }).contains("not above 0"));
        assert!(message(Fit { exponents: [1.0, -0.1], ..fit() }).contains("n = -0.1"));
        assert!(
            message(Fit { rotation: DQuat::from_xyzw(0.0, 0.0, 0.0, 0.0), ..fit() }).contains("direction")
        );
        let options = ReadOptions { min_axis: Some(0.5), ..ReadOptions::default() };
        let mut particles = Particles::default();
        let flat = Fit { radii: DVec3::new(2.0, 0.0, 0.1), ..fit() };
        assert_eq!(push(&mut particles, flat, &options), Ok(false));
        assert_eq!(particles.radii, [DVec3::new(2.0, 0.5, 0.5)]);
    }
}
