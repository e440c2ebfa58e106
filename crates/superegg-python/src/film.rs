//! A rendered picture.

use std::path::PathBuf;

use pyo3::prelude::*;
use pyo3::types::PyBytes;
use superegg::Rendering;
use superegg::render::Development;
use superegg::scene::{Encoding, Picture, Tone};

use crate::columns::{Array, Column, array, rows};
use crate::errors;
use crate::work::detached;

/// A rendered picture.
#[pyclass(frozen, module = "superegg._superegg")]
pub(crate) struct Film(pub(crate) Rendering);

#[pymethods]
impl Film {
    /// Height and width in pixels.
    #[getter]
    fn size(&self) -> (u32, u32) {
        (self.0.film.height(), self.0.film.width())
    }

    #[getter]
    fn has_layers(&self) -> bool {
        self.0.film.has_layers()
    }

    fn color<'py>(&self, py: Python<'py>) -> PyResult<Array<'py, f32>> {
        let colors = detached(py, || self.0.film.colors().as_flattened().to_vec())?;
        Ok(array(py, colors))
    }

    fn alpha<'py>(&self, py: Python<'py>) -> PyResult<Array<'py, f32>> {
        Ok(array(py, detached(py, || self.0.film.alphas().collect())?))
    }

    fn depth<'py>(&self, py: Python<'py>) -> PyResult<Array<'py, f32>> {
        Ok(array(py, detached(py, || self.0.film.depths().collect())?))
    }

    fn normal<'py>(&self, py: Python<'py>) -> PyResult<Array<'py, f32>> {
        Ok(array(py, detached(py, || self.0.film.normals().flatten().collect())?))
    }

    fn albedo<'py>(&self, py: Python<'py>) -> PyResult<Array<'py, f32>> {
        Ok(array(py, detached(py, || self.0.film.albedos().flatten().collect())?))
    }

    fn instance_id<'py>(&self, py: Python<'py>) -> PyResult<Array<'py, u32>> {
        Ok(array(py, detached(py, || self.0.film.ids().collect())?))
    }

    fn samples<'py>(&self, py: Python<'py>) -> PyResult<Array<'py, u32>> {
        Ok(array(py, detached(py, || self.0.film.sample_counts().collect())?))
    }

    /// The developed picture: three bytes a pixel.
    fn rgb8<'py>(&self, py: Python<'py>) -> PyResult<Array<'py, u8>> {
        Ok(array(py, detached(py, || self.0.development.rgb8(&self.0.film))?))
    }

    fn to_png<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let bytes = detached(py, || self.0.to_png())?.map_err(errors::value)?;
        Ok(PyBytes::new(py, &bytes))
    }

    fn to_exr<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let bytes = detached(py, || self.0.to_exr())?.map_err(errors::value)?;
        Ok(PyBytes::new(py, &bytes))
    }

    fn save(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        let name = path.display().to_string();
        detached(py, || self.0.save(&path))?.map_err(|error| match error {
            superegg::Error::File { .. } => errors::of_file(&error.into(), &name),
            other => errors::value(other),
        })
    }
}

/// Linear colours as bytes of sRGB, by the curve of pictures.
#[pyfunction]
pub(crate) fn srgb8<'py>(py: Python<'py>, colors: Column<'py>) -> PyResult<Array<'py, u8>> {
    let picture = Picture { exposure: 0.0, tone: Tone::None, encoding: Encoding::Srgb, ..Picture::default() };
    let development = Development::of(&picture);
    let encoded = |color: &[f64; 3]| {
        development.value(color.map(|value| value as f32)).map(|value| (255.0 * value).round() as u8)
    };
    Ok(array(py, rows::<3>(&colors)?.iter().flat_map(encoded).collect()))
}
