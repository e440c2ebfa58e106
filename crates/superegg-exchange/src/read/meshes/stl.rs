//! STL files, binary and text: triangles without shared corners.

use superegg_geom::glam::DVec3;

use super::triangles::Triangle;
use crate::read::error::ReadError;
use crate::read::number;

/// The bytes before the number of triangles of a binary file, and of one triangle.
const HEADER: usize = 80;
const RECORD: usize = 50;

/// Whether these bytes are an STL file: a binary one is exactly as long as its number of triangles
/// needs, a text begins with `solid` and has facets.
pub(crate) fn recognize(bytes: &[u8]) -> bool {
    binary_records(bytes).is_some() || is_text(bytes)
}

/// As [`recognize`], from the first bytes of a file of `length` bytes.
pub(super) fn recognize_head(head: &[u8], length: u64) -> bool {
    let count =
        head.get(HEADER..).and_then(|rest| rest.first_chunk()).map(|count| u32::from_le_bytes(*count));
    let size = |count: u32| (HEADER + 4) as u64 + RECORD as u64 * u64::from(count);
    count.is_some_and(|count| size(count) == length) || is_text(head)
}

fn is_text(bytes: &[u8]) -> bool {
    let head = bytes.get(..bytes.len().min(1 << 12)).unwrap_or_default();
    let mut words = head.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty());
    words.next() == Some(b"solid") && words.any(|word| word == b"facet" || word == b"endsolid")
}

/// The records of a binary file.
fn binary_records(bytes: &[u8]) -> Option<&[[u8; RECORD]]> {
    let count = u32::from_le_bytes(*bytes.get(HEADER..)?.first_chunk()?) as usize;
    let (records, rest) = bytes[HEADER + 4..].as_chunks::<RECORD>();
    (records.len() == count && rest.is_empty()).then_some(records)
}

/// Reads the triangles.
///
/// # Errors
/// A line of a text is no vertex of three numbers, or the number of vertices is no multiple of three.
pub(crate) fn read(bytes: &[u8]) -> Result<Vec<Triangle>, ReadError> {
    if let Some(records) = binary_records(bytes) {
        let float = |record: &[u8; RECORD], index: usize| {
            let at = 4 * index;
            f64::from(f32::from_le_bytes([record[at], record[at + 1], record[at + 2], record[at + 3]]))
        };
        // The normal comes first.
        let corner = |record: &[u8; RECORD], index: usize| {
            DVec3::new(float(record, index), float(record, index + 1), float(record, index + 2))
        };
        return Ok(records.iter().map(|record| [3, 6, 9].map(|index| corner(record, index))).collect());
    }
    let mut corners = Vec::new();
    for (line, text) in bytes.split(|&byte| byte == b'\n').enumerate() {
        let mut words = text.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty());
        if words.next() == Some(b"vertex") {
            let numbers: Vec<f64> = words.filter_map(number::parse).collect();
            let [x, y, z] = numbers[..] else {
                return Err(ReadError::line(line as u64 + 1, "expected 'vertex' and three numbers"));
            };
            corners.push(DVec3::new(x, y, z));
        }
    }
    let (triangles, rest) = corners.as_chunks::<3>();
    if !rest.is_empty() {
        let message = format!("the file has {} vertices, which is no multiple of three", corners.len());
        return Err(ReadError::File(message));
    }
    Ok(triangles.to_vec())
}
