//! Instances as superquadrics with a rotation and a position.

use superegg_geom::glam::{DAffine3, DMat3, DQuat, DVec3};
use superegg_geom::{Superquadric, unit_vector};

/// A superquadric that is turned and moved, in the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rigid {
    /// The semi-axes.
    pub radii: DVec3,
    /// The rotation from the shape's space.
    pub rotation: DQuat,
    /// The centre.
    pub position: DVec3,
}

/// Axes whose cosine is below this are perpendicular; equal scales differ by no more, as a part.
const PERPENDICULAR: f64 = 1e-9;

impl Rigid {
    /// An instance's image as a superquadric: a scale along the shape's own axes becomes part of its
    /// semi-axes. `None` if the map shears it: its axes are not perpendicular any more.
    pub fn of(shape: &Superquadric, map: &DAffine3) -> Option<Self> {
        let linear = &map.matrix3;
        let columns = [linear.x_axis, linear.y_axis, linear.z_axis];
        let lengths = DVec3::from_array(columns.map(DVec3::length));
        let [x, y, z] = columns.map(|column| unit_vector(column).unwrap_or(DVec3::X));
        let largest = x.dot(y).abs().max(y.dot(z).abs()).max(z.dot(x).abs());
        if largest > PERPENDICULAR {
            return None;
        }
        // Right-handed, whatever the signs of the scales: the shape is its own mirror image.
        let rotation = DMat3::from_cols(x, y, x.cross(y).normalize());
        let rotation = DQuat::from_mat3(&rotation).normalize();
        // Rotations leave rounding in the lengths; equal ones stay equal.
        let largest = lengths.max_element();
        let scale = lengths.map(|length| {
            if (length - largest).abs() <= PERPENDICULAR * largest { largest } else { length }
        });
        let scale = scale.map(|s| if (s - 1.0).abs() <= 8.0 * f64::EPSILON { 1.0 } else { s });
        Some(Self { radii: shape.radii() * scale, rotation, position: map.translation })
    }

    /// The rotation as w, x, y, z with w >= 0.
    pub fn quaternion(&self) -> [f64; 4] {
        let q = self.rotation;
        let sign = if q.w < 0.0 { -1.0 } else { 1.0 };
        [q.w, q.x, q.y, q.z].map(|x| sign * x + 0.0)
    }
}

#[cfg(test)]
mod tests {
    use superegg_geom::{Exponents, Transform, TransformStep};

    use super::*;

    #[test]
    fn scales_along_own_axes_fold_and_shear_does_not() {
        let shape = Superquadric::new(DVec3::new(1.0, 2.0, 3.0), Exponents::ROUND).unwrap();
        let turn = TransformStep::Rotate { axis: DVec3::new(1.0, 2.0, -0.5), angle_deg: 77.0 };
        let scale = TransformStep::Scale(DVec3::new(2.0, -1.0, 0.5));
        let folded = Transform::from_steps(&[scale, turn]).unwrap();
        let rigid = Rigid::of(&shape, folded.forward()).unwrap();
        assert!((rigid.radii - DVec3::new(2.0, 2.0, 1.5)).length() < 1e-12);
        // The same points, up to the shape's symmetry.
        for point in [DVec3::X, DVec3::Y, DVec3::Z] {
            let exact = folded.forward().transform_vector3(point);
            let ours = rigid.rotation * (point * rigid.radii / shape.radii());
            assert!((exact - ours).length().min((exact + ours).length()) < 1e-12);
        }
        let sheared = Transform::from_steps(&[turn, scale]).unwrap();
        assert_eq!(Rigid::of(&shape, sheared.forward()), None);
    }
}
