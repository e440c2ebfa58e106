//! Affine maps with their inverses, built from a list of steps.

use glam::{DAffine3, DMat3, DQuat, DVec3, DVec4};
use thiserror::Error;

use crate::math::numeric::{difference_of_products, scale_to_unit, unit_vector};

/// One step of a transform, as the modelling language writes it.
#[derive(Clone, Debug, PartialEq)]
pub enum TransformStep {
    /// Moves by this vector.
    Translate(DVec3),
    /// Turns right-handed about an axis through the origin; the axis need not be of unit length.
    Rotate {
        /// The axis; not zero.
        axis: DVec3,
        /// The angle, in degrees.
        angle_deg: f64,
    },
    /// Scales along x, y and z; negative mirrors; zero is an error.
    Scale(DVec3),
    /// Rotates by a quaternion, body to world. It need not be of unit length: its direction counts;
    /// zero is an error.
    Orient(DQuat),
    /// Applies an affine map, which must be invertible. On the heap, because it is rare and four
    /// times as large as the other steps.
    Affine(Box<DAffine3>),
}

/// The reason why a list of steps is not a usable transform.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
#[non_exhaustive]
pub enum TransformError {
    /// A scale of zero flattens space.
    #[error("a scale of 0 flattens the shape: no factor may be 0")]
    ZeroScale,
    /// A rotation axis without a direction.
    #[error("the rotation axis 0 0 0 has no direction")]
    ZeroAxis,
    /// A quaternion without a direction.
    #[error("the quaternion 0 0 0 0 is no rotation")]
    ZeroQuaternion,
    /// A matrix that flattens space, or is too near to one for its inverse to be known in f64.
    #[error("the matrix has no inverse: its columns lie in one plane, to the precision of its numbers")]
    Singular,
    /// The composed matrix or its inverse is not finite.
    #[error(
        "the transform leaves the range of numbers: together its steps are too large or too small to be undone"
    )]
    OutOfRange,
}

/// The determinant of a levelled matrix, whose entries are below 1, from which on its inverse is
/// known to some digits.
const SMALLEST_DETERMINANT: f64 = 64.0 * f64::EPSILON;

/// The unit quaternion of the same direction; `None` if it is zero or not finite. Its length
/// may be any: it is scaled to about 1 before it is squared.
fn unit_quaternion(quaternion: DQuat) -> Option<DQuat> {
    let v = DVec4::from(quaternion);
    let largest = v.abs().max_element();
    if largest == 0.0 || !v.is_finite() {
        return None;
    }
    // In two steps: the reciprocal of a subnormal number is infinite.
    let scaled = v / largest;
    let length = scaled.length();
    // A unit quaternion stays as it is, to the last bit.
    let is_unit = largest <= 1.0 && (v.length_squared() - 1.0).abs() <= f64::EPSILON;
    Some(DQuat::from_vec4(if is_unit { v } else { scaled / length }))
}

/// The rotation by `angle_deg` about a unit axis (Rodrigues), exact at multiples of 90 degrees.
#[inline]
fn rotation(axis: DVec3, angle_deg: f64) -> DMat3 {
    // The remainder is a call.
    let reduced = if angle_deg.abs() < 360.0 { angle_deg } else { angle_deg % 360.0 };
    let (sin, cos) = match reduced {
        0.0 => (0.0, 1.0),
        90.0 | -270.0 => (1.0, 0.0),
        180.0 | -180.0 => (0.0, -1.0),
        270.0 | -90.0 => (-1.0, 0.0),
        _ => reduced.to_radians().sin_cos(),
    };
    let column = |v: DVec3| v * cos + axis.cross(v) * sin + axis * (axis.dot(v) * (1.0 - cos));
    DMat3::from_cols(column(DVec3::X), column(DVec3::Y), column(DVec3::Z))
}

