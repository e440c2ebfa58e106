//! Arrays of numpy as columns, and columns as arrays, without copies.
//!
//! The Python half passes contiguous float64 arrays of one dimension; rows of several numbers lie one
//! behind the other.

use numpy::{Element, IntoPyArray, PyArray1, PyReadonlyArray1};
use pyo3::prelude::*;
use superegg::geom::{RayBatch, glam::DVec3};

use crate::errors;

/// A column of numbers from Python.
pub(crate) type Column<'py> = PyReadonlyArray1<'py, f64>;
/// A column of numbers for Python.
pub(crate) type Array<'py, T> = Bound<'py, PyArray1<T>>;

/// The numbers of a column.
pub(crate) fn numbers<'a>(column: &'a Column<'_>) -> PyResult<&'a [f64]> {
    column.as_slice().map_err(errors::value)
}

/// The rows of a column of K numbers each.
pub(crate) fn rows<'a, const K: usize>(column: &'a Column<'_>) -> PyResult<&'a [[f64; K]]> {
    let (rows, rest) = numbers(column)?.as_chunks::<K>();
    if rest.is_empty() { Ok(rows) } else { Err(errors::value(format!("expected rows of {K} numbers"))) }
}

/// The rows of a column as points.
pub(crate) fn points<'a>(column: &'a Column<'_>) -> PyResult<&'a [[f64; 3]]> {
    rows::<3>(column)
}

/// Vectors as a column.
pub(crate) fn flat(vectors: impl Iterator<Item = DVec3>) -> Vec<f64> {
    vectors.flat_map(|vector| vector.to_array()).collect()
}

/// A column as an array, without a copy.
pub(crate) fn array<T: Element>(py: Python<'_>, column: Vec<T>) -> Array<'_, T> {
    column.into_pyarray(py)
}

/// Rays as columns of Python.
pub(crate) struct Rays<'py> {
    pub(crate) origins: Column<'py>,
    pub(crate) directions: Column<'py>,
    pub(crate) t_min: Option<Column<'py>>,
    pub(crate) t_max: Option<Column<'py>>,
}

impl Rays<'_> {
    /// The batch that borrows the columns.
    pub(crate) fn batch(&self) -> PyResult<RayBatch<'_>> {
        let mut batch =
            RayBatch::new(points(&self.origins)?, points(&self.directions)?).map_err(errors::value)?;
        if let Some(t_min) = &self.t_min {
            batch = batch.with_t_min(numbers(t_min)?).map_err(errors::value)?;
        }
        if let Some(t_max) = &self.t_max {
            batch = batch.with_t_max(numbers(t_max)?).map_err(errors::value)?;
        }
        Ok(batch)
    }
}
