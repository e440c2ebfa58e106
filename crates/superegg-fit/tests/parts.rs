//! Clouds of several shapes.

mod common;

use common::{Faults, Placed};
use superegg_fit::{FitError, FitOptions, PartCount, fit_parts, fit_parts_while};
use superegg_geom::glam::{DQuat, DVec3};
use superegg_geom::{Exponents, SplitMix, Superquadric};

fn placed(radii: [f64; 3], exponents: [f64; 2], center: [f64; 3]) -> Placed {
    let shape = Superquadric::new(radii.into(), Exponents::new(exponents[0], exponents[1]).unwrap()).unwrap();
    Placed { shape, rotation: DQuat::from_rotation_z(0.3), center: center.into() }
}

/// Even points of all shapes, those inside of another shape left out, with noise and outliers.
fn cloud(shapes: &[Placed], count: usize, noise: f64, outliers: f64) -> Vec<DVec3> {
    let mut random = SplitMix::new(9);
    let total: f64 = shapes.iter().map(|placed| placed.shape.surface_area()).sum();
    let mut points = Vec::new();
    for placed in shapes {
        let share = (count as f64 * placed.shape.surface_area() / total) as usize;
        let faults = Faults { noise: noise / placed.size(), ..Faults::default() };
        let is_covered = |point: &DVec3| {
            shapes.iter().any(|other| {
                let own = other.rotation.inverse() * (*point - other.center);
                !std::ptr::eq(other, placed) && other.shape.inside_outside(own) < 0.0
            })
        };
        points.extend(placed.cloud(share, faults, &mut random).iter().filter(|point| !is_covered(point)));
    }
    let (low, high) =
        points.iter().fold((points[0], points[0]), |(low, high), p: &DVec3| (low.min(*p), high.max(*p)));
    for _ in 0..(outliers * count as f64) as usize {
        points.push(low + (high - low) * DVec3::new(random.unit(), random.unit(), random.unit()));
    }
    points
}

/// Checks that each shape is one of the parts.
fn assert_found(shapes: &[Placed], points: &[DVec3], count: PartCount, tolerance: f64) {
    let parts = fit_parts(points, &FitOptions::default(), count).unwrap();
    let errors: Vec<f64> = shapes
        .iter()
        .map(|shape| parts.iter().map(|part| shape.error_of(part)).fold(f64::INFINITY, f64::min))
        .collect();
    assert_eq!(parts.len(), shapes.len(), "{errors:?} {parts:?}");
    assert!(errors.iter().all(|error| *error < tolerance), "{errors:?} {parts:?}");
    for part in &parts {
        assert!(part.noise < 0.5 * Placed::of(part).size(), "{part:?}");
    }
}

fn apart() -> [Placed; 3] {
    [
        placed([1.0, 1.0, 1.0], [1.0, 1.0], [0.0, 0.0, 0.0]),
        placed([0.5, 0.7, 2.0], [0.2, 0.2], [3.5, 0.0, 0.0]),
        placed([1.2, 0.4, 0.8], [1.0, 0.3], [0.0, 4.0, 1.0]),
    ]
}

#[test]
fn shapes_apart_are_found() {
    let shapes = apart();
    let points = cloud(&shapes, 3000, 0.01, 0.0);
    assert_found(&shapes, &points, PartCount::Auto, 0.02);
    assert_found(&shapes, &points, PartCount::Exactly(3), 0.02);
}

#[test]
fn shapes_with_outliers_are_found() {
    let shapes = apart();
    assert_found(&shapes, &cloud(&shapes, 3000, 0.01, 0.1), PartCount::Auto, 0.03);
}

#[test]
fn one_shape_is_one_part() {
    let one = [placed([1.0, 2.0, 1.5], [0.3, 1.4], [0.0; 3])];
    assert_found(&one, &cloud(&one, 1500, 0.01, 0.1), PartCount::Auto, 0.02);
}

/// A table: a board on four legs.
#[test]
fn parts_that_touch_are_found() {
    let leg = |x: f64, y: f64| {
        let turned = DQuat::from_rotation_z(0.3) * DVec3::new(x, y, -1.1);
        placed([0.12, 0.12, 1.0], [1.0, 0.1], turned.to_array())
    };
    let board = placed([1.5, 1.0, 0.1], [0.1, 0.1], [0.0; 3]);
    let shapes = [board, leg(1.2, 0.7), leg(-1.2, 0.7), leg(1.2, -0.7), leg(-1.2, -0.7)];
    assert_found(&shapes, &cloud(&shapes, 5000, 0.004, 0.0), PartCount::Auto, 0.1);
}

#[test]
fn the_number_of_parts_is_kept_and_the_same_for_a_seed() {
    let points = cloud(&apart(), 2000, 0.01, 0.0);
    let parts = |count| fit_parts(&points, &FitOptions::default(), PartCount::Exactly(count));
    assert_eq!([parts(1).unwrap().len(), parts(2).unwrap().len()], [1, 2]);
    let mut other = points.clone();
    other.reverse();
    let same = fit_parts(&other, &FitOptions::default(), PartCount::Exactly(2));
    assert_eq!(same.unwrap(), parts(2).unwrap());
    // A fourth shape can only be a piece of one of the three.
    assert!((3..=4).contains(&parts(4).unwrap().len()));
    assert!(matches!(parts(0), Err(FitError::Option(_))));
}

/// Errors of a mesh are not normal: two shapes of different noise would describe one surface shorter.
#[test]
fn one_surface_with_two_noises_is_one_part() {
    let board = placed([1.0, 1.2, 0.3], [0.3, 0.5], [0.0, 0.0, 0.0]);
    let mut random = SplitMix::new(3);
    let mut points = board.cloud(2000, Faults { noise: 1e-3, ..Faults::default() }, &mut random);
    points.extend(board.cloud(2000, Faults { noise: 1e-4, ..Faults::default() }, &mut random));
    assert_found(&[board], &points, PartCount::Auto, 0.01);
}

#[test]
fn a_search_that_is_stopped_returns_what_it_has() {
    let shapes = apart();
    let points = cloud(&shapes, 3000, 0.01, 0.0);
    let all = fit_parts(&points, &FitOptions::default(), PartCount::Auto).unwrap();
    let mut fits = Vec::new();
    let watched = fit_parts_while(&points, &FitOptions::default(), PartCount::Auto, &mut |progress| {
        fits.push(progress.fits);
        true
    });
    assert_eq!(watched.unwrap(), all);
    assert!(fits.iter().copied().eq(0..fits.len()), "{fits:?}");
    for most in [0, 1, 2, fits.len() / 2] {
        let mut calls = 0;
        let stopped = fit_parts_while(&points, &FitOptions::default(), PartCount::Auto, &mut |progress| {
            calls += 1;
            progress.fits < most
        });
        assert!(!stopped.unwrap().is_empty());
        assert_eq!(calls, most + 1);
    }
}
