//! Images of shapes under affine maps: area, even samples, closest points, and even samples of the inside.

use superegg_geom::glam::{DAffine3, DMat3, DVec3};
use superegg_geom::{Exponents, ImageSampler, InteriorSampler, SearchLimits, Superquadric};

const EXPONENTS: [(f64, f64); 7] =
    [(1.0, 1.0), (0.1, 0.2), (0.001, 1.0), (2.0, 1.0), (0.5, 2.5), (3.0, 3.0), (8.0, 0.7)];

fn shape(e: f64, n: f64) -> Superquadric {
    Superquadric::new(DVec3::new(1.0, 0.6, 0.8), Exponents::new(e, n).unwrap()).unwrap()
}

fn shear() -> DMat3 {
    DMat3::from_cols(DVec3::new(1.0, 0.2, -0.3), DVec3::new(0.5, 1.3, 0.1), DVec3::new(0.0, -0.4, 0.7))
}

fn turned() -> DMat3 {
    DMat3::from_rotation_z(0.7)
        * DMat3::from_rotation_x(-0.4)
        * DMat3::from_diagonal(DVec3::new(0.5, -2.0, 1.0))
}

/// The area of the image as the mean growth over even samples of the shape: Nanson's formula.
fn sampled_area(shape: &Superquadric, linear: &DMat3) -> (f64, f64) {
    let inverse_transpose = linear.inverse().transpose();
    let growths: Vec<f64> = shape
        .sample_surface(40_000, 5)
        .iter()
        .map(|sample| linear.determinant().abs() * (inverse_transpose * sample.normal).length())
        .collect();
    let count = growths.len() as f64;
    let mean = growths.iter().sum::<f64>() / count;
    let variance = growths.iter().map(|growth| (growth - mean).powi(2)).sum::<f64>() / count;
    let area = shape.surface_area();
    (area * mean, area * (variance / count).sqrt())
}

#[test]
fn the_area_of_an_image_is_that_of_its_samples() {
    for (e, n) in EXPONENTS {
        let shape = shape(e, n);
        for linear in [shear(), turned(), shear() * 1e-3] {
            let area = shape.surface_area_under(&linear).unwrap();
            let (sampled, error) = sampled_area(&shape, &linear);
            assert!(
                (area.value - sampled).abs() < 5.0 * error + 1e-9 * area.value,
                "{e} {n}: {area:?} {sampled}"
            );
            assert!(area.relative_error < 1e-9, "{e} {n}: {area:?}");
        }
        // A shear that is hardly one, against the closed way of a rotation.
        let nearly = turned() + DMat3::from_diagonal(DVec3::splat(1e-11)) * 0.1;
        let (near, straight) =
            (shape.surface_area_under(&nearly).unwrap(), shape.surface_area_under(&turned()).unwrap());
        assert!((near.value / straight.value - 1.0).abs() < 1e-9, "{e} {n}: {near:?} {straight:?}");
    }
    let flat = DMat3::from_cols(DVec3::X, DVec3::X, DVec3::Z);
    assert_eq!(shape(1.0, 1.0).surface_area_under(&flat), None);
}

/// A sheared box has faces that are parallelograms.
#[test]
fn the_area_of_a_sheared_box_is_that_of_its_faces() {
    let cube = Superquadric::unit(Exponents::new(1e-9, 1e-9).unwrap());
    let DMat3 { x_axis: x, y_axis: y, z_axis: z } = shear();
    let faces = 8.0 * (x.cross(y).length() + y.cross(z).length() + z.cross(x).length());
    let area = cube.surface_area_under(&shear()).unwrap();
    assert!((area.value / faces - 1.0).abs() < 1e-7, "{area:?} {faces}");
}