/// An invertible affine map, kept with its inverse. Both are finite.
///
/// ```
/// use superegg_geom::{Transform, TransformError, TransformStep, glam::DVec3};
/// let steps = [
///     TransformStep::Scale(DVec3::splat(2.0)),
///     TransformStep::Translate(DVec3::X),
/// ];
/// let transform = Transform::from_steps(&steps)?;
/// assert_eq!(transform.forward().transform_point3(DVec3::X), DVec3::new(3.0, 0.0, 0.0));
/// assert_eq!(transform.inverse().transform_point3(DVec3::X), DVec3::ZERO);
/// let flat = TransformStep::Scale(DVec3::new(1.0, 0.0, 1.0));
/// assert_eq!(Transform::from_steps([&flat]), Err(TransformError::ZeroScale));
/// # Ok::<(), TransformError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Transform {
    forward: DAffine3,
    inverse: DAffine3,
}

impl Transform {
    /// The map that moves nothing.
    pub const IDENTITY: Self = Self { forward: DAffine3::IDENTITY, inverse: DAffine3::IDENTITY };

    /// A rotation followed by a translation. The rotation is a unit quaternion.
    #[inline]
    pub fn rigid(rotation: DQuat, translation: DVec3) -> Self {
        let matrix3 = DMat3::from_quat(rotation);
        let transposed = matrix3.transpose();
        Self {
            forward: DAffine3 { matrix3, translation },
            inverse: DAffine3 { matrix3: transposed, translation: transposed * -translation },
        }
    }

