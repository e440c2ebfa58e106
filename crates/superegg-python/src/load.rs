//! How data files are read.

use pyo3::prelude::*;
use pyo3::types::PyDict;
use superegg::exchange::coloring::{ColorBy, Coloring, Colormap};
use superegg::exchange::read::{ColumnMap, Format, ReadOptions};
use superegg_cli::load::DataOptions;

use crate::errors;

/// The names and descriptions of the formats of other programs.
#[pyfunction]
pub(crate) fn formats() -> Vec<(&'static str, &'static str)> {
    Format::ALL.iter().map(|format| (format.name(), format.description())).collect()
}

/// The names of the colour maps.
#[pyfunction]
pub(crate) fn colormaps() -> Vec<&'static str> {
    Colormap::ALL.iter().map(|map| map.name()).collect()
}

/// The options of a load from the keywords of `superegg.load`, which has checked their types.
pub(crate) fn options(keywords: &Bound<'_, PyDict>) -> PyResult<DataOptions> {
    let format: Option<String> = get(keywords, "convention")?;
    let from = format.map(|name| format_of(&name)).transpose()?;
    let columns: Option<String> = get(keywords, "columns")?;
    let columns = columns.map(|text| text.parse::<ColumnMap>()).transpose().map_err(errors::value)?;
    let coloring = coloring(keywords)?;
    let extra = coloring.columns();
    let read = ReadOptions {
        from,
        columns,
        extra,
        min_axis: get(keywords, "min_axis")?,
        point_radius: get(keywords, "point_radius")?,
        ..ReadOptions::default()
    };
    Ok(DataOptions {
        read,
        coloring,
        frame: get(keywords, "frame")?,
        images: get(keywords, "images")?.unwrap_or([1; 3]),
        shows_box: get(keywords, "box")?.unwrap_or(false),
        size: None,
    })
}

fn coloring(keywords: &Bound<'_, PyDict>) -> PyResult<Coloring> {
    let Some(column) = get::<String>(keywords, "color_by")? else {
        let by_type = get(keywords, "type_colors")?.unwrap_or(false);
        return Ok(if by_type { Coloring::ByType } else { Coloring::Own });
    };
    let map = match get::<String>(keywords, "colormap")? {
        None => Colormap::default(),
        Some(name) => {
            let map = Colormap::ALL.iter().copied().find(|map| map.name() == name);
            map.ok_or_else(|| unknown("colormap", &name, colormaps()))?
        }
    };
    Ok(Coloring::ByColumn(ColorBy { column, map, range: get(keywords, "range")? }))
}

fn format_of(name: &str) -> PyResult<Format> {
    let names = Format::ALL.iter().map(|format| format.name());
    Format::by_name(name).ok_or_else(|| unknown("convention", name, names.collect()))
}

fn unknown(what: &str, name: &str, known: Vec<&str>) -> PyErr {
    errors::value(format!("there is no {what} '{name}'; choose one of {}", known.join(", ")))
}

fn get<'py, T: for<'a> FromPyObject<'a, 'py, Error = PyErr>>(
    keywords: &Bound<'py, PyDict>,
    name: &str,
) -> PyResult<Option<T>> {
    match keywords.get_item(name)? {
        Some(value) if !value.is_none() => value.extract().map(Some),
        _ => Ok(None),
    }
}
