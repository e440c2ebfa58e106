#![doc = include_str!("../README.md")]
#![allow(clippy::needless_range_loop, reason = "matrices and rows of lanes are clearer by index")]

mod alike;
mod cloud;
mod dense;
mod error;
mod fit;
mod mixture;
mod normal_equations;
mod options;
mod parameters;
mod parts;
mod project;
mod refine;
mod residuals;
mod rows;
mod search;
mod starts;
mod surface;
mod tangent;
mod uncertainty;
mod warning;

pub use error::{FitError, LEAST_POINTS};
pub use fit::{COVARIANCE_ROWS, Fit, fit};
pub use options::{FitOptions, MOST_PARTS, PartCount};
pub use parts::{PartsProgress, fit_parts, fit_parts_while};
pub use residuals::Residuals;
pub use warning::FitWarning;
