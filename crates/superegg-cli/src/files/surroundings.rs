//! Pictures that scenes name: of the surroundings, and on surfaces.

use std::path::Path;

use anyhow::{Context, Result, anyhow};
use superegg_lang::{Effect, Fault, NamedPicture, PictureUse, picture_of_line};
use superegg_render::{EnvironmentPixels, RenderSettings, TexturePixels, TextureSet};
use superegg_scene::{Scene, TextureChannel};

use crate::files::names::{found, unreadable};
use crate::files::read;

/// The settings of a scene's picture with the picture of its surroundings and its textures, which are searched in the working
/// folder and then in `folder`.
///
/// # Errors
/// A picture cannot be read.
pub(crate) fn settings_with_surroundings(scene: &Scene, folder: Option<&Path>) -> Result<RenderSettings> {
    let textures = TextureSet::of(scene, |texture, channel| texture_of(&texture.file, channel, folder))?;
    let settings =
        RenderSettings::of(scene).with_surroundings(scene, |picture| pixels_of(&picture.file, folder))?;
    Ok(settings.with_textures(textures))
}

/// Reads the texture of a file.
///
/// # Errors
/// It cannot be read.
pub(crate) fn texture_of(
    file: &str,
    channel: TextureChannel,
    folder: Option<&Path>,
) -> Result<TexturePixels> {
    let path = found(file, folder);
    let bytes = read(&path).context("a texture of the scene is missing")?;
    TexturePixels::of_file(&bytes, channel == TextureChannel::Color)
        .map_err(|error| anyhow!("'{}' is no texture: {error}", path.display()))
}

/// Reads the picture of surroundings of a file.
///
/// # Errors
/// It cannot be read.
pub(crate) fn pixels_of(file: &str, folder: Option<&Path>) -> Result<EnvironmentPixels> {
    let path = found(file, folder);
    let bytes = read(&path).context("the scene's environment is missing")?;
    EnvironmentPixels::of_file(&bytes)
        .map_err(|error| anyhow!("'{}' is no picture of surroundings: {error}", path.display()))
}

/// The fault of a line that names a picture which cannot be read.
pub(super) fn unreadable_picture(line: &str, effect: &Effect, folder: &Path) -> Option<Fault> {
    if !matches!(effect, Effect::Changed(_)) {
        return None;
    }
    let NamedPicture { file, used_as, columns, .. } = picture_of_line(line)?;
    let error = match used_as {
        PictureUse::Environment => pixels_of(&file, Some(folder)).err(),
        PictureUse::Texture(channel) => texture_of(&file, channel, Some(folder)).err(),
    };
    error.map(|error| unreadable(&error).at(columns))
}
