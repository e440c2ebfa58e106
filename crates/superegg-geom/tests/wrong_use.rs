//! Wrong use of the library is refused. Uses that do not compile are in the doc tests of
//! `Exponents` and `Convex`.

use superegg_geom::glam::DVec3;
use superegg_geom::{BatchError, Exponents, HitBatch, Ray, RayBatch, RayStart, ShapeError, Superquadric};

#[test]
fn exponents_that_no_shape_has_are_refused() {
    for invalid in [0.0, -0.0, -1.0, f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        // An exponent of 0 is the limit: a box or a cylinder.
        let expected = if invalid == 0.0 { None } else { Some(ShapeError::Exponent) };
        assert_eq!(Exponents::new(invalid, 1.0).err(), expected, "{invalid}");
        assert_eq!(Exponents::new(1.0, invalid).err(), expected, "{invalid}");
        let radii = DVec3::new(1.0, invalid, 1.0);
        assert_eq!(Superquadric::new(radii, Exponents::ROUND), Err(ShapeError::Radius), "{invalid}");
    }
    // Far beyond 8 a shape is its axes, without an inside for a ray to enter.
    assert!(Exponents::new(f64::MAX, f64::MAX).is_ok());
    for valid in [0.0, 5e-324, 1e-300, 8.0] {
        let shape = Superquadric::unit(Exponents::new(valid, valid).unwrap());
        let ray = Ray::new(DVec3::new(0.0, 0.0, 3.0), DVec3::NEG_Z);
        assert_eq!(shape.intersect(&ray, RayStart::Free).map(|hit| hit.t), Some(2.0), "{valid}");
    }
}

/// A batch of rays belongs to no shape: each query prepares it for its own.
#[test]
fn a_batch_has_the_answers_of_the_shape_it_is_traced_with() {
    let (origins, directions) = ([[0.1, 0.2, 5.0]; 3], [[0.0, 0.0, -1.0]; 3]);
    let rays = RayBatch::new(&origins, &directions).unwrap();
    let mut hits = HitBatch::new();
    for size in [1.0, 2.0] {
        let sphere = Superquadric::new(DVec3::splat(size), Exponents::ROUND).unwrap();
        sphere.intersect_batch(&rays, &mut hits);
        let expected = 5.0 - (size * size - 0.05).sqrt();
        assert!(hits.t().iter().all(|t| (t - expected).abs() < 1e-12), "{size}: {hits:?}");
    }
}

#[test]
fn hits_are_read_only_where_rays_were_traced() {
    let (origins, directions) = ([[0.0, 0.0, 5.0]; 2], [[0.0, 0.0, -1.0]; 2]);
    let rays = RayBatch::new(&origins, &directions).unwrap();
    let mut hits = HitBatch::new();
    assert_eq!(hits.hit(0), None);
    Superquadric::unit_sphere().intersect_batch(&rays, &mut hits);
    assert!(hits.hit(1).is_some());
    for outside in [2, 99, usize::MAX] {
        assert_eq!((hits.hit(outside), rays.ray(outside), rays.range(outside)), (None, None, None));
    }
    hits.clear();
    assert_eq!((hits.hit(0), hits.len()), (None, 0));
}

#[test]
fn columns_of_different_lengths_make_no_batch() {
    let error = RayBatch::new(&[[0.0; 3]; 3], &[[1.0; 3]; 2]).unwrap_err();
    assert_eq!(error, BatchError::Length { column: "directions", expected: 3, found: 2 });
    assert_eq!(error.to_string(), "expected 3 entries in the column directions, found 2");
}

#[test]
fn a_star_is_not_convex() {
    let star = Superquadric::unit(Exponents::new(3.0, 3.0).unwrap());
    assert!(star.as_convex().is_none());
    let (origins, directions) = ([[0.3, 0.2, 5.0]; 1], [[-0.03, -0.02, -1.0]; 1]);
    let rays = RayBatch::new(&origins, &directions).unwrap();
    let mut hits = HitBatch::new();
    star.intersect_batch(&rays, &mut hits);
    let truth = star.intersect_certified(&rays.ray(0).unwrap(), RayStart::Free);
    assert_eq!(hits.hit(0).map(|hit| hit.t), truth.map(|hit| hit.t));
    assert!(truth.is_some());
}