    /// The map of an ordered list: the first step acts on the point first.
    ///
    /// # Errors
    /// A zero scale, a zero axis, or a composition that is not finite and invertible in f64.
    #[inline]
    pub fn from_steps<'a>(
        steps: impl IntoIterator<Item = &'a TransformStep>,
    ) -> Result<Self, TransformError> {
        let mut composed = Self::IDENTITY;
        for (number, step) in steps.into_iter().enumerate() {
            composed.add(step, number == 0)?;
        }
        Ok(composed)
    }

    /// Appends a step, which acts last. After an error the map is as it was.
    ///
    /// # Errors
    /// As [`Transform::from_steps`].
    pub fn append(&mut self, step: &TransformStep) -> Result<(), TransformError> {
        self.add(step, false)
    }

    /// Appends a step; the first one to the identity. Maps are written in place: copies of results took as
    /// long as all else.
    fn add(&mut self, step: &TransformStep, is_first: bool) -> Result<(), TransformError> {
        if let TransformStep::Translate(by) = step {
            return self.translate(*by);
        }
        if is_first || *self == Self::IDENTITY {
            return self.set_step(step);
        }
        let mut map = Self::IDENTITY;
        map.set_step(step)?;
        *self = map.after(self)?;
        Ok(())
    }

    /// Replaces the identity by the map of a step. The inverse is written down, not computed from the
    /// forward map.
    #[inline]
    fn set_step(&mut self, step: &TransformStep) -> Result<(), TransformError> {
        match step {
            TransformStep::Translate(by) => self.translate(*by),
            &TransformStep::Rotate { axis, angle_deg } => {
                let axis = unit_vector(axis).ok_or(TransformError::ZeroAxis)?;
                self.set_rotation(rotation(axis, angle_deg))
            }
            &TransformStep::Orient(quaternion) => {
                let unit = unit_quaternion(quaternion).ok_or(TransformError::ZeroQuaternion)?;
                self.set_rotation(DMat3::from_quat(unit))
            }
            &TransformStep::Scale(factors) => {
                if factors.cmpeq(DVec3::ZERO).any() {
                    return Err(TransformError::ZeroScale);
                }
                let (forward, inverse) =
                    (DAffine3::from_scale(factors), DAffine3::from_scale(factors.recip()));
                *self = Self { forward, inverse }.checked()?;
                Ok(())
            }
            TransformStep::Affine(map) => {
                let leveled = Leveled::of(&map.matrix3);
                let determinant = leveled.determinant;
                if !determinant.is_finite() || determinant.abs() <= SMALLEST_DETERMINANT {
                    return Err(TransformError::Singular);
                }
                *self = Self { forward: **map, inverse: leveled.inverse_of(map) }.checked()?;
                Ok(())
            }
        }
    }

    /// Replaces the identity by a rotation, whose matrix is finite unless its angle is not.
    #[inline]
    fn set_rotation(&mut self, matrix3: DMat3) -> Result<(), TransformError> {
        let sum = matrix3.x_axis + matrix3.y_axis + matrix3.z_axis;
        if !(sum.x + sum.y + sum.z).is_finite() {
            return Err(TransformError::OutOfRange);
        }
        let inverse = matrix3.transpose();
        (self.forward, self.inverse) = (DAffine3::from_mat3(matrix3), DAffine3::from_mat3(inverse));
        Ok(())
    }

    /// Appends a translation. The products with the columns of the identity are left out.
    #[inline]
    fn translate(&mut self, by: DVec3) -> Result<(), TransformError> {
        let (there, back) = (self.forward.translation + by, self.inverse.transform_point3(-by));
        if !there.is_finite() || !back.is_finite() {
            return Err(TransformError::OutOfRange);
        }
        (self.forward.translation, self.inverse.translation) = (there, back);
        Ok(())
    }

    /// `self` applied after `first`.
    ///
    /// # Errors
    /// The composition is not finite, or has collapsed to a singular matrix by underflow.
    #[inline]
    pub fn after(&self, first: &Self) -> Result<Self, TransformError> {
        if *self == Self::IDENTITY {
            return Ok(*first);
        }
        Self { forward: self.forward * first.forward, inverse: first.inverse * self.inverse }.checked()
    }

    /// The map, if both directions are finite and no column is zero.
    #[inline]
    fn checked(self) -> Result<Self, TransformError> {
        let usable = |map: &DAffine3| {
            let columns = [map.matrix3.x_axis, map.matrix3.y_axis, map.matrix3.z_axis];
            map.is_finite() && columns.iter().all(|column| *column != DVec3::ZERO)
        };
        if usable(&self.forward) && usable(&self.inverse) {
            Ok(self)
        } else {
            Err(TransformError::OutOfRange)
        }
    }

    /// World from local.
    pub fn forward(&self) -> &DAffine3 {
        &self.forward
    }

    /// Local from world.
    pub fn inverse(&self) -> &DAffine3 {
        &self.inverse
    }

    /// Takes a local gradient (or normal) to world: by the inverse transpose. The length has no
    /// meaning.
    pub fn normal_to_world(&self, local: DVec3) -> DVec3 {
        self.inverse.matrix3.transpose() * local
    }

    /// A bound on the coordinate error of a world point whose local point `point` is known to
    /// `error` in each coordinate.
    pub fn world_error(&self, point: DVec3, error: f64) -> f64 {
        error_through(&self.forward, point, error)
    }
}

/// Bounds of the entries of a transform and its inverse that follow its steps without composing
/// them: a proof, for nearly all lists of steps, that [`Transform::from_steps`] succeeds.
///
/// ```
/// use superegg_geom::{TransformBound, TransformStep, glam::DVec3};
/// let bound = TransformBound::IDENTITY.after(&TransformStep::Translate(DVec3::X)).unwrap();
/// assert!(bound.largest() >= 1.0 && bound.largest() < 1.01);
/// assert!(bound.after(&TransformStep::Scale(DVec3::new(1.0, 0.0, 1.0))).is_none());
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TransformBound {
    /// Bounds of the factors by which the linear parts of map and inverse stretch a length.
    stretch: [f64; 2],
    /// Bounds of the lengths of the translations of map and inverse.
    offset: [f64; 2],
}

impl TransformBound {
    /// The bounds of the map that moves nothing.
    pub const IDENTITY: Self = Self { stretch: [1.0; 2], offset: [0.0; 2] };

