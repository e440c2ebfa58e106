//! Instances as superquadrics with a rotation and a position.

use superegg_geom::glam::{DAffine3, DMat3, DQuat, DVec3};
use superegg_geom::{Exponents, Superquadric, unit_vector};

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
    /// semi-axes. `None` if the map shears it: its axes are not perpendicular any more. An ellipsoid
    /// is one under any map.
    pub fn of(shape: &Superquadric, map: &DAffine3) -> Option<Self> {
        Self::folded(shape, map).or_else(|| {
            (shape.exponents() == Exponents::ROUND).then(|| {
                let linear = map.matrix3 * DMat3::from_diagonal(shape.radii());
                let axes = principal_axes(&linear);
                let orthogonal = DAffine3 { matrix3: axes, translation: map.translation };
                Self::folded(&Superquadric::unit_sphere(), &orthogonal)
            })?
        })
    }

    fn folded(shape: &Superquadric, map: &DAffine3) -> Option<Self> {
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
        let scale = lengths
            .map(|length| if (length - largest).abs() <= PERPENDICULAR * largest { largest } else { length });
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

/// The semi-axes, as vectors, of the image of the unit sphere: `linear * V` for a rotation V that
/// makes its columns perpendicular (one-sided Jacobi; Hestenes 1958).
fn principal_axes(linear: &DMat3) -> DMat3 {
    const SWEEPS: usize = 40;
    let scale = linear.to_cols_array().iter().fold(0.0, |most: f64, x| most.max(x.abs()));
    let mut columns = [linear.x_axis / scale, linear.y_axis / scale, linear.z_axis / scale];
    for _ in 0..SWEEPS {
        for (p, q) in [(0, 1), (1, 2), (2, 0)] {
            let (a, b) = (columns[p], columns[q]);
            let product = a.dot(b);
            if product == 0.0 {
                continue;
            }
            let zeta = (b.length_squared() - a.length_squared()) / (2.0 * product);
            let t = zeta.signum() / (zeta.abs() + zeta.hypot(1.0));
            let cos = t.hypot(1.0).recip();
            columns[p] = cos * (a - t * b);
            columns[q] = cos * (t * a + b);
        }
    }
    DMat3::from_cols(columns[0], columns[1], columns[2]) * scale
}

#[cfg(test)]
mod tests {
    use superegg_geom::{Transform, TransformStep};

    use super::*;

    #[test]
    fn scales_along_own_axes_fold_and_shear_does_not() {
        let shape = Superquadric::new(DVec3::new(1.0, 2.0, 3.0), Exponents::new(0.5, 1.0).unwrap()).unwrap();
        let turn = TransformStep::Rotate { axis: DVec3::new(1.0, 2.0, -0.5), angle_deg: 77.0 };
        let scale = TransformStep::Scale(DVec3::new(2.0, -1.0, 0.5));
        let folded = Transform::from_steps(&[scale.clone(), turn.clone()]).unwrap();
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
        let ellipsoid = Superquadric::new(shape.radii(), Exponents::ROUND).unwrap();
        let rigid = Rigid::of(&ellipsoid, sheared.forward()).unwrap();
        let unit = Superquadric::unit_sphere();
        for point in unit.sample_surface(100, 1) {
            let image = sheared.forward().transform_point3(point.point * shape.radii());
            let back = rigid.rotation.inverse() * (image - rigid.position) / rigid.radii;
            assert!((back.length() - 1.0).abs() < 1e-12, "{back}");
        }
    }
}
