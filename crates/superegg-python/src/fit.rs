//! Fits of superquadrics to points.

use std::sync::atomic::Ordering;

use pyo3::prelude::*;
use superegg::geom::glam::DVec3;
use superegg_fit::{COVARIANCE_ROWS, FitOptions, PartCount, fit_parts_while};

use crate::columns::{Array, Column, array, points};
use crate::errors;
use crate::work::{detached, interruptible};

/// A fitted superquadric.
#[pyclass(frozen, module = "superegg._superegg")]
pub(crate) struct Fit(superegg_fit::Fit);

#[pymethods]
impl Fit {
    fn radii(&self) -> [f64; 3] {
        self.0.shape.radii().to_array()
    }

    fn exponents(&self) -> [f64; 2] {
        [self.0.shape.exponents().e(), self.0.shape.exponents().n()]
    }

    /// w, x, y, z.
    fn rotation(&self) -> [f64; 4] {
        let [x, y, z, w] = self.0.rotation.to_array();
        [w, x, y, z]
    }

    fn center(&self) -> [f64; 3] {
        self.0.center.to_array()
    }

    fn noise(&self) -> f64 {
        self.0.noise
    }

    fn outliers(&self) -> f64 {
        self.0.outliers
    }

    fn surface_error(&self) -> f64 {
        self.0.surface_error
    }

    fn used(&self) -> usize {
        self.0.used
    }

    fn warnings(&self) -> Vec<String> {
        self.0.warnings.iter().map(ToString::to_string).collect()
    }

    fn covariance<'py>(&self, py: Python<'py>) -> Array<'py, f64> {
        array(py, self.0.covariance.as_flattened().to_vec())
    }

    /// The signed distances of points, and how probably they are of the surface.
    fn residuals<'py>(
        &self,
        py: Python<'py>,
        at: Column<'py>,
    ) -> PyResult<(Array<'py, f64>, Array<'py, f64>)> {
        let at = points(&at)?;
        let found = detached(py, || self.0.residuals(&vectors(at)))?;
        Ok((array(py, found.distances), array(py, found.inliers)))
    }
}

fn vectors(rows: &[[f64; 3]]) -> Vec<DVec3> {
    rows.iter().map(|&row| row.into()).collect()
}

/// Fits a superquadric to points.
#[pyfunction]
pub(crate) fn fit(
    py: Python<'_>,
    at: Column<'_>,
    seed: u64,
    outliers: f64,
    exponents: [f64; 2],
    most_points: usize,
) -> PyResult<Fit> {
    let at = points(&at)?;
    let options = FitOptions { seed, outliers, exponents, most_points };
    detached(py, || superegg_fit::fit(&vectors(at), &options))?.map(Fit).map_err(errors::value)
}

/// Fits superquadrics to the parts of points; `count` of none for as many as they show.
#[pyfunction]
pub(crate) fn fit_parts(
    py: Python<'_>,
    at: Column<'_>,
    count: Option<usize>,
    seed: u64,
    outliers: f64,
    exponents: [f64; 2],
    most_points: usize,
) -> PyResult<Vec<Fit>> {
    let at = vectors(points(&at)?);
    let options = FitOptions { seed, outliers, exponents, most_points };
    let count = count.map_or(PartCount::Auto, PartCount::Exactly);
    let found = interruptible(
        py,
        |_| Ok(()),
        |cancel| fit_parts_while(&at, &options, count, &mut |_| !cancel.load(Ordering::Relaxed)),
    )?;
    Ok(found.map_err(errors::value)?.into_iter().map(Fit).collect())
}

/// The names of the rows of a covariance.
#[pyfunction]
pub(crate) fn covariance_rows() -> Vec<&'static str> {
    COVARIANCE_ROWS.to_vec()
}
