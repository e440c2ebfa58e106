//! NumPy's archives of arrays (.npz): ZIP files of .npy files, stored or deflated.

use std::collections::HashMap;
use std::io::Read;

use rawzip::{CompressionMethod, ZipArchive, ZipArchiveEntryWayfinder, ZipSliceArchive};

use super::numpy::{self, NumpyArray};
use crate::read::error::ReadError;

/// The first bytes of a ZIP file.
pub(crate) const MAGIC: &[u8] = b"PK\x03\x04";
/// The largest array, in bytes when inflated.
const MOST_ARRAY_BYTES: u64 = 1 << 28;
/// The largest number of files in an archive.
const MOST_ENTRIES: usize = 100_000;

/// An archive; arrays are inflated when they are read.
pub(crate) struct Npz<'a> {
    archive: ZipSliceArchive<&'a [u8]>,
    entries: HashMap<String, Entry>,
}

/// Where an array lies.
struct Entry {
    method: CompressionMethod,
    wayfinder: ZipArchiveEntryWayfinder,
    inflated_size: u64,
}

impl<'a> Npz<'a> {
    /// Opens an archive: reads its directory.
    ///
    /// # Errors
    /// The bytes are no ZIP file, or it has too many files.
    pub(crate) fn open(bytes: &'a [u8]) -> Result<Self, ReadError> {
        let error = |error: rawzip::Error| ReadError::File(format!("the archive cannot be read: {error}"));
        let archive = ZipArchive::from_slice(bytes).map_err(error)?;
        let mut entries = HashMap::new();
        let mut listed = archive.entries();
        while let Some(entry) = listed.next_entry().map_err(error)? {
            let path = String::from_utf8_lossy(entry.file_path().as_ref()).into_owned();
            let Some(name) = path.strip_suffix(".npy") else { continue };
            if entries.len() == MOST_ENTRIES {
                let message = format!("the archive has more than {MOST_ENTRIES} arrays");
                return Err(ReadError::File(message));
            }
            let entry = Entry {
                method: entry.compression_method(),
                wayfinder: entry.wayfinder(),
                inflated_size: entry.uncompressed_size_hint(),
            };
            entries.insert(name.to_owned(), entry);
        }
        Ok(Self { archive, entries })
    }

    /// The names of the arrays, sorted.
    pub(crate) fn names(&self) -> Vec<&str> {
        let mut names: Vec<&str> = self.entries.keys().map(String::as_str).collect();
        names.sort_unstable();
        names
    }

    /// Whether there is an array of this name.
    pub(crate) fn has(&self, name: &str) -> bool {
        self.entries.contains_key(name)
    }

    /// The array of this name, `None` if there is none.
    ///
    /// # Errors
    /// The array is too large, damaged, or of a type that is not read.
    pub(crate) fn array(&self, name: &str) -> Result<Option<NumpyArray>, ReadError> {
        let Some(entry) = self.entries.get(name) else { return Ok(None) };
        if entry.inflated_size > MOST_ARRAY_BYTES {
            let message = format!(
                "the archive claims {} bytes for this array; the most is {MOST_ARRAY_BYTES}",
                entry.inflated_size
            );
            return Err(ReadError::part(name, message));
        }
        let damaged =
            |error: &dyn std::fmt::Display| ReadError::part(name, format!("cannot be read: {error}"));
        let file = self.archive.get_entry(entry.wayfinder).map_err(|error| damaged(&error))?;
        if entry.method == CompressionMethod::STORE {
            return numpy::read(file.data(), name).map(Some);
        }
        if entry.method != CompressionMethod::DEFLATE {
            let message = "the compression is not read; save with numpy.savez or savez_compressed";
            return Err(ReadError::part(name, message));
        }
        let inflater = flate2::bufread::DeflateDecoder::new(file.data());
        // No capacity is reserved: the size that the archive claims may be a lie.
        let mut bytes = Vec::new();
        let mut reader = file.verifying_reader(inflater).take(entry.inflated_size + 1);
        reader.read_to_end(&mut bytes).map_err(|error| damaged(&error))?;
        if bytes.len() as u64 != entry.inflated_size {
            return Err(ReadError::part(name, "the archive claims another size than its data have"));
        }
        numpy::read(&bytes, name).map(Some)
    }