    /// The bounds of a transform.
    pub fn of(transform: &Transform) -> Self {
        let maps = [&transform.forward, &transform.inverse];
        let squared =
            |m: &DMat3| [m.x_axis, m.y_axis, m.z_axis].map(DVec3::length_squared).iter().sum::<f64>();
        Self {
            // The Frobenius norm.
            stretch: maps.map(|map| squared(&map.matrix3).sqrt()),
            offset: maps.map(|map| map.translation.length()),
        }
    }

    /// An upper bound of the absolute entries of map and inverse.
    pub fn largest(&self) -> f64 {
        let [a, b] = self.stretch;
        let [c, d] = self.offset;
        a.max(b).max(c).max(d)
    }

    /// The bounds after another step; `None` if the step cannot be appended for certain.
    #[must_use]
    pub fn after(self, step: &TransformStep) -> Option<Self> {
        /// Products of such bounds neither overflow nor vanish.
        const LARGEST: f64 = 1e100;
        /// More than the rounding errors of a step.
        const EXCESS: f64 = 1.0 + 1e-12;
        let Self { stretch: [there, back], offset: [to, from] } = self;
        let bound = match step {
            TransformStep::Translate(by) => {
                let by = by.length();
                Self { stretch: self.stretch, offset: [to + by, from + back * by] }
            }
            TransformStep::Rotate { axis, angle_deg }
                if axis.is_finite() && angle_deg.is_finite() && *axis != DVec3::ZERO =>
            {
                self
            }
            TransformStep::Orient(quaternion) if unit_quaternion(*quaternion).is_some() => self,
            TransformStep::Scale(factors) if factors.is_finite() => {
                let (most, inverse) = (factors.abs().max_element(), factors.recip().abs().max_element());
                Self { stretch: [there * most, back * inverse], offset: [to * most, from] }
            }
            TransformStep::Rotate { .. }
            | TransformStep::Orient(_)
            | TransformStep::Scale(_)
            | TransformStep::Affine(_) => return None,
        };
        let bound =
            Self { stretch: bound.stretch.map(|x| x * EXCESS), offset: bound.offset.map(|x| x * EXCESS) };
        // False for numbers that are not finite, too.
        let [stretch, offset] = [bound.stretch, bound.offset].map(|pair| pair.iter().all(|x| *x < LARGEST));
        (stretch && offset).then_some(bound)
    }
}

/// A bound on the coordinate error of a point's image, whose own coordinates are known to `error`:
/// the given error, stretched by the map, plus the rounding of the map itself.
#[inline]
pub fn error_through(map: &DAffine3, point: DVec3, error: f64) -> f64 {
    let m = &map.matrix3;
    let row_sums = m.x_axis.abs() + m.y_axis.abs() + m.z_axis.abs();
    let rounding = 4.0 * f64::EPSILON;
    row_sums.max_element() * (error + rounding * point.abs().max_element())
        + rounding * map.translation.abs().max_element()
}

/// The inverse of an affine map, right to rounding of its own entries where the map is a rotation
/// between scales of any size; rows and columns are brought to the same size before anything is
/// subtracted. Not finite for a singular map.
pub fn inverse_of(map: &DAffine3) -> DAffine3 {
    Leveled::of(&map.matrix3).inverse_of(map)
}

/// A matrix with its rows, then its columns scaled to the same size, by powers of two: `leveled =
/// diag(row_scale) matrix diag(column_scale)`.
struct Leveled {
    row_scale: DVec3,
    column_scale: DVec3,
    determinant: f64,
    adjugate: DMat3,
}

