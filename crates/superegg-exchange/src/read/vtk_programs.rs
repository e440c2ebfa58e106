//! Which program wrote a VTK file.

use super::error::ReadError;
use super::format::Format;
use super::{liggghts_vtk, mercury, vtk, vtk_tensors};

/// The format of a VTK file, by the names of its arrays. Files of no known program count as those
/// of LIGGGHTS, whose reader says what they lack; so do files that are wrong.
pub(super) fn recognize(bytes: &[u8]) -> Format {
    match vtk::outline(bytes) {
        Ok(outline) if mercury::is_mercury(&outline) => Format::MercuryVtu,
        Ok(outline) if liggghts_vtk::is_liggghts(&outline) => Format::LiggghtsVtk,
        Ok(outline) if vtk_tensors::has_tensors(&outline) => Format::VtkTensors,
        Ok(_) | Err(_) => Format::LiggghtsVtk,
    }
}

/// Whether a VTK file has the arrays of shapes or tensors.
pub(super) fn has_shapes(bytes: &[u8]) -> bool {
    vtk::outline(bytes).is_ok_and(|outline| {
        mercury::is_mercury(&outline)
            || liggghts_vtk::is_liggghts(&outline)
            || vtk_tensors::has_tensors(&outline)
    })
}

/// The format of a VTK file as far as its first bytes name its arrays; `None` if it is no VTK file.
///
/// # Errors
/// None: faults of the file are found on reading.
pub(super) fn recognize_head(head: &[u8]) -> Result<Option<Format>, ReadError> {
    Ok(vtk::is_vtk(head).then(|| recognize(head)))
}
