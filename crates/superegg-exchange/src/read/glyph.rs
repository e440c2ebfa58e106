//! Tensors as superquadric glyphs (Kindlmann, Superquadric Tensor Glyphs, VisSym 2004).

use superegg_geom::glam::{DMat3, DQuat, DVec3};
use superegg_geom::symmetric_eigen;

/// Kindlmann's gamma: how fast edges sharpen with anisotropy.
pub(super) const GAMMA: f64 = 3.0;
/// The smallest semi-axis of a glyph, in its largest: a tensor with an eigenvalue of 0 has a thin
/// glyph.
pub(super) const THINNEST: f64 = 1e-6;

/// The glyph of one tensor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Glyph {
    /// The semi-axes: the absolute eigenvalues, at least [`THINNEST`] of the largest.
    pub(super) radii: DVec3,
    /// The exponents (e, n), from 0 to 1.
    pub(super) exponents: [f64; 2],
    /// From the glyph to the world.
    pub(super) rotation: DQuat,
    /// An eigenvalue is below 0.
    pub(super) is_negative: bool,
    /// A semi-axis was raised.
    pub(super) is_flat: bool,
}

/// The glyph of a tensor of finite numbers; `None` if all are 0. Unsymmetric tensors count by
/// their symmetric part.
///
/// With eigenvalues l1 >= l2 >= l3, cl = (l1 - l2) / (l1 + l2 + l3) and
/// cp = 2 (l2 - l3) / (l1 + l2 + l3): a linear tensor (cl >= cp) has e = (1 - cp)^3 and
/// n = (1 - cl)^3 about its major axis, a planar one e = (1 - cl)^3 and n = (1 - cp)^3 about its
/// minor axis.
pub(super) fn glyph(tensor: DMat3) -> Option<Glyph> {
    let (values, vectors) = symmetric_eigen(tensor.to_cols_array_2d());
    let mut order = [0, 1, 2];
    order.sort_by(|&a, &b| values[b].abs().total_cmp(&values[a].abs()));
    let [l1, l2, l3] = order.map(|axis| values[axis].abs());
    if l1 == 0.0 {
        return None;
    }
    // Ratios to the largest, so that the sum cannot overflow.
    let (middle, small) = (l2 / l1, l3 / l1);
    let sum = 1.0 + middle + small;
    let linear = (1.0 - middle) / sum;
    let planar = 2.0 * (middle - small) / sum;
    let sharpened = |measure: f64| (1.0 - measure).clamp(0.0, 1.0).powf(GAMMA);
    let (axes, exponents) = if linear >= planar {
        ([order[1], order[2], order[0]], [sharpened(planar), sharpened(linear)])
    } else {
        (order, [sharpened(linear), sharpened(planar)])
    };
    let [x, y, z] = axes.map(|axis| DVec3::from_array(vectors[axis]));
    // A superquadric is its own mirror image, so one axis may be reversed.
    let z = if x.cross(y).dot(z) < 0.0 { -z } else { z };
    let sizes = DVec3::from_array(axes.map(|axis| values[axis].abs()));
    Some(Glyph {
        radii: sizes.max(DVec3::splat(THINNEST * l1)),
        exponents,
        rotation: DQuat::from_mat3(&DMat3::from_cols(x, y, z)).normalize(),
        is_negative: values.iter().any(|value| *value < 0.0),
        is_flat: l3 < THINNEST * l1,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn assert_near(a: f64, b: f64) {
        assert!((a - b).abs() < 1e-12, "{a} {b}");
    }

    /// The tensor whose eigenvalues and eigenvectors are the glyph's.
    fn tensor_of(glyph: &Glyph) -> DMat3 {
        let rotation = DMat3::from_quat(glyph.rotation);
        rotation * DMat3::from_diagonal(glyph.radii) * rotation.transpose()
    }

    #[test]
    fn a_sphere_a_rod_and_a_disc() {
        let sphere = glyph(DMat3::IDENTITY * 2.0).unwrap();
        assert_eq!((sphere.radii, sphere.exponents), (DVec3::splat(2.0), [1.0, 1.0]));
        // Linear: cl = 2/5, cp = 0, the z axis of the glyph along x.
        let rod = glyph(DMat3::from_diagonal(DVec3::new(3.0, 1.0, 1.0))).unwrap();
        assert_near(rod.exponents[0], 1.0);
        assert_near(rod.exponents[1], 0.6f64.powi(3));
        assert_eq!(rod.radii, DVec3::new(1.0, 1.0, 3.0));
        assert_near((rod.rotation * DVec3::Z).dot(DVec3::X).abs(), 1.0);
        // Planar: cl = 0, cp = 2 (3 - 1) / 7, the z axis along y.
        let disc = glyph(DMat3::from_diagonal(DVec3::new(3.0, 1.0, 3.0))).unwrap();
        assert_near(disc.exponents[0], 1.0);
        assert_near(disc.exponents[1], (3.0f64 / 7.0).powi(3));
        assert_eq!(disc.radii, DVec3::new(3.0, 3.0, 1.0));
        assert_near((disc.rotation * DVec3::Z).dot(DVec3::Y).abs(), 1.0);
    }

    #[test]
    fn a_turned_tensor_has_a_turned_glyph() {
        for step in 0..60u32 {
            let turn = DQuat::from_euler(
                superegg_geom::glam::EulerRot::ZYX,
                f64::from(step),
                0.3 * f64::from(step),
                1.1,
            );
            for spectrum in [[5.0, 2.0, 1.0], [5.0, 4.0, 1.0], [1.0, 7.0, 3.0]] {
                let rotation = DMat3::from_quat(turn);
                let tensor =
                    rotation * DMat3::from_diagonal(DVec3::from_array(spectrum)) * rotation.transpose();
                let found = glyph(tensor).unwrap();
                assert!(tensor_of(&found).abs_diff_eq(tensor, 1e-13), "{found:?}");
                assert!(found.exponents.iter().all(|exponent| (0.0..=1.0).contains(exponent)));
            }
        }
    }

    #[test]
    fn negative_flat_and_zero_tensors() {
        let negative = glyph(DMat3::from_diagonal(DVec3::new(-3.0, 1.0, 1.0))).unwrap();
        assert!(negative.is_negative && !negative.is_flat);
        assert_eq!(negative.radii, DVec3::new(1.0, 1.0, 3.0));
        let needle = glyph(DMat3::from_diagonal(DVec3::new(0.0, 0.0, 4.0))).unwrap();
        assert!(needle.is_flat);
        assert_eq!(needle.radii, DVec3::new(4e-6, 4e-6, 4.0));
        assert_eq!(needle.exponents, [1.0, 0.0]);
        assert_eq!(glyph(DMat3::ZERO), None);
        let huge = glyph(DMat3::IDENTITY * 1e308).unwrap();
        assert_eq!(huge.exponents, [1.0, 1.0]);
    }
}