#[test]
fn samples_of_an_image_lie_on_it_evenly_with_its_normals() {
    for (e, n) in EXPONENTS {
        let shape = shape(e, n);
        for linear in [shear(), turned()] {
            let map = DAffine3::from_mat3_translation(linear, DVec3::new(3.0, -1.0, 2.0));
            let count = 20_000;
            let points: Vec<_> = ImageSampler::new(&shape, &map, 9).unwrap().take(count).collect();
            let inverse = map.inverse();
            let mut left = 0.0;
            for sample in &points {
                let local = inverse.transform_point3(sample.point);
                left += f64::from(u8::from(local.x < 0.5 * local.y));
                assert!((sample.normal.length() - 1.0).abs() < 1e-12);
                if e > 3.0 {
                    // The rounding of the map is more than the width of the spikes.
                    continue;
                }
                assert!((shape.norm().value(local / shape.radii()) - 1.0).abs() < 1e-9, "{e} {n}");
                let expected = inverse.matrix3.transpose() * shape.normal(local);
                assert!(sample.normal.dot(expected.normalize()) > 1.0 - 1e-6, "{e} {n}");
            }
            // Half of the image, and the parts of a cut that is no symmetry against Nanson's formula.
            assert!((left / count as f64 - 0.5).abs() < 5.0 * 0.5 / (count as f64).sqrt(), "{e} {n}: {left}");
            let inverse_transpose = linear.inverse().transpose();
            let (mut high, mut all) = (0.0, 0.0);
            for sample in shape.sample_surface(count, 11) {
                let growth = (inverse_transpose * sample.normal).length();
                all += growth;
                high += if sample.point.z.abs() > 0.4 { growth } else { 0.0 };
            }
            let drawn = points.iter().filter(|p| inverse.transform_point3(p.point).z.abs() > 0.4).count();
            assert!(
                (drawn as f64 / count as f64 - high / all).abs() < 0.03,
                "{e} {n}: {drawn} {}",
                high / all
            );
        }
    }
}

#[test]
fn samples_of_the_inside_have_the_moments_of_the_shape() {
    for (e, n) in EXPONENTS {
        let shape = shape(e, n);
        let count = 50_000;
        let mut second = DVec3::ZERO;
        let mut fourth = DVec3::ZERO;
        let mut below_half = 0u32;
        for point in InteriorSampler::new(&shape, 4).take(count) {
            let norm = shape.norm().value(point / shape.radii());
            assert!(norm <= 1.0 + 1e-9, "{e} {n}: {point}");
            below_half += u32::from(norm < 0.5);
            second += point * point;
            fourth += (point * point) * (point * point);
        }
        let count = count as f64;
        let (mean, expected) = (second / count, shape.second_moments() / shape.volume());
        let error = ((fourth / count - mean * mean) / count).max(DVec3::ZERO).map(f64::sqrt);
        assert!(((mean - expected).abs() - 5.0 * error).max_element() < 1e-12, "{e} {n}: {mean} {expected}");
        assert!((f64::from(below_half) / count - 0.125).abs() < 0.01);
    }
}

/// Under any map the closest point is on the image, no sampled point of the surface is closer, and the proven error
/// covers the difference.
#[test]
fn the_closest_point_of_an_image_is_that_of_its_points() {
    let limits = SearchLimits::default();
    for matrix in [shear(), turned(), DMat3::IDENTITY] {
        let map = DAffine3::from_mat3_translation(matrix, DVec3::new(1.0, -2.0, 0.5));
        for (e, n) in [(1.0, 1.0), (0.2, 0.3), (2.0, 1.0), (3.0, 2.5)] {
            let shape = shape(e, n);
            let surface: Vec<DVec3> = shape
                .sample_surface(20_000, 3)
                .iter()
                .map(|sample| map.transform_point3(sample.point))
                .collect();
            for at in [DVec3::new(3.0, 1.0, 0.0), DVec3::new(1.1, -2.1, 0.6), DVec3::new(-1.0, -4.0, 2.0)] {
                let closest = shape.closest_point_under(&map, at, &limits).unwrap();
                let on_shape = map.inverse().transform_point3(closest.point) / shape.radii();
                assert!((shape.norm().value(on_shape) - 1.0).abs() < 1e-9);
                assert!(((closest.point - at).length() - closest.distance.abs()).abs() < 1e-12);
                let sampled = surface.iter().map(|p| (*p - at).length()).fold(f64::INFINITY, f64::min);
                assert!(closest.distance.abs() - closest.error <= sampled, "{closest:?} {sampled}");
                assert!(closest.distance.abs() > sampled - 0.1, "{closest:?} {sampled}");
                let inside = shape.norm().value(map.inverse().transform_point3(at) / shape.radii()) < 1.0;
                assert_eq!(closest.distance < 0.0, inside);
            }
        }
    }
    let flat = DAffine3::from_mat3(DMat3::from_cols(DVec3::X, DVec3::X, DVec3::Z));
    assert_eq!(shape(1.0, 1.0).closest_point_under(&flat, DVec3::ONE, &limits), None);
}
