//! The choices of a fit.

use crate::error::FitError;

/// The choices of a fit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FitOptions {
    /// The seed of the random order in which points are taken. The same points and seed give the same
    /// fit, in whatever order the points are.
    pub seed: u64,
    /// The share of outliers that is expected, 0 to 0.9. It only begins the search: the share that the
    /// points have is found.
    pub outliers: f64,
    /// The least and the most value of both exponents, 0.01 to 8.
    pub exponents: [f64; 2],
    /// The most points that are fitted, at least 1000. A larger cloud is thinned at random to
    /// this many.
    pub most_points: usize,
}

/// The number of parts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PartCount {
    /// This many, or fewer where the points do not have as many.
    Exactly(usize),
    /// As many as lower the description of the points: each part has to save as much as its eleven
    /// parameters cost (the Bayesian information criterion).
    Auto,
}

/// The most parts.
pub const MOST_PARTS: usize = 64;

/// The range of exponents that can be fitted.
const EXPONENTS: [f64; 2] = [0.01, 8.0];
/// The largest share of outliers.
const MOST_OUTLIERS: f64 = 0.9;
/// The least of [`FitOptions::most_points`].
const LEAST_MOST: usize = 1000;

impl Default for FitOptions {
    /// Seed 0, 20 % outliers, exponents from 0.05 to 2, 20,000 points.
    fn default() -> Self {
        Self { seed: 0, outliers: 0.2, exponents: [0.05, 2.0], most_points: 20_000 }
    }
}

impl FitOptions {
    /// Checks the ranges.
    pub(crate) fn check(&self) -> Result<(), FitError> {
        let [least, most] = self.exponents;
        if !(EXPONENTS[0] <= least && least < most && most <= EXPONENTS[1]) {
            return Err(FitError::Option("the exponents must be two increasing numbers from 0.01 to 8"));
        }
        if !(0.0..=MOST_OUTLIERS).contains(&self.outliers) {
            return Err(FitError::Option("the share of outliers must be from 0 to 0.9"));
        }
        if self.most_points < LEAST_MOST {
            return Err(FitError::Option("the number of points that are fitted must be at least 1000"));
        }
        Ok(())
    }
}
