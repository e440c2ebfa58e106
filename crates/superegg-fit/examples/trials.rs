//! Counts good fits of clouds of random shapes, and their processor time (Linux):
//!
//! ```text
//! cargo run --release -p superegg-fit --example trials -- TRIALS POINTS NOISE OUTLIERS [half]
//! ```
//!
//! Noise is a part of the size, outliers a share of the points. Prints each fit whose surface is more than
//! 1 % of the size off on average.

#[path = "../tests/common/mod.rs"]
mod common;

use common::{Faults, Placed};
use superegg_fit::{FitOptions, fit};
use superegg_geom::SplitMix;

/// The processor time of this thread in seconds; 0 where the system does not tell.
fn processor_seconds() -> f64 {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").unwrap_or_default();
    text.split(' ').next().and_then(|nanoseconds| nanoseconds.parse::<f64>().ok()).unwrap_or(0.0) * 1e-9
}

#[expect(clippy::print_stdout, reason = "it is a program")]
fn main() {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let number =
        |index: usize, default: f64| words.get(index).and_then(|word| word.parse().ok()).unwrap_or(default);
    let (trials, count) = (number(0, 100.0) as u64, number(1, 2000.0) as usize);
    let is_half = words.iter().any(|word| word == "half");
    let faults = Faults { noise: number(2, 0.01), outliers: number(3, 0.2), is_half };
    let (mut errors, mut seconds) = (Vec::new(), 0.0);
    // Fits without and with a warning, good ones and others.
    let mut warned = [[0; 2]; 2];
    for seed in 0..trials {
        let mut random = SplitMix::new(seed);
        let placed = Placed::random(&mut random);
        let cloud = placed.cloud(count, faults, &mut random);
        let start = processor_seconds();
        let found = fit(&cloud, &FitOptions::default());
        seconds += processor_seconds() - start;
        let error = found.as_ref().map_or(f64::INFINITY, |found| placed.error_of(found));
        if error >= 0.01 {
            println!("{seed}: error {error:.4}\n  {placed:?}\n  {found:?}");
        }
        let is_warned = found.is_ok_and(|found| !found.warnings.is_empty());
        warned[usize::from(error >= 0.01)][usize::from(is_warned)] += 1;
        errors.push(error);
    }
    errors.sort_by(f64::total_cmp);
    let good = errors.partition_point(|error| *error < 0.01) as f64 / trials as f64;
    println!(
        "{faults:?}: {:.1} % good, median error {:.3} %, {:.2} ms each; warnings for {} of {} \
         good fits and {} of {} others",
        100.0 * good,
        100.0 * errors[errors.len() / 2],
        1e3 * seconds / trials as f64,
        warned[0][1],
        warned[0][0] + warned[0][1],
        warned[1][1],
        warned[1][0] + warned[1][1]
    );
}
