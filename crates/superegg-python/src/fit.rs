//! Fits of superquadrics to points.

use std::sync::atomic::Ordering;

use pyo3::prelude::*;
use superegg::geom::glam::{DQuat, DVec3};
use superegg::geom::{Exponents, Superquadric};
use superegg_fit::{COVARIANCE_ROWS, FitOptions, PartCount, fit_parts_while};

use crate::columns::{Array, Column, array, points};
use crate::errors;
use crate::work::{abandonable, interruptible};

/// A fitted superquadric.
#[pyclass(frozen, module = "superegg._superegg")]
pub(crate) struct Fit {
    fit: superegg_fit::Fit,
    warnings: Vec<String>,
}

impl Fit {
    fn new(fit: superegg_fit::Fit) -> Self {
        Self { warnings: fit.warnings.iter().map(ToString::to_string).collect(), fit }
    }
}

/// All numbers of a fit, as they are kept: semi-axes, exponents, rotation w x y z, centre; noise, background,
/// outliers, error of the surface; covariance, number of points, warnings.
type Kept = ([f64; 3], [f64; 2], [f64; 4], [f64; 3], [f64; 4], Vec<f64>, usize, Vec<String>);

#[pymethods]
impl Fit {
    fn radii(&self) -> [f64; 3] {
        self.fit.shape.radii().to_array()
    }

    fn exponents(&self) -> [f64; 2] {
        [self.fit.shape.exponents().e(), self.fit.shape.exponents().n()]
    }

    /// w, x, y, z.
    fn rotation(&self) -> [f64; 4] {
        let [x, y, z, w] = self.fit.rotation.to_array();
        [w, x, y, z]
    }

    fn center(&self) -> [f64; 3] {
        self.fit.center.to_array()
    }

    fn noise(&self) -> f64 {
        self.fit.noise
    }

    fn outliers(&self) -> f64 {
        self.fit.outliers
    }

    fn surface_error(&self) -> f64 {
        self.fit.surface_error
    }

    fn used(&self) -> usize {
        self.fit.used
    }

    fn warnings(&self) -> Vec<String> {
        self.warnings.clone()
    }

    /// All numbers, for [`Fit::restored`].
    fn kept(&self) -> Kept {
        let fit = &self.fit;
        let numbers = [fit.noise, fit.background(), fit.outliers, fit.surface_error];
        let covariance = fit.covariance.as_flattened().to_vec();
        (
            self.radii(),
            self.exponents(),
            self.rotation(),
            self.center(),
            numbers,
            covariance,
            fit.used,
            self.warnings(),
        )
    }

    /// The fit of numbers that were kept.
    #[staticmethod]
    fn restored(kept: Kept) -> PyResult<Self> {
        let (radii, [e, n], [w, x, y, z], center, numbers, covariance, used, warnings) = kept;
        let [noise, background, outliers, surface_error] = numbers;
        let exponents = Exponents::new(e, n).map_err(errors::value)?;
        let shape = Superquadric::new(radii.into(), exponents).map_err(errors::value)?;
        let rotation = DQuat::from_xyzw(x, y, z, w);
        let mut fit = superegg_fit::Fit::restored(shape, rotation, center.into(), noise, background);
        fit.covariance.as_flattened_mut().iter_mut().zip(covariance).for_each(|(to, from)| *to = from);
        (fit.outliers, fit.surface_error, fit.used) = (outliers, surface_error, used);
        Ok(Self { fit, warnings })
    }

    fn covariance<'py>(&self, py: Python<'py>) -> Array<'py, f64> {
        array(py, self.fit.covariance.as_flattened().to_vec())
    }

    /// The signed distances of points, and how probably they are of the surface.
    fn residuals<'py>(
        &self,
        py: Python<'py>,
        at: Column<'py>,
    ) -> PyResult<(Array<'py, f64>, Array<'py, f64>)> {
        let at = points(&at)?;
        let (fit, at) = (self.fit.clone(), vectors(at));
        let found = abandonable(py, move || fit.residuals(&at))?;
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
    let at = vectors(points(&at)?);
    let options = FitOptions { seed, outliers, exponents, most_points };
    abandonable(py, move || superegg_fit::fit(&at, &options))?.map(Fit::new).map_err(errors::value)
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
    Ok(found.map_err(errors::value)?.into_iter().map(Fit::new).collect())
}

/// The names of the rows of a covariance.
#[pyfunction]
pub(crate) fn covariance_rows() -> Vec<&'static str> {
    COVARIANCE_ROWS.to_vec()
}
