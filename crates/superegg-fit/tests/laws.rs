//! Laws of fits: what must not change them, and bad input.

mod common;

use common::{Faults, Placed, random_rotation};
use superegg_fit::{Fit, FitError, FitOptions, FitWarning, fit};
use superegg_geom::glam::{DQuat, DVec3};
use superegg_geom::{Exponents, SplitMix, Superquadric};

const FAULTS: Faults = Faults { noise: 0.01, outliers: 0.2, is_half: false };

fn fitted(points: &[DVec3]) -> Fit {
    fit(points, &FitOptions::default()).unwrap()
}

/// Checks that a fit is another one after a rotation, a scale and a shift.
fn assert_moved(moved: &Fit, from: &Fit, rotation: DQuat, scale: f64, shift: DVec3, tolerance: f64) {
    let expected = Placed {
        shape: Superquadric::new(scale * from.shape.radii(), from.shape.exponents()).unwrap(),
        rotation: rotation * from.rotation,
        center: scale * (rotation * from.center) + shift,
    };
    let error = expected.error_of(moved);
    assert!(error < tolerance, "{error}: {moved:?} {expected:?}");
    assert!((moved.noise / (scale * from.noise) - 1.0).abs() < 100.0 * tolerance);
    assert!((moved.outliers - from.outliers).abs() < 100.0 * tolerance);
}

#[test]
fn fits_move_with_their_points() {
    let mut random = SplitMix::new(11);
    for _ in 0..12 {
        let cloud = Placed::random(&mut random).cloud(600, FAULTS, &mut random);
        let found = fitted(&cloud);
        let rotation = random_rotation(&mut random);
        for (scale, shift, tolerance) in [
            (1.0, DVec3::ZERO, 1e-4),
            (1e-3, DVec3::ZERO, 1e-4),
            (1e90, DVec3::ZERO, 1e-4),
            (1e-90, DVec3::ZERO, 1e-4),
            (1000.0, DVec3::new(1e6, -2e7, 3.0), 1e-4),
            (1.0, DVec3::splat(1e9), 1e-3),
        ] {
            let moved: Vec<DVec3> = cloud.iter().map(|point| scale * (rotation * *point) + shift).collect();
            assert_moved(&fitted(&moved), &found, rotation, scale, shift, tolerance);
        }
    }
}

#[test]
fn the_order_of_points_does_not_matter() {
    let mut random = SplitMix::new(12);
    let cloud = Placed::random(&mut random).cloud(700, FAULTS, &mut random);
    let found = fitted(&cloud);
    let mut other = cloud.clone();
    other.reverse();
    other.rotate_left(123);
    assert_eq!(fitted(&other), found);
    assert_eq!(fitted(&cloud), found);
}

#[test]
fn large_clouds_are_thinned() {
    let mut random = SplitMix::new(13);
    let placed = Placed::random(&mut random);
    let cloud = placed.cloud(30_000, FAULTS, &mut random);
    let options = FitOptions { most_points: 3000, ..FitOptions::default() };
    let found = fit(&cloud, &options).unwrap();
    assert_eq!(found.used, 3000);
    assert!(placed.error_of(&found) < 0.01);
    assert_eq!(found.residuals(&cloud).distances.len(), cloud.len());
}

#[test]
fn residuals_are_distances_and_mark_outliers() {
    let mut random = SplitMix::new(14);
    let placed = Placed::random(&mut random);
    let mut cloud = placed.cloud(1000, Faults { noise: 0.01, ..Faults::default() }, &mut random);
    let far = placed.center + DVec3::new(0.0, 0.0, 50.0);
    cloud.extend([far, placed.center]);
    let found = fitted(&cloud);
    let residuals = found.residuals(&cloud);
    assert!((residuals.rms() / (0.01 * placed.size()) - 1.0).abs() < 0.1);
    assert!(residuals.hausdorff() < 0.06 * placed.size());
    assert!(residuals.inliers[1000] < 1e-6 && residuals.inliers[1001] < 1e-6);
    let own = found.rotation.inverse() * (far - found.center);
    let exact = found.shape.closest_point(own).unwrap().distance;
    assert!((residuals.distances[1000] - exact).abs() < 1e-4 * exact && residuals.distances[1001] < 0.0);
}

#[test]
fn bad_points_are_errors() {
    let options = FitOptions::default();
    let sphere: Vec<DVec3> =
        Superquadric::unit_sphere().sample_surface(100, 1).iter().map(|at| at.point).collect();
    let count = |count, distinct| Err(FitError::TooFewPoints { count, distinct });
    assert_eq!(fit(&[], &options), count(0, 0));
    assert_eq!(fit(&sphere[..11], &options), count(11, 11));
    assert_eq!(fit(&[DVec3::ONE; 500], &options), count(500, 1));
    let mut wrong = sphere.clone();
    wrong[7].y = f64::NAN;
    assert_eq!(fit(&wrong, &options), Err(FitError::NotFinite { index: 7 }));
    let huge: Vec<DVec3> = sphere.iter().map(|point| 1e307 * *point).collect();
    assert!(matches!(fit(&huge, &options), Err(FitError::Scale { .. })));
    let along = |direction: DVec3, other: DVec3| -> Vec<DVec3> {
        sphere.iter().map(|point| 5.0 * other + point.x * direction + point.y * other).collect()
    };
    let (first, second) = (DVec3::new(1.0, 2.0, -0.3), DVec3::new(0.2, 0.1, 0.7));
    assert_eq!(fit(&along(first, second), &options), Err(FitError::OnPlane));
    assert_eq!(fit(&along(first, 2.0 * first), &options), Err(FitError::OnLine));
    for options in [
        FitOptions { outliers: 1.0, ..options },
        FitOptions { outliers: f64::NAN, ..options },
        FitOptions { exponents: [1.0, 1.0], ..options },
        FitOptions { exponents: [-1.0, 1.0], ..options },
        FitOptions { exponents: [0.1, f64::NAN], ..options },
        FitOptions { most_points: 3, ..options },
    ] {
        assert!(matches!(fit(&sphere, &options), Err(FitError::Option(_))), "{options:?}");
    }
}

