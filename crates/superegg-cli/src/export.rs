//! Writes scenes for other programs, as pictures show them: `superegg export`, and `export` at the
//! prompt.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use superegg_exchange::write::export::{ExportFormat, ExportOptions, export};
use superegg_scene::Scene;

use crate::files;
use crate::inspect::framing::{framed_root, framing_note};

/// An export with the files that it replaces.
pub(crate) struct Export<'a> {
    pub(crate) scene: &'a Scene,
    /// The name of what is written.
    pub(crate) root: &'a str,
    /// The file. Its ending is the format.
    pub(crate) output: &'a Path,
    pub(crate) options: ExportOptions,
}

/// The output of an export.
pub(crate) struct Exported {
    /// The file, and the materials beside an .obj file.
    pub(crate) files: Vec<PathBuf>,
    /// The camera, if the scene sets none and is not in sight of the default one.
    pub(crate) note: Option<String>,
    /// Losses of the format.
    pub(crate) losses: Vec<String>,
}

/// The files that an export may write: the file, and the materials beside an .obj file.
///
/// # Errors
/// No format has the ending of the file's name.
pub(crate) fn export_targets(output: &Path) -> Result<Vec<PathBuf>> {
    let mut targets = vec![output.to_owned()];
    if ExportFormat::of(output)? == ExportFormat::Obj {
        targets.push(materials_path(output));
    }
    Ok(targets)
}

fn materials_path(output: &Path) -> PathBuf {
    output.with_extension("mtl")
}

impl Export<'_> {
    /// Writes the files.
    ///
    /// # Errors
    /// The format does not exist or cannot hold the scene, or a file cannot be written.
    pub(crate) fn write(self) -> Result<Exported> {
        let Self { scene, root, output, mut options } = self;
        let format = ExportFormat::of(output)?;
        let materials = materials_path(output);
        let name = materials.file_name().and_then(|name| name.to_str());
        if format == ExportFormat::Obj {
            name.context("the name of an .obj file must be valid UTF-8")?;
        }
        options.materials = name.unwrap_or_default().to_owned();
        let depth = options.depth.unwrap_or(scene.depth);
        let size = (scene.picture.width, scene.picture.height);
        let framed = framed_root(scene, Some(root), depth, size);
        let written = export(framed.as_ref().unwrap_or(scene), root, format, &options)?;
        let mut files = Vec::new();
        if let Some(companion) = &written.companion {
            files::write(&materials, companion)?;
            files.push(materials);
        }
        files::write(output, &written.bytes)?;
        files.push(output.to_owned());
        Ok(Exported { files, note: framed.as_ref().map(framing_note), losses: written.losses })
    }
}
