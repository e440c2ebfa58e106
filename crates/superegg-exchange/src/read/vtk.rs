//! VTK files: legacy and XML, their points and the arrays of their points.
//!
//! The readers are our own: vtkio 0.6.3 loses all arrays of legacy files of version 5.1, and
//! 0.7.0-rc2 panics on compressed data, which is VTK's default; the parts that particles and
//! tensors need are small. XML is parsed by quick-xml, zlib by flate2, base64 by base64.

mod data_set;
mod encoded;
mod legacy;
mod xml;

use super::error::ReadError;

pub(super) use data_set::{Array, DataSet, Kind, Wanted};

/// Whether a file that begins with these bytes is a VTK file.
pub(super) fn is_vtk(head: &[u8]) -> bool {
    legacy::is_legacy(head) || xml::is_xml(head)
}

/// Reads the points, and the arrays of the points that `wanted` chooses.
///
/// # Errors
/// The file is not VTK, of a kind without points, or wrong; an array that is wanted cannot be read.
pub(super) fn read(bytes: &[u8], wanted: Wanted<'_>) -> Result<DataSet, ReadError> {
    read_parts(bytes, Some(wanted))
}

/// Reads the kind, the count and the names of the arrays, and no numbers.
///
/// # Errors
/// The file is not VTK, or wrong where its structure is.
pub(super) fn outline(bytes: &[u8]) -> Result<DataSet, ReadError> {
    read_parts(bytes, None)
}

fn read_parts(bytes: &[u8], wanted: Option<Wanted<'_>>) -> Result<DataSet, ReadError> {
    if legacy::is_legacy(bytes) {
        legacy::read(bytes, wanted)
    } else if xml::is_xml(bytes) {
        xml::read(bytes, wanted)
    } else {
        let message = "the file is not VTK: it begins neither with '# vtk DataFile' nor with <VTKFile>";
        Err(ReadError::File(message.to_owned()))
    }
}
