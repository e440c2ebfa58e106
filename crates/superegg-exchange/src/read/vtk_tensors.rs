//! Tensors of the points of a VTK file: arrays of nine numbers, or of six for symmetric tensors in
//! VTK's order xx yy zz xy yz xz.

use superegg_geom::glam::{DMat3, DVec3};

use super::error::ReadError;
use super::import::Import;
use super::options::ReadOptions;
use super::tensor_field::{TensorField, import};
use super::vtk::{self, Array, DataSet};
use super::vtk_columns::{extra_columns, is_asked_for};

fn may_be_tensors(array: &Array) -> bool {
    array.components == 9 || array.components == 6
}

/// Whether a file with these arrays has tensors.
pub(super) fn has_tensors(outline: &DataSet) -> bool {
    outline.arrays.iter().any(may_be_tensors)
}

/// Reads one file. Among several arrays of tensors the one counts that the file marks as its tensors,
/// or the first.
///
/// # Errors
/// The file is wrong or has no array of tensors.
pub(super) fn read(bytes: &[u8], options: &ReadOptions) -> Result<Import, ReadError> {
    let outline = vtk::outline(bytes)?;
    let candidates: Vec<&Array> = outline.arrays.iter().filter(|array| may_be_tensors(array)).collect();
    let active = |array: &&&Array| outline.active_tensors.as_deref() == Some(&array.name);
    let Some(chosen) = candidates.iter().find(active).or(candidates.first()) else {
        let message = format!("a VTK file of {}: no array of 9 or 6 numbers a point", outline.description());
        return Err(ReadError::File(message));
    };
    let (name, components) = (chosen.name.clone(), chosen.components);
    let wanted = |array: &str, count| array == name || is_asked_for(options, array, count);
    let data = vtk::read(bytes, &wanted)?;
    let values = data.array(&name).map(|array| &array.values[..]).unwrap_or_default();
    let tensors: Vec<DMat3> = values.chunks_exact(components).map(tensor).collect();
    if tensors.len() != data.points.len() {
        let message = format!("expected {} tensors, found {}", data.points.len(), tensors.len());
        return Err(ReadError::part(name, message));
    }
    let mut warnings = Vec::new();
    if candidates.len() > 1 {
        let others: Vec<&str> =
            candidates.iter().map(|array| array.name.as_str()).filter(|other| *other != name).collect();
        warnings.push(format!("tensors '{name}' are shown; the file has {} too", others.join(", ")));
    }
    let extra = extra_columns(&data, options)?;
    let field = TensorField {
        name,
        positions: data.points,
        tensors,
        spacing: data.spacing,
        extra,
        step: data.step,
        warnings,
    };
    import(field, options)
}

/// The tensor of nine or six numbers.
fn tensor(numbers: &[f64]) -> DMat3 {
    match *numbers {
        [xx, yy, zz, xy, yz, xz] => {
            DMat3::from_cols(DVec3::new(xx, xy, xz), DVec3::new(xy, yy, yz), DVec3::new(xz, yz, zz))
        }
        [a, b, c, d, e, f, g, h, i] => DMat3::from_cols_array(&[a, d, g, b, e, h, c, f, i]),
        _ => DMat3::NAN,
    }
}
