//! Fits of clouds of known shapes: how often they are right.

mod common;

use common::{Faults, Placed};
use superegg_fit::{FitOptions, fit};
use superegg_geom::SplitMix;

/// The share of fits whose surface is within 1 % of the size on average.
fn share_of_good_fits(trials: u64, count: usize, faults: Faults) -> f64 {
    let is_good = |seed: u64| {
        let mut random = SplitMix::new(seed);
        let placed = Placed::random(&mut random);
        let cloud = placed.cloud(count, faults, &mut random);
        let found = fit(&cloud, &FitOptions::default()).unwrap();
        placed.error_of(&found) < 0.01
    };
    (0..trials).filter(|&seed| is_good(seed)).count() as f64 / trials as f64
}

#[test]
fn clouds_with_noise_and_outliers() {
    let faults = Faults { noise: 0.01, outliers: 0.2, ..Faults::default() };
    assert!(share_of_good_fits(50, 2000, faults) >= 0.98);
    assert!(share_of_good_fits(30, 200, faults) >= 0.9);
}

#[test]
fn clouds_of_mostly_outliers() {
    let faults = Faults { noise: 0.02, outliers: 0.6, ..Faults::default() };
    assert!(share_of_good_fits(30, 2000, faults) >= 0.95);
}

#[test]
fn half_views() {
    let faults = Faults { noise: 0.01, outliers: 0.2, is_half: true };
    assert!(share_of_good_fits(30, 2000, faults) >= 0.93);
}

#[test]
fn exact_clouds_have_exact_fits() {
    let mut random = SplitMix::new(8);
    let mut wrong = 0;
    for _ in 0..20 {
        let placed = Placed::random(&mut random);
        let cloud = placed.cloud(1000, Faults::default(), &mut random);
        let found = fit(&cloud, &FitOptions::default()).unwrap();
        if found.residuals(&cloud).hausdorff() > 1e-4 * placed.size() {
            wrong += 1;
        }
    }
    assert!(wrong <= 1, "{wrong}");
}

#[test]
fn errors_are_as_large_as_the_covariance_says() {
    let faults = Faults { noise: 0.02, ..Faults::default() };
    let mut random = SplitMix::new(5);
    let (mut squares, mut count) = (0.0, 0.0_f64);
    for _ in 0..20 {
        let placed = Placed::random(&mut random);
        let cloud = placed.cloud(1500, faults, &mut random);
        let found = fit(&cloud, &FitOptions::default()).unwrap();
        let errors = found.standard_errors();
        let off = (found.center - placed.center).to_array();
        for (off, error) in off.iter().zip(errors) {
            squares += (off / error).powi(2);
            count += 1.0;
        }
    }
    let ratio = (squares / count).sqrt();
    assert!((0.7..1.4).contains(&ratio), "{ratio}");
}
