//! Recognition of fits, and archives that hold one of several layouts.

mod fit;
mod json;
mod parts;
mod sage;
mod superdec;
mod vectors;

use super::arrays::npz::{self, Npz};
use super::arrays::numpy;
use super::error::ReadError;
use super::format::Format;
use super::import::Import;
use super::options::ReadOptions;

pub(crate) use sage::read as read_sage;
pub(crate) use vectors::{read_ems, read_superquadric_lib};

/// The format of a file with these first bytes, if it holds fits.
///
/// # Errors
/// The bytes fit several formats that mean different things.
pub(crate) fn recognize(head: &[u8]) -> Result<Option<Format>, ReadError> {
    match candidates(head)[..] {
        [] => Ok(None),
        [format] => Ok(Some(format)),
        ref several => Err(ReadError::Ambiguous {
            what: "eleven numbers may mean several things".to_owned(),
            candidates: several.iter().map(|format| format.name()).collect(),
        }),
    }
}

/// The formats that these first bytes may be.
fn candidates(head: &[u8]) -> Vec<Format> {
    if head.starts_with(npz::MAGIC) {
        let names = npz::names_in_head(head);
        let has = |name: &str| names.iter().any(|other| other == name);
        return if has("size") || has("location") {
            vec![Format::SuperquadricParsing]
        } else if has(superdec::KEY) || has("exist") || has("scale") || has("translation") {
            vec![Format::Superdec]
        } else if names.len() == 1 {
            vec![Format::Ems]
        } else if names.is_empty() {
            Vec::new()
        } else {
            // The telling names lie beyond the first bytes; the reader looks at all.
            vec![Format::Superdec]
        };
    }
    if head.starts_with(numpy::MAGIC) {
        let shape = numpy::shape_of(head);
        if shape.is_some_and(|shape| shape.len() == 2 && parts::ROW_WIDTHS.contains(&shape[1])) {
            return vec![Format::SuperquadricParsing];
        }
    }
    if json::has_key(head, sage::KEY) {
        return vec![Format::Sage];
    }
    if parts::KEYS.iter().filter(|key| json::has_key(head, key)).count() >= 2 {
        return vec![Format::SuperquadricParsing];
    }
    vectors::recognize(head)
}

/// Reads a SuperDec archive, or one of superquadric_parsing that was not told apart.
pub(crate) fn read_superdec(bytes: &[u8], options: &ReadOptions) -> Result<Import, ReadError> {
    let archive = Npz::open(bytes)?;
    if options.from.is_none() && parts::KEYS.iter().all(|key| archive.has(key)) {
        return parts::read_npz(&archive, options);
    }
    superdec::read(&archive, options)
}

/// Reads parts of superquadric_parsing.
pub(crate) fn read_parts(bytes: &[u8], options: &ReadOptions) -> Result<Import, ReadError> {
    if bytes.starts_with(npz::MAGIC) {
        parts::read_npz(&Npz::open(bytes)?, options)
    } else if bytes.starts_with(numpy::MAGIC) {
        parts::read_npy(bytes, options)
    } else {
        parts::read_json(bytes, options)
    }
}

#[cfg(test)]
mod tests {
    use rawzip::CompressionMethod;

    use super::super::arrays::npz::tests::npz;
    use super::super::arrays::numpy::tests::npy_f64;
    use super::*;

    #[test]
    fn archives_and_dictionaries_are_told_apart() {
        let one = || npy_f64("(1,)", &[1.0]);
        let of = |names: &[&str]| {
            let arrays: Vec<(&str, Vec<u8>)> = names.iter().map(|name| (*name, one())).collect();
            candidates(&npz(&arrays, CompressionMethod::DEFLATE))
        };
        assert_eq!(of(&["names", "scale", "rotation", "exist"]), [Format::Superdec]);
        assert_eq!(of(&["rotation", "shape", "size"]), [Format::SuperquadricParsing]);
        assert_eq!(of(&["x"]), [Format::Ems]);
        assert!(of(&[]).is_empty());
        assert_eq!(candidates(b"{\"true\": {\"a1\": 0.1, \"eps1\": 0.3"), [Format::Sage]);
        assert_eq!(candidates(b"[{\"size\": [1], \"shape\": [2]"), [Format::SuperquadricParsing]);
        assert_eq!(candidates(&npy_f64("(2, 14)", &[0.0; 28])), [Format::SuperquadricParsing]);
        assert!(candidates(b"{\"scene\": 1}").is_empty());
        assert!(candidates(b"").is_empty());
    }

    #[test]
    fn an_archive_is_read_by_all_its_names() {
        let arrays = [
            ("size", npy_f64("(1, 3)", &[1.0; 3])),
            ("shape", npy_f64("(1, 2)", &[1.0; 2])),
            ("rotation", npy_f64("(1, 4)", &[1.0, 0.0, 0.0, 0.0])),
            ("location", npy_f64("(1, 3)", &[0.0; 3])),
        ];
        let bytes = npz(&arrays, CompressionMethod::STORE);
        let import = read_superdec(&bytes, &ReadOptions::default()).unwrap();
        assert!(import.reading.starts_with("superquadric_parsing"));
        let options = ReadOptions { from: Some(Format::Superdec), ..ReadOptions::default() };
        assert!(read_superdec(&bytes, &options).unwrap_err().to_string().contains("'scale'"));
    }
}
