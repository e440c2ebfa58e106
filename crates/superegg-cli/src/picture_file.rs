//! Pictures as files: the name says the format.

use std::path::Path;

use anyhow::{Result, bail};
use superegg_render::{Film, RenderSettings, exr_file};

/// A format of pictures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum PictureFormat {
    /// What is seen on a screen.
    Png,
    /// OpenEXR: linear light, depth, normals and more.
    Exr,
}

impl PictureFormat {
    /// The endings of names that there are, as a person reads them.
    pub(crate) const ENDINGS: &str =
        ".png for a picture to look at, .exr for linear light with depth and normals (OpenEXR)";

    /// The format of a file by its name's ending. What has no ending, like `-` and devices, is a PNG.
    ///
    /// # Errors
    /// No format has this ending.
    pub(crate) fn of(path: &Path) -> Result<Self> {
        let Some(ending) = path.extension() else { return Ok(Self::Png) };
        let is = |known: &str| ending.eq_ignore_ascii_case(known);
        if is("png") {
            Ok(Self::Png)
        } else if is("exr") {
            Ok(Self::Exr)
        } else {
            bail!(
                "'{}': there is no picture format '.{}'; there are {}",
                path.display(),
                ending.display(),
                Self::ENDINGS
            )
        }
    }

    /// The first bytes of such files.
    pub(crate) fn mark(self) -> &'static [u8] {
        match self {
            Self::Png => b"\x89PNG",
            Self::Exr => &[0x76, 0x2f, 0x31, 0x01],
        }
    }

    /// The bytes of the file of a film that was made with these settings. An OpenEXR file is not developed: it has the light as it was traced.
    ///
    /// # Errors
    /// The encoder refuses it.
    pub(crate) fn encode(self, film: &Film, settings: &RenderSettings) -> Result<Vec<u8>> {
        Ok(match self {
            Self::Png => settings.development().png(&settings.output.colored(film))?,
            Self::Exr => exr_file(film)?,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ending_says_the_format() {
        let of = |name: &str| PictureFormat::of(Path::new(name)).map_err(|error| error.to_string());
        for name in ["a.png", "A.PNG", "-", "/dev/null", "picture", "folder.x/picture"] {
            assert_eq!(of(name), Ok(PictureFormat::Png), "{name}");
        }
        assert_eq!((of("a.exr"), of("b.png.EXR")), (Ok(PictureFormat::Exr), Ok(PictureFormat::Exr)));
        for name in ["a.jpg", "a.png.bak", "a.tiff"] {
            assert!(of(name).is_err_and(|error| error.contains(".png") && error.contains(".exr")), "{name}");
        }
    }
}