impl Leveled {
    fn of(matrix: &DMat3) -> Self {
        let scale = |v: DVec3| scale_to_unit(v).map_or(f64::NAN, |(_, scale)| scale);
        let rows = matrix.transpose();
        let row_scale = DVec3::new(scale(rows.x_axis), scale(rows.y_axis), scale(rows.z_axis));
        let leveled = DMat3::from_diagonal(row_scale) * *matrix;
        let column_scale = DVec3::new(scale(leveled.x_axis), scale(leveled.y_axis), scale(leveled.z_axis));
        let leveled = leveled * DMat3::from_diagonal(column_scale);
        let cross = |a: DVec3, b: DVec3| {
            DVec3::new(
                difference_of_products(a.y, b.z, a.z, b.y),
                difference_of_products(a.z, b.x, a.x, b.z),
                difference_of_products(a.x, b.y, a.y, b.x),
            )
        };
        let (x, y, z) = (leveled.x_axis, leveled.y_axis, leveled.z_axis);
        let of_rows = [cross(y, z), cross(z, x), cross(x, y)];
        let determinant = x.dot(of_rows[0]);
        let adjugate = DMat3::from_cols(of_rows[0], of_rows[1], of_rows[2]).transpose();
        Self { row_scale, column_scale, determinant, adjugate }
    }

