//! Pictures that scenes name: of the surroundings, and on surfaces.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, anyhow};
use superegg_render::{EnvironmentPixels, RenderSettings, TexturePixels, TextureSet};
use superegg_scene::{EnvironmentPicture, Scene, Texture, TextureChannel};

use crate::files::folders::Folders;
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
    let path = found(&Folders::of_user().expand(&texture.file), folder);
    let bytes = read(&path).context("a texture of the scene is missing")?;
    TexturePixels::of_file(&bytes, channel == TextureChannel::Color)
        .map_err(|error| anyhow!("'{}' is no texture: {error}", path.display()))
}

/// Reads a picture of surroundings.
///
/// # Errors
/// It cannot be read.
pub(crate) fn pixels_of(picture: &EnvironmentPicture, folder: Option<&Path>) -> Result<EnvironmentPixels> {
    let path = found(&Folders::of_user().expand(&picture.file), folder);
    let bytes = read(&path).context("the scene's environment is missing")?;
    EnvironmentPixels::of_file(&bytes)
        .map_err(|error| anyhow!("'{}' is no picture of surroundings: {error}", path.display()))
}

/// A file that a scene names: in the working folder, else in the folder of the scene.
fn found(name: &Path, folder: Option<&Path>) -> PathBuf {
    // The prefix makes '-' a file, not standard input.
    let here = Path::new(".").join(name);
    let beside = folder.map(|folder| folder.join(name));
    beside.filter(|beside| !here.exists() && beside.exists()).unwrap_or(here)
}
