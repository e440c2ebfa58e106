//! A rendered picture and its files.

use std::fs;
use std::path::Path;

use superegg_render::{Development, Film, TraceStats, exr_file};

use crate::error::Error;

/// A rendered picture: the film of linear light, and how it is developed into the bytes of a picture file.
#[derive(Clone, Debug)]
pub struct Rendering {
    /// Linear light and the other columns of every pixel.
    pub film: Film,
    /// Exposure, tone mapping, encoding and bit depth.
    pub development: Development,
    /// The numbers of rays traced.
    pub stats: TraceStats,
}

impl Rendering {
    /// The PNG file, developed.
    ///
    /// # Errors
    /// The encoder fails.
    pub fn to_png(&self) -> Result<Vec<u8>, Error> {
        Ok(self.development.png(&self.film)?)
    }

    /// The OpenEXR file: linear light with depth, normal, albedo and instance id, without development.
    ///
    /// # Errors
    /// The encoder fails.
    pub fn to_exr(&self) -> Result<Vec<u8>, Error> {
        Ok(exr_file(&self.film, 0.0, &[])?)
    }

    /// Writes a `.png` or `.exr` file.
    ///
    /// # Errors
    /// Another ending, an encoder that fails, or a file that cannot be written.
    pub fn save(&self, path: impl AsRef<Path>) -> Result<(), Error> {
        let path = path.as_ref();
        let ending = path.extension().and_then(|ending| ending.to_str()).map(str::to_ascii_lowercase);
        let bytes = match ending.as_deref() {
            Some("png") => self.to_png()?,
            Some("exr") => self.to_exr()?,
            _ => return Err(Error::Ending(path.to_owned())),
        };
        fs::write(path, bytes).map_err(|error| Error::File { action: "write", path: path.to_owned(), error })
    }
}
