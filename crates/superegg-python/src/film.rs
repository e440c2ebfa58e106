//! A rendered picture.

use std::path::{Path, PathBuf};

use pyo3::prelude::*;
use pyo3::types::PyBytes;
use superegg::render::{Development, LightPasses, RenderSettings};
use superegg::scene::{Encoding, Picture, Tone};
use superegg_cli::save::{exr_file, png_file};

use crate::columns::{Array, Column, array, rows};
use crate::errors;
use crate::work::detached;

/// A rendered picture.
#[pyclass(frozen, module = "superegg._superegg")]
pub(crate) struct Film {
    pub(crate) film: superegg::render::Film,
    pub(crate) settings: RenderSettings,
}

#[pymethods]
impl Film {
    /// Height and width in pixels.
    #[getter]
    fn size(&self) -> (u32, u32) {
        (self.film.height(), self.film.width())
    }

    #[getter]
    fn has_layers(&self) -> bool {
        self.film.has_layers()
    }

    fn color<'py>(&self, py: Python<'py>) -> PyResult<Array<'py, f32>> {
        let colors = detached(py, || self.film.colors().as_flattened().to_vec())?;
        Ok(array(py, colors))
    }

    fn alpha<'py>(&self, py: Python<'py>) -> PyResult<Array<'py, f32>> {
        Ok(array(py, detached(py, || self.film.alphas().collect())?))
    }

    fn depth<'py>(&self, py: Python<'py>) -> PyResult<Array<'py, f32>> {
        Ok(array(py, detached(py, || self.film.depths().collect())?))
    }

    fn normal<'py>(&self, py: Python<'py>) -> PyResult<Array<'py, f32>> {
        Ok(array(py, detached(py, || self.film.normals().flatten().collect())?))
    }

    fn albedo<'py>(&self, py: Python<'py>) -> PyResult<Array<'py, f32>> {
        Ok(array(py, detached(py, || self.film.albedos().flatten().collect())?))
    }

    fn instance_id<'py>(&self, py: Python<'py>) -> PyResult<Array<'py, u32>> {
        Ok(array(py, detached(py, || self.film.ids().collect())?))
    }

    fn instance_number<'py>(&self, py: Python<'py>) -> PyResult<Array<'py, u32>> {
        Ok(array(py, detached(py, || self.film.pixels().map(|pixel| pixel.instance).collect())?))
    }

    fn object_number<'py>(&self, py: Python<'py>) -> PyResult<Array<'py, u32>> {
        Ok(array(py, detached(py, || self.film.pixels().map(|pixel| pixel.object).collect())?))
    }

    /// One of the parts of light; empty if the film does not keep them.
    fn light_pass<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Array<'py, f32>> {
        let of: fn(&LightPasses) -> [f32; 3] = match name {
            "emission" => |passes| passes.emission,
            "direct" => |passes| passes.direct,
            _ => |passes| passes.indirect,
        };
        Ok(array(py, detached(py, || self.film.all_passes().iter().flat_map(of).collect())?))
    }

    fn samples<'py>(&self, py: Python<'py>) -> PyResult<Array<'py, u32>> {
        Ok(array(py, detached(py, || self.film.sample_counts().collect())?))
    }

    /// The developed picture: three bytes a pixel.
    fn rgb8<'py>(&self, py: Python<'py>) -> PyResult<Array<'py, u8>> {
        Ok(array(py, detached(py, || self.settings.development().rgb8(&self.film))?))
    }

    fn to_png<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let bytes = detached(py, || png_file(&self.film, &self.settings))?.map_err(errors::value)?;
        Ok(PyBytes::new(py, &bytes))
    }

    fn to_exr<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let bytes = detached(py, || exr_file(&self.film, &self.settings))?.map_err(errors::value)?;
        Ok(PyBytes::new(py, &bytes))
    }

    fn save(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        let ending = path.extension().and_then(|ending| ending.to_str()).map(str::to_ascii_lowercase);
        let encode = match ending.as_deref() {
            Some("png") => png_file,
            Some("exr") => exr_file,
            _ => return Err(errors::value(superegg::Error::Ending(path))),
        };
        let bytes = detached(py, || encode(&self.film, &self.settings))?.map_err(errors::value)?;
        write(&path, &bytes)
    }
}

fn write(path: &Path, bytes: &[u8]) -> PyResult<()> {
    std::fs::write(path, bytes).map_err(|error| {
        let error = superegg::Error::File { action: "write", path: path.to_owned(), error };
        errors::of_file(&error.into(), &path.display().to_string())
    })
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