    fn inverse_of(&self, map: &DAffine3) -> DAffine3 {
        let column = |v: DVec3, row_scale: f64| self.column_scale * (v / self.determinant) * row_scale;
        let matrix3 = DMat3::from_cols(
            column(self.adjugate.x_axis, self.row_scale.x),
            column(self.adjugate.y_axis, self.row_scale.y),
            column(self.adjugate.z_axis, self.row_scale.z),
        );
        DAffine3 { matrix3, translation: matrix3 * -map.translation }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_step_acts_first() {
        let steps = [TransformStep::Translate(DVec3::X), TransformStep::Scale(DVec3::splat(2.0))];
        let transform = Transform::from_steps(&steps).unwrap();
        assert_eq!(transform.forward().transform_point3(DVec3::ZERO), DVec3::new(2.0, 0.0, 0.0));
        assert_eq!(transform.inverse().transform_point3(DVec3::new(2.0, 0.0, 0.0)), DVec3::ZERO);
    }

    #[test]
    fn rotation_is_right_handed_in_degrees_about_any_length_of_axis() {
        for length in [1e-300, 0.5, 1.0, 1e300] {
            let turn = TransformStep::Rotate { axis: DVec3::Z * length, angle_deg: 90.0 };
            let transform = Transform::from_steps([&turn]).unwrap();
            assert_eq!(transform.forward().transform_point3(DVec3::X), DVec3::Y);
        }
    }

    #[test]
    fn an_inverse_undoes_a_map_of_scales_of_any_size() {
        for (small, large) in [(1.0, 1.0), (1e-100, 1e80), (1e-3, 1e150), (1e-150, 1e-140)] {
            let steps = [
                TransformStep::Scale(DVec3::new(small, large, small)),
                TransformStep::Rotate { axis: DVec3::new(1.0, 2.0, 3.0), angle_deg: 33.0 },
                TransformStep::Translate(DVec3::new(3.0, -4.0, 5.0)),
            ];
            let map = Transform::from_steps(&steps).unwrap();
            let inverse = inverse_of(map.inverse());
            let off = |a: DVec3, b: DVec3| (a - b).length() / b.length();
            let (ours, truth) = (inverse.matrix3, map.forward().matrix3);
            assert!(off(ours.x_axis, truth.x_axis) < 1e-14, "{small} {large}");
            assert!(off(ours.y_axis, truth.y_axis) < 1e-14);
            assert!(off(ours.z_axis, truth.z_axis) < 1e-14);
        }
        assert!(!inverse_of(&DAffine3::from_scale(DVec3::new(1.0, 0.0, 1.0))).is_finite());
    }

    #[test]
    fn what_cannot_be_undone_is_refused() {
        let flat = TransformStep::Scale(DVec3::new(1.0, 0.0, 1.0));
        assert_eq!(Transform::from_steps([&flat]), Err(TransformError::ZeroScale));
        let no_axis = TransformStep::Rotate { axis: DVec3::ZERO, angle_deg: 10.0 };
        assert_eq!(Transform::from_steps([&no_axis]), Err(TransformError::ZeroAxis));
        let small = TransformStep::Scale(DVec3::splat(1e-200));
        assert_eq!(Transform::from_steps([&small, &small]), Err(TransformError::OutOfRange));
        let large = TransformStep::Translate(DVec3::splat(f64::MAX));
        assert_eq!(Transform::from_steps([&large, &large]), Err(TransformError::OutOfRange));
    }

    #[test]
    fn a_quaternion_of_any_length_is_the_rotation_of_its_direction() {
        let about = |axis: DVec3, angle_deg: f64| {
            let half = 0.5 * angle_deg.to_radians();
            let v = axis.normalize() * half.sin();
            DQuat::from_xyzw(v.x, v.y, v.z, half.cos())
        };
        let axis = DVec3::new(1.0, -2.0, 0.5);
        for length in [1e-310, 1e-200, 0.3, 1.0, 1.0 + 6e-7, 7.0, 1e300] {
            for angle_deg in [0.0, 33.0, 90.0, 180.0, 299.0] {
                let step = TransformStep::Orient(about(axis, angle_deg) * length);
                let turned = Transform::from_steps([&step]).unwrap();
                let rotated = Transform::from_steps([&TransformStep::Rotate { axis, angle_deg }]).unwrap();
                let tolerance = if length < 1e-300 { 1e-9 } else { 1e-14 };
                let off = turned.forward().matrix3 - rotated.forward().matrix3;
                assert!(off.abs().to_cols_array().into_iter().all(|x| x < tolerance), "{length} {angle_deg}");
                assert_eq!(turned.inverse().matrix3, turned.forward().matrix3.transpose());
            }
        }
        for bad in [DQuat::from_xyzw(0.0, 0.0, 0.0, 0.0), DQuat::from_xyzw(f64::NAN, 0.0, 0.0, 1.0)] {
            let error = Transform::from_steps([&TransformStep::Orient(bad)]);
            assert_eq!(error, Err(TransformError::ZeroQuaternion));
        }
    }

    #[test]
    fn a_matrix_is_undone_and_a_flat_one_refused() {
        let affine = |rows: [[f64; 4]; 3]| {
            let column = |i: usize| DVec3::new(rows[0][i], rows[1][i], rows[2][i]);
            let matrix3 = DMat3::from_cols(column(0), column(1), column(2));
            TransformStep::Affine(Box::new(DAffine3 { matrix3, translation: column(3) }))
        };
        let sheared = affine([[2.0, 1.0, 0.0, 5.0], [0.0, -1e-9, 3e-10, -7.0], [0.1, 0.0, 4e8, 1e9]]);
        let map = Transform::from_steps([&sheared]).unwrap();
        for point in [DVec3::ZERO, DVec3::new(1.0, -2.0, 3.0), DVec3::splat(1e3)] {
            let back = map.inverse().transform_point3(map.forward().transform_point3(point));
            assert!((back - point).length() < 1e-6 * (1.0 + point.length()), "{back}");
        }
        for flat in [
            [[1.0, 2.0, 3.0, 0.0], [4.0, 5.0, 6.0, 0.0], [7.0, 8.0, 9.0, 0.0]],
            [[0.1, 0.2, 0.3, 0.0], [0.4, 0.5, 0.6, 0.0], [0.7, 0.8, 0.9, 0.0]],
            [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]],
            [[0.0; 4]; 3],
            [[f64::INFINITY, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]],
        ] {
            assert_eq!(Transform::from_steps([&affine(flat)]), Err(TransformError::Singular), "{flat:?}");
        }
        for extreme in [1e-150, 1e-3, 1e150] {
            let scaled =
                affine([[0.0, -extreme, 0.0, 0.0], [extreme, 0.0, 0.0, 0.0], [0.0, 0.0, extreme, 0.0]]);
            assert!(Transform::from_steps([&scaled]).is_ok(), "{extreme}");
        }
    }
}
