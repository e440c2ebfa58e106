//! The program `superegg` in the package.

use std::ffi::OsString;

use pyo3::prelude::*;

use crate::work::detached;

/// Runs the program with these arguments, of which the first is its name; returns its exit code.
#[pyfunction]
pub(crate) fn run(py: Python<'_>, args: Vec<OsString>) -> PyResult<u8> {
    detached(py, || superegg_cli::run(args))
}
