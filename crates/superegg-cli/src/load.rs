//! Scenes from files as the program reads them, for another front end.

use std::path::{Path, PathBuf};

use anyhow::Result;
use superegg_geom::Aabb;
use superegg_lang::{Diagnostic, Session, rename_files};
use superegg_render::{EnvironmentPixels, TexturePixels};
use superegg_scene::{EnvironmentPicture, Scene, Texture, TextureChannel};

pub use crate::files::data::DataOptions;
use crate::files::data::{self, Note};
use crate::files::names::{found, name_for_saving};
use crate::files::{scene, surroundings};

/// A scene that was read, and how.
#[derive(Debug)]
#[non_exhaustive]
pub struct LoadedScene {
    /// The scene, and the object of it that is selected.
    pub session: Session,
    /// The errors and warnings of its lines.
    pub diagnostics: Vec<Diagnostic>,
    /// How the numbers of data were understood, one line a file.
    pub readings: Vec<String>,
    /// Parts of data that were left out or cannot be trusted.
    pub warnings: Vec<String>,
    /// The box of data that its camera shows; `None` for a scene.
    pub bounds: Option<Aabb>,
    /// The index of the frame in its file.
    pub frame: usize,
}

impl LoadedScene {
    fn new(session: Session, diagnostics: Vec<Diagnostic>, notes: &[Note]) -> Self {
        let (warnings, readings): (Vec<&Note>, _) = notes.iter().partition(|note| note.is_warning());
        let lines = |notes: Vec<&Note>| notes.iter().map(ToString::to_string).collect();
        let (readings, warnings) = (lines(readings), lines(warnings));
        Self { session, diagnostics, readings, warnings, bounds: None, frame: 0 }
    }
}

/// Reads a scene or a file of another program; several data files become one scene.
///
/// # Errors
/// A file cannot be read, or its data is wrong. Wrong lines of a scene are diagnostics.
pub fn load_files(paths: &[PathBuf], options: &DataOptions) -> Result<LoadedScene> {
    if let [path] = paths {
        return Ok(of_loaded(scene::load_with(path, options)?));
    }
    let data::LoadedData { session, notes, bounds, frame, key: _ } = data::load_files(paths, options)?;
    Ok(LoadedScene { bounds: Some(bounds), frame, ..LoadedScene::new(session, Vec::new(), &notes) })
}

/// Reads the bytes of a file. `name` stands for it in messages.
///
/// # Errors
/// As for [`load_files`].
pub fn load_bytes(name: &Path, bytes: &[u8], options: &DataOptions) -> Result<LoadedScene> {
    Ok(of_loaded(scene::load_bytes(name, bytes, options)?))
}

/// Sets the camera and the light of data for a picture of this size.
pub fn frame_data(scene: &mut Scene, bounds: &Aabb, size: (u32, u32)) {
    data::frame(scene, bounds, &DataOptions { size: Some(size), ..DataOptions::default() });
}

/// The pixels of a texture of a scene in `folder`: the file is searched in the working folder, and then there.
///
/// # Errors
/// It cannot be read.
pub fn texture_pixels(
    texture: &Texture,
    channel: TextureChannel,
    folder: Option<&Path>,
) -> Result<TexturePixels> {
    surroundings::texture_of(&texture.file, channel, folder)
}

/// The path of a file that a scene in `folder` names, searched as those of [`texture_pixels`]. It need not exist.
pub fn path_of_file(name: &str, folder: Option<&Path>) -> PathBuf {
    found(name, folder)
}

/// The pixels of the surroundings of a scene in `folder`, searched as those of [`texture_pixels`].
///
/// # Errors
/// They cannot be read.
pub fn surroundings_pixels(picture: &EnvironmentPicture, folder: Option<&Path>) -> Result<EnvironmentPixels> {
    surroundings::pixels_of(&picture.file, folder)
}

/// Gives the files that a scene in `from` names the names by which they are found from a scene in `to`.
pub fn rename_for_saving(scene: &mut Scene, from: Option<&Path>, to: &Path) {
    rename_files(scene, &mut |name| name_for_saving(name, from, to));
}

fn of_loaded(loaded: scene::Loaded) -> LoadedScene {
    let scene::Loaded { session, diagnostics, notes, bounds, frame, .. } = loaded;
    LoadedScene { bounds, frame, ..LoadedScene::new(session, diagnostics, &notes) }
}
