//! OBJ files: vertices, and faces of any number of corners.

use superegg_geom::glam::DVec3;

use super::triangles::Triangle;
use crate::read::error::ReadError;
use crate::read::number;

/// The first words of lines of an OBJ file.
const WORDS: [&[u8]; 12] =
    [b"v", b"vn", b"vt", b"vp", b"f", b"l", b"p", b"o", b"g", b"s", b"mtllib", b"usemtl"];
/// The lines that are looked at.
const DECIDING: usize = 50;

/// Whether the first lines of a file are those of an OBJ file, and one of them is a vertex.
pub(crate) fn recognize(bytes: &[u8]) -> bool {
    let head = bytes.get(..bytes.len().min(1 << 14)).unwrap_or_default();
    let mut first_words = head.split(|&byte| byte == b'\n').take(DECIDING).filter_map(first_word);
    let mut has_vertex = false;
    first_words.all(|word| {
        has_vertex |= word == b"v";
        WORDS.contains(&word)
    }) && has_vertex
}

/// The first word of a line that is no comment.
fn first_word(line: &[u8]) -> Option<&[u8]> {
    let word = line.split(u8::is_ascii_whitespace).find(|word| !word.is_empty())?;
    (!word.starts_with(b"#")).then_some(word)
}

/// The vertices and the triangles of a file.
#[derive(Clone, Debug, Default)]
pub(crate) struct Obj {
    pub(crate) vertices: Vec<DVec3>,
    pub(crate) triangles: Vec<Triangle>,
}

/// Reads vertices and faces; the corners of a face are joined to its first one.
///
/// # Errors
/// A vertex has fewer than three numbers, or a face names a vertex that is not there.
pub(crate) fn read(bytes: &[u8]) -> Result<Obj, ReadError> {
    let mut obj = Obj::default();
    for (line, text) in bytes.split(|&byte| byte == b'\n').enumerate() {
        let fault = |message: String| ReadError::line(line as u64 + 1, message);
        let mut words = text.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty());
        match words.next() {
            Some(b"v") => {
                let numbers: Vec<f64> = words.map_while(number::parse).collect();
                let [x, y, z, ..] = numbers[..] else {
                    return Err(fault("expected 'v' and three numbers".to_owned()));
                };
                obj.vertices.push(DVec3::new(x, y, z));
            }
            Some(b"f") => {
                let corners: Option<Vec<DVec3>> = words.map(|word| corner(word, &obj.vertices)).collect();
                let Some(corners) = corners else {
                    let count = obj.vertices.len();
                    return Err(fault(format!("expected indices of vertices, of which {count} stand above")));
                };
                for pair in corners.windows(2).skip(1) {
                    obj.triangles.push([corners[0], pair[0], pair[1]]);
                }
            }
            _ => {}
        }
    }
    Ok(obj)
}

/// The vertex that a corner such as `3`, `3/1/2` or `-1` names.
fn corner(word: &[u8], vertices: &[DVec3]) -> Option<DVec3> {
    let index = word.split(|&byte| byte == b'/').next()?;
    let index: i64 = std::str::from_utf8(index).ok()?.parse().ok()?;
    let from_start = if index < 0 { vertices.len() as i64 + index } else { index - 1 };
    vertices.get(usize::try_from(from_start).ok()?).copied()
}