    /// The array of this name; an error that lists the names if there is none.
    pub(crate) fn needed(&self, name: &str) -> Result<NumpyArray, ReadError> {
        self.array(name)?.ok_or_else(|| {
            let names = self.names().join(", ");
            ReadError::part(name, format!("the archive has no such array; it has: {names}"))
        })
    }
}

/// The names of the arrays whose local headers lie in these first bytes of an archive.
pub(crate) fn names_in_head(head: &[u8]) -> Vec<String> {
    let mut names = Vec::new();
    let mut rest = head;
    while let Some(at) = rest.windows(MAGIC.len()).position(|window| window == MAGIC) {
        let header = &rest[at..];
        rest = &rest[at + MAGIC.len()..];
        let Some(length) = header.get(26..28) else { break };
        let length = usize::from(u16::from_le_bytes([length[0], length[1]]));
        let Some(path) = header.get(30..30 + length) else { break };
        let path = String::from_utf8_lossy(path);
        if let Some(name) = path.strip_suffix(".npy") {
            names.push(name.to_owned());
        }
    }
    names
}

#[cfg(test)]
pub(crate) mod tests {
    use std::io::Write;

    use rawzip::ZipArchiveWriter;

    use super::super::numpy::tests::npy_f64;
    use super::*;

    /// The bytes of an archive of these arrays.
    pub(crate) fn npz(arrays: &[(&str, Vec<u8>)], method: CompressionMethod) -> Vec<u8> {
        let mut bytes = Vec::new();
        let mut archive = ZipArchiveWriter::new(&mut bytes);
        for (name, data) in arrays {
            let path = format!("{name}.npy");
            let (mut entry, config) = archive.new_file(&path).compression_method(method).start().unwrap();
            if method == CompressionMethod::DEFLATE {
                let encoder = flate2::write::DeflateEncoder::new(&mut entry, flate2::Compression::default());
                let mut writer = config.wrap(encoder);
                writer.write_all(data).unwrap();
                let (encoder, descriptor) = writer.finish().unwrap();
                encoder.finish().unwrap();
                entry.finish(descriptor).unwrap();
            } else {
                let mut writer = config.wrap(&mut entry);
                writer.write_all(data).unwrap();
                let (_, descriptor) = writer.finish().unwrap();
                entry.finish(descriptor).unwrap();
            }
        }
        archive.finish().unwrap();
        bytes
    }

    #[test]
    fn stored_and_deflated_arrays_are_the_same() {
        let numbers: Vec<f64> = (0..100).map(f64::from).collect();
        for method in [CompressionMethod::STORE, CompressionMethod::DEFLATE] {
            let bytes = npz(&[("a", npy_f64("(100,)", &numbers)), ("b/c", npy_f64("()", &[7.0]))], method);
            let archive = Npz::open(&bytes).unwrap();
            assert_eq!(archive.names(), ["a", "b/c"]);
            let array = archive.needed("a").unwrap().numbers("a").unwrap();
            assert_eq!(array.values, numbers);
            assert!(archive.array("d").unwrap().is_none());
            assert!(archive.needed("d").unwrap_err().to_string().contains("it has: a, b/c"));
            assert_eq!(names_in_head(&bytes), ["a", "b/c"]);
        }
    }

    #[test]
    fn a_bomb_and_a_cut_are_errors() {
        // A megabyte of zeros in a kilobyte, with the claimed size made smaller and larger.
        let zeros = npy_f64("(131072,)", &vec![0.0; 131_072]);
        let size = (zeros.len() as u32).to_le_bytes();
        let bytes = npz(&[("a", zeros)], CompressionMethod::DEFLATE);
        for claim in [1000_u32, u32::MAX - 1, 1 << 29] {
            let mut lie = bytes.clone();
            for at in 0..lie.len() - 4 {
                if lie[at..at + 4] == size {
                    lie[at..at + 4].copy_from_slice(&claim.to_le_bytes());
                }
            }
            assert!(Npz::open(&lie).and_then(|archive| archive.needed("a")).is_err(), "{claim}");
        }
        for end in 0..bytes.len() {
            assert!(Npz::open(&bytes[..end]).and_then(|archive| archive.needed("a")).is_err(), "{end}");
        }
    }
}
