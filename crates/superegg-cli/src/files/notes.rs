//! How a picture was made, as texts in its file.

use std::path::Path;

use anyhow::{Result, anyhow};
use superegg_lang::{SETTINGS, Settings};
use superegg_render::{Output, PictureNote, RenderSettings, notes_of_exr, notes_of_png};
use superegg_scene::Picture;

use crate::files::picture::PictureFormat;
use crate::files::{begins_with, read};

/// The notes of a picture: the program, the settings and, if given, the text of the scene. They depend on nothing else, so
/// that equal renders make equal files. The setting of denoising is that of the picture, which may be incomplete or no light.
pub(crate) fn notes(
    settings: &RenderSettings,
    is_denoised: bool,
    scene_text: Option<String>,
) -> Vec<PictureNote> {
    let picture = Picture { denoise: is_denoised, ..settings.picture };
    let unchanging = Settings::default();
    let of_scene = SETTINGS.iter().filter(|spec| spec.is_of_scene);
    let mut lines: Vec<String> =
        of_scene.map(|spec| format!("set {} {}", spec.name, spec.value(&picture, &unchanging))).collect();
    if settings.output != Output::Light {
        lines.push(format!("# aov {}", format!("{:?}", settings.output).to_lowercase()));
    }
    let program = concat!("superegg ", env!("CARGO_PKG_VERSION")).to_owned();
    let mut notes = vec![
        PictureNote { name: "superegg:version", text: program },
        PictureNote { name: "superegg:settings", text: lines.join("\n") },
    ];
    notes.extend(scene_text.map(|text| PictureNote { name: "superegg:scene", text }));
    notes
}

/// The notes in a picture file on how it was made; `None` for a file of another kind.
///
/// # Errors
/// The file cannot be read, or it is damaged.
pub(crate) fn described(path: &Path) -> Result<Option<String>> {
    let is = |format: PictureFormat| begins_with(path, format.signature());
    let text = if is(PictureFormat::Png) {
        let notes = notes_of_png(&read(path)?).map_err(|error| anyhow!("'{}': {error}", path.display()))?;
        notes.iter().map(|(name, text)| format!("{name}\n{}\n", text.trim_end())).collect::<String>()
    } else if is(PictureFormat::Exr) {
        let notes = notes_of_exr(&read(path)?).map_err(|error| anyhow!("'{}': {error}", path.display()))?;
        notes.unwrap_or_default()
    } else {
        return Ok(None);
    };
    let nothing =
        || format!("'{}' does not say how it was made: other programs remove such texts\n", path.display());
    Ok(Some(if text.is_empty() { nothing() } else { text }))
}
