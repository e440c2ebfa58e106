//! Picture files as the program writes them, for another front end.

use anyhow::Result;
use superegg_render::{Film, RenderSettings};

use crate::files::notes::notes;
use crate::files::picture::PictureFormat;

/// The PNG file of a film that was rendered with these settings, with its notes of how it was made.
///
/// # Errors
/// The encoder fails.
pub fn png_file(film: &Film, settings: &RenderSettings) -> Result<Vec<u8>> {
    PictureFormat::Png.encode(film, settings, &notes(settings, None))
}

/// The OpenEXR file of a film that was rendered with these settings, with its notes of how it was made.
///
/// # Errors
/// The encoder fails.
pub fn exr_file(film: &Film, settings: &RenderSettings) -> Result<Vec<u8>> {
    PictureFormat::Exr.encode(film, settings, &notes(settings, None))
}
