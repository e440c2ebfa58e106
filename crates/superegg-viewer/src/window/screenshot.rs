//! Pictures of the window in numbered files.

use std::fs::OpenOptions;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// Writes bytes to the first of `superegg-0001.png` to `superegg-9999.png` that does not exist in a
/// folder. Returns its path.
///
/// # Errors
/// The folder cannot be written to, or all 9999 files exist.
pub(crate) fn write_numbered(folder: &Path, bytes: &[u8]) -> io::Result<PathBuf> {
    for number in 1..=9999 {
        let path = folder.join(format!("superegg-{number:04}.png"));
        match OpenOptions::new().write(true).create_new(true).open(&path) {
            Ok(mut file) => {
                return file.write_all(bytes).map(|()| path.clone()).inspect_err(|_| {
                    // No incomplete picture stays.
                    let _ = std::fs::remove_file(&path);
                });
            }
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => (),
            Err(error) => return Err(error),
        }
    }
    Err(io::Error::new(io::ErrorKind::AlreadyExists, "superegg-0001.png to superegg-9999.png all exist"))
}

/// Encodes an image as PNG.
///
/// # Errors
/// The encoder fails.
pub(crate) fn png(image: &image::RgbaImage) -> Result<Vec<u8>, image::ImageError> {
    let mut bytes = Vec::new();
    image.write_to(&mut io::Cursor::new(&mut bytes), image::ImageFormat::Png)?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_continue_and_nothing_is_overwritten() {
        let folder = std::env::temp_dir().join(format!("superegg-screenshot-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let names: Vec<String> = [b"one", b"two"]
            .iter()
            .map(|bytes| write_numbered(&folder, *bytes).unwrap())
            .map(|path| path.file_name().unwrap().to_string_lossy().into_owned())
            .collect();
        assert_eq!(names, ["superegg-0001.png", "superegg-0002.png"]);
        assert_eq!(std::fs::read(folder.join("superegg-0001.png")).unwrap(), b"one");
        std::fs::remove_dir_all(&folder).unwrap();
        assert!(write_numbered(&folder, b"").is_err());
    }
}
