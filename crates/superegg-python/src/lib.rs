//! The compiled half of the Python package `superegg`.
//!
//! It takes and returns contiguous columns. `python/superegg` checks shapes, broadcasts, and has the
//! classes and documentation that users see. Modules use only modules that stand above them in this
//! list.

#![expect(clippy::needless_pass_by_value, reason = "arguments come from Python by value")]

mod errors;
mod work;

mod columns;

mod film;
mod shape;

mod fit;

mod load;

mod scene;

mod program;

use pyo3::prelude::*;

/// The module `superegg._superegg`.
#[pymodule]
fn _superegg(module: &Bound<'_, PyModule>) -> PyResult<()> {
    let py = module.py();
    module.add("FormatError", py.get_type::<errors::FormatError>())?;
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add_class::<shape::Shape>()?;
    module.add_class::<fit::Fit>()?;
    module.add_class::<scene::Scene>()?;
    module.add_class::<scene::Paths>()?;
    module.add_class::<film::Film>()?;
    module.add_function(wrap_pyfunction!(film::srgb8, module)?)?;
    module.add_function(wrap_pyfunction!(fit::fit, module)?)?;
    module.add_function(wrap_pyfunction!(fit::fit_parts, module)?)?;
    module.add_function(wrap_pyfunction!(fit::covariance_rows, module)?)?;
    module.add_function(wrap_pyfunction!(load::formats, module)?)?;
    module.add_function(wrap_pyfunction!(load::colormaps, module)?)?;
    module.add_function(wrap_pyfunction!(scene::load_files, module)?)?;
    module.add_function(wrap_pyfunction!(scene::load_bytes, module)?)?;
    module.add_function(wrap_pyfunction!(program::run, module)?)?;
    Ok(())
}
