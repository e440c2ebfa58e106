//! Pictures that scenes name: of the surroundings, and on surfaces.

use std::path::Path;

use anyhow::{Context, Result, anyhow};
use superegg_render::{EnvironmentPixels, RenderSettings, TexturePixels, TextureSet};
use superegg_scene::{EnvironmentPicture, Scene, Texture, TextureChannel};

use crate::files::names::found;
use crate::files::read;

/// The settings of a scene's picture with the picture of its surroundings and its textures, which are searched in the working
/// folder and then in `folder`.
///
/// # Errors
/// A picture cannot be read.
pub(crate) fn settings_with_surroundings(scene: &Scene, folder: Option<&Path>) -> Result<RenderSettings> {
    let textures = TextureSet::of(scene, |texture, channel| texture_of(texture, channel, folder))?;
    let settings =
        RenderSettings::of(scene).with_surroundings(scene, |picture| pixels_of(picture, folder))?;
    Ok(settings.with_textures(textures))
}

/// Reads a texture.
///
/// # Errors
/// It cannot be read.
pub(crate) fn texture_of(
    texture: &Texture,
    channel: TextureChannel,
    folder: Option<&Path>,
) -> Result<TexturePixels> {
    let path = found(&texture.file, folder);
    let bytes = read(&path).context("a texture of the scene is missing")?;
    TexturePixels::of_file(&bytes, channel == TextureChannel::Color)
        .map_err(|error| anyhow!("'{}' is no texture: {error}", path.display()))
}

/// Reads a picture of surroundings.
///
/// # Errors
/// It cannot be read.
pub(crate) fn pixels_of(picture: &EnvironmentPicture, folder: Option<&Path>) -> Result<EnvironmentPixels> {
    let path = found(&picture.file, folder);
    let bytes = read(&path).context("the scene's environment is missing")?;
    EnvironmentPixels::of_file(&bytes)
        .map_err(|error| anyhow!("'{}' is no picture of surroundings: {error}", path.display()))
}
