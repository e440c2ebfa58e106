//! Picture files. The extension of the name determines the format.

use std::path::Path;

use anyhow::{Result, bail};
use superegg_render::{Film, PictureNote, RenderSettings, exr_file};

use crate::annotate::Annotations;
use crate::denoise::denoised;

/// A picture format.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum PictureFormat {
    /// For screens, after tone mapping and encoding.
    Png,
    /// OpenEXR: linear light, depth, normals and other AOVs.
    Exr,
}

impl PictureFormat {
    /// The known extensions, for messages.
    pub(crate) const ENDINGS: &str =
        ".png for a picture to look at, .exr for linear light with depth and normals (OpenEXR)";

    /// The format of a path. Without an extension, as for `-` and devices, it is PNG.
    ///
    /// # Errors
    /// The extension is unknown.
    pub(crate) fn of(path: &Path) -> Result<Self> {
        let Some(extension) = path.extension() else { return Ok(Self::Png) };
        let is = |known: &str| extension.eq_ignore_ascii_case(known);
        if is("png") {
            Ok(Self::Png)
        } else if is("exr") {
            Ok(Self::Exr)
        } else {
            bail!(
                "'{}': there is no picture format '.{}'; there are {}",
                path.display(),
                extension.display(),
                Self::ENDINGS
            )
        }
    }

    /// The first bytes of every file of the format.
    pub(crate) fn signature(self) -> &'static [u8] {
        match self {
            Self::Png => b"\x89PNG",
            Self::Exr => &[0x76, 0x2f, 0x31, 0x01],
        }
    }

    /// Encodes a film that was rendered with these settings, denoised if they say so. OpenEXR keeps linear light without
    /// tone mapping.
    ///
    /// # Errors
    /// The encoder fails, or the film cannot be denoised.
    pub(crate) fn encode(
        self,
        film: &Film,
        settings: &RenderSettings,
        notes: &[PictureNote],
    ) -> Result<Vec<u8>> {
        self.encode_annotated(film, settings, &Annotations::default(), notes)
    }

    /// As [`PictureFormat::encode`], with what is drawn into a PNG picture. OpenEXR has none of it.
    ///
    /// # Errors
    /// The encoder fails, the film cannot be denoised, or an annotation cannot be drawn.
    pub(crate) fn encode_annotated(
        self,
        film: &Film,
        settings: &RenderSettings,
        annotations: &Annotations,
        notes: &[PictureNote],
    ) -> Result<Vec<u8>> {
        let film = denoised(film, settings)?;
        self.encode_as_it_is(&film, settings, annotations, notes)
    }

    /// As [`PictureFormat::encode_annotated`], without denoising.
    ///
    /// # Errors
    /// The encoder fails, or an annotation cannot be drawn.
    pub(crate) fn encode_as_it_is(
        self,
        film: &Film,
        settings: &RenderSettings,
        annotations: &Annotations,
        notes: &[PictureNote],
    ) -> Result<Vec<u8>> {
        match self {
            Self::Png => annotations.png(film, settings, notes),
            Self::Exr => Ok(exr_file(film, settings.picture.far_depth, notes)?),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_extension_determines_the_format() {
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
