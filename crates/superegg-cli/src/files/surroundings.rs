//! Pictures that scenes name: of the surroundings, and on surfaces.

use std::collections::HashMap;
use std::hash::Hash;
use std::path::Path;
use std::sync::Arc;

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
    ReadPictures::new(folder).settings(scene)
}

/// Pictures that the scenes of one folder name. Those of one scene are kept for the next.
pub(crate) struct ReadPictures<'a> {
    folder: Option<&'a Path>,
    /// By their names, and whether they are colours.
    textures: HashMap<(Arc<str>, bool), Arc<TexturePixels>>,
    surroundings: HashMap<Arc<str>, Arc<EnvironmentPixels>>,
}

impl<'a> ReadPictures<'a> {
    pub(crate) fn new(folder: Option<&'a Path>) -> Self {
        Self { folder, textures: HashMap::new(), surroundings: HashMap::new() }
    }

    /// As [`settings_with_surroundings`].
    pub(crate) fn settings(&mut self, scene: &Scene) -> Result<RenderSettings> {
        let Self { folder, textures, surroundings } = self;
        let mut before = std::mem::take(textures);
        let textures = TextureSet::of(scene, |texture, channel| {
            let key = (Arc::clone(&texture.file), channel == TextureChannel::Color);
            kept_or_read(&mut before, textures, key, || texture_of(&texture.file, channel, *folder))
        })?;
        let mut before = std::mem::take(surroundings);
        let settings = RenderSettings::of(scene).with_surroundings(scene, |picture| {
            let key = Arc::clone(&picture.file);
            kept_or_read(&mut before, surroundings, key, || pixels_of(&picture.file, *folder))
        })?;
        Ok(settings.with_textures(textures))
    }
}

/// The value of a key, which moves from the values before to those of now, or is read.
fn kept_or_read<K: Eq + Hash, V>(
    before: &mut HashMap<K, Arc<V>>,
    now: &mut HashMap<K, Arc<V>>,
    key: K,
    read: impl FnOnce() -> Result<V>,
) -> Result<Arc<V>> {
    let value = match before.remove(&key) {
        Some(value) => value,
        None => Arc::new(read()?),
    };
    now.insert(key, Arc::clone(&value));
    Ok(value)
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

#[cfg(test)]
mod tests {
    use superegg_lang::load_text;

    use super::*;
    use crate::files::fingerprint::PictureHashes;

    #[test]
    fn the_frames_of_an_animation_read_a_picture_once() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("tile.png");
        image::RgbImage::from_pixel(2, 2, image::Rgb([9, 8, 7])).save(&file).unwrap();
        let (session, _) =
            load_text("s.scn", "prm a\ntexture color tile.png\nprm b\ntexture bump tile.png\n");
        let mut pictures = ReadPictures::new(Some(folder.path()));
        let mut hashes = PictureHashes::new(Some(folder.path()));
        let before = (pictures.settings(session.scene()), hashes.text_of_picture(session.scene(), None));
        assert!(before.0.is_ok() && before.1.contains("# picture tile.png"));
        std::fs::remove_file(&file).unwrap();
        assert!(pictures.settings(session.scene()).is_ok());
        assert_eq!(hashes.text_of_picture(session.scene(), None), before.1);
        assert!(settings_with_surroundings(session.scene(), Some(folder.path())).is_err());
        // A frame without the picture forgets it: films of many pictures do not fill the memory.
        assert!(pictures.settings(&Scene::default()).is_ok());
        assert!(pictures.settings(session.scene()).is_err());
    }
}
