//! Picture files as the program writes them, for another front end.

use anyhow::Result;
use superegg_render::{Film, RenderSettings};

use crate::annotate::Annotations;
use crate::denoise::applies;
use crate::files::notes::notes;
use crate::files::picture::PictureFormat;

/// The PNG file of a film that was rendered with these settings, with its notes of how it was made. It is not denoised: see
/// [`denoised`](crate::denoise::denoised).
///
/// # Errors
/// The encoder fails.
pub fn png_file(film: &Film, settings: &RenderSettings) -> Result<Vec<u8>> {
    let notes = notes(settings, applies(film, settings), None);
    PictureFormat::Png.encode_as_it_is(film, settings, &Annotations::default(), &notes)
}

/// The OpenEXR file of a film, as [`png_file`].
///
/// # Errors
/// The encoder fails.
pub fn exr_file(film: &Film, settings: &RenderSettings) -> Result<Vec<u8>> {
    let notes = notes(settings, applies(film, settings), None);
    PictureFormat::Exr.encode_as_it_is(film, settings, &Annotations::default(), &notes)
}