/// Clouds that are hostile but finite have an answer without nan.
#[test]
fn strange_clouds_have_finite_fits() {
    let mut random = SplitMix::new(15);
    let mut even = || DVec3::new(random.unit(), random.unit(), random.unit());
    let mut clouds: Vec<Vec<DVec3>> = vec![
        (0..12).map(|_| even()).collect(),
        (0..500).map(|_| even()).collect(),
        (0..500).map(|i| even() * DVec3::new(1.0, 1.0, 1e-7) + f64::from(i % 2)).collect(),
        (0..500).map(|_| even() * DVec3::new(1.0, 1e-6, 1e-7)).collect(),
        (0..300).map(|_| (4.0 * even()).floor()).collect(),
        (0..300).map(|i| if i < 30 { even() } else { DVec3::splat(0.5) }).collect(),
        (0..300).map(|i| if i == 7 { DVec3::splat(1e200) } else { even() }).collect(),
    ];
    let flat = Superquadric::new(DVec3::new(1.0, 1.0, 1e-4), Exponents::new(0.1, 0.1).unwrap()).unwrap();
    clouds.push(flat.sample_surface(500, 1).iter().map(|at| at.point).collect());
    for cloud in clouds {
        match fit(&cloud, &FitOptions::default()) {
            Ok(found) => {
                let residuals = found.residuals(&cloud);
                let numbers = residuals.distances.iter().chain(&residuals.inliers);
                let numbers = numbers.chain(found.covariance.iter().flatten());
                assert!(
                    numbers.chain([&found.noise, &found.surface_error]).all(|x| x.is_finite()),
                    "{found:?}"
                );
                assert!(found.center.is_finite() && found.rotation.is_finite());
            }
            Err(error) => assert!(!error.to_string().is_empty()),
        }
    }
}

#[test]
fn what_the_points_leave_open_is_said() {
    let cloud = |radii: DVec3, e: f64, n: f64| -> Vec<DVec3> {
        let shape = Superquadric::new(radii, Exponents::new(e, n).unwrap()).unwrap();
        let mut random = SplitMix::new(3);
        let placed = Placed { shape, rotation: DQuat::IDENTITY, center: DVec3::ONE };
        placed.cloud(800, Faults { noise: 0.01, ..Faults::default() }, &mut random)
    };
    let turnable = |found: &Fit| {
        found.warnings.iter().filter(|warning| matches!(warning, FitWarning::Turnable { .. })).count()
    };
    assert!(fitted(&cloud(DVec3::new(1.0, 2.0, 3.0), 0.5, 0.5)).warnings.is_empty());
    let can = fitted(&cloud(DVec3::new(1.0, 1.0, 3.0), 1.0, 0.3));
    assert_eq!(turnable(&can), 1, "{can:?} {:?}", can.standard_errors());
    assert!(turnable(&fitted(&cloud(DVec3::ONE, 1.0, 1.0))) >= 2);
    let top: Vec<DVec3> =
        cloud(DVec3::new(1.0, 2.0, 3.0), 1.0, 1.0).into_iter().filter(|point| point.z > 3.4).collect();
    let warnings = fitted(&top).warnings;
    assert!(warnings.iter().any(|warning| matches!(warning, FitWarning::Uncertain { .. })), "{warnings:?}");
}

#[test]
fn another_shape_that_fits_as_well_is_a_warning() {
    let faults = Faults { noise: 0.02, outliers: 0.4, is_half: true };
    let mut count = 0;
    for seed in 0..60 {
        let mut random = SplitMix::new(seed);
        let cloud = Placed::random(&mut random).cloud(1000, faults, &mut random);
        let found = fitted(&cloud);
        for warning in &found.warnings {
            let FitWarning::Ambiguous { relative_distance, other, rotation, center } = *warning else {
                continue;
            };
            count += 1;
            assert!(relative_distance > 0.02);
            let rival = Placed { shape: other, rotation, center };
            let near = 3.0 * found.noise;
            let share_near = |placed: &Placed| {
                let is_near = |point: &&DVec3| placed.distance_of(**point) < near;
                cloud.iter().filter(is_near).count() as f64 / cloud.len() as f64
            };
            let shares = [Placed::of(&found), rival].map(|placed| share_near(&placed));
            assert!((shares[0] - shares[1]).abs() < 0.03, "{seed} {shares:?} {found:?}");
            assert!(rival.error_of(&found) > 0.005, "{seed}");
        }
    }
    assert!(count > 0);
}
