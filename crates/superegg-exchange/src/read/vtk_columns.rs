//! The arrays of a VTK file as the columns of a table.

use super::error::ReadError;
use super::options::ReadOptions;
use super::vtk::{Array, DataSet};

/// The names of the columns of an array: its name for one component; NAMEx, NAMEy, NAMEz for
/// three, since LIGGGHTS joins vx, vy, vz to an array v; NAME\[1\], NAME\[2\] and so on for others.
fn column_names(name: &str, components: usize) -> Vec<String> {
    match components {
        1 => vec![name.to_owned()],
        3 => ["x", "y", "z"].map(|axis| format!("{name}{axis}")).into(),
        // A name for each component of an array with more would be of no use.
        _ => (1..=components.min(100)).map(|number| format!("{name}[{number}]")).collect(),
    }
}

/// Whether the options ask for an array, or a column of it, as a further column.
pub(super) fn is_asked_for(options: &ReadOptions, name: &str, components: usize) -> bool {
    if options.all_extra || options.extra.iter().any(|asked| asked == name) {
        return true;
    }
    let columns = column_names(name, components);
    options.extra.iter().any(|asked| columns.contains(asked))
}

/// The further columns that the options ask for, in the order of the file.
///
/// # Errors
/// A column is asked for that the file does not have.
pub(super) fn extra_columns(
    data: &DataSet,
    options: &ReadOptions,
) -> Result<Vec<(String, Vec<f64>)>, ReadError> {
    for asked in &options.extra {
        let has = |array: &Array| {
            array.name == *asked || column_names(&array.name, array.components).contains(asked)
        };
        if data.count > 0 && !data.arrays.iter().any(has) {
            let names = data.arrays.iter().flat_map(|array| column_names(&array.name, array.components));
            let message =
                format!("the file has no such column; it has {}", names.collect::<Vec<_>>().join(", "));
            return Err(ReadError::part(asked, message));
        }
    }
    let mut columns = Vec::new();
    for array in data.arrays.iter().filter(|array| !array.values.is_empty()) {
        let takes_all = options.all_extra || options.extra.contains(&array.name);
        for (component, name) in column_names(&array.name, array.components).into_iter().enumerate() {
            if takes_all || options.extra.contains(&name) {
                let column = array.values.iter().skip(component).step_by(array.components);
                columns.push((name, column.copied().collect()));
            }
        }
    }
    Ok(columns)
}

/// The rows of an array of `N` components, or `None` if the file lacks it.
///
/// # Errors
/// The array has another number of components.
pub(super) fn rows_of<'a, const N: usize>(
    data: &'a DataSet,
    name: &str,
) -> Result<Option<&'a [[f64; N]]>, ReadError> {
    let Some(array) = data.array(name) else { return Ok(None) };
    if array.components != N {
        let message = format!("expected {N} numbers a point, found {}", array.components);
        return Err(ReadError::part(name, message));
    }
    let (rows, _) = array.values.as_chunks();
    if rows.len() != data.points.len() {
        let message = format!("expected {} rows, found {}", data.points.len(), rows.len());
        return Err(ReadError::part(name, message));
    }
    Ok(Some(rows))
}

/// The rows of an array that the file must have.
///
/// # Errors
/// The array is missing or has another number of components.
pub(super) fn required<'a, const N: usize>(
    data: &'a DataSet,
    name: &str,
) -> Result<&'a [[f64; N]], ReadError> {
    rows_of(data, name)?.ok_or_else(|| ReadError::part(name, "the array is missing"))
}

/// Ids from their array; none if the file lacks it.
///
/// # Errors
/// An id is no integer.
pub(super) fn ids_of(data: &DataSet, name: &str) -> Result<Vec<i64>, ReadError> {
    let rows = rows_of::<1>(data, name)?.unwrap_or_default();
    let ids = rows.iter().enumerate().map(|(row, [id])| {
        let is_integer = id.fract() == 0.0 && id.abs() < 9e15;
        is_integer
            .then_some(*id as i64)
            .ok_or_else(|| row_error(name, row, format!("the id {id} is no integer")))
    });
    ids.collect()
}

/// An error in a row of an array, counted from 1.
pub(super) fn row_error(name: &str, row: usize, message: impl std::fmt::Display) -> ReadError {
    ReadError::part(name, format!("row {}: {message}", row + 1))
}
