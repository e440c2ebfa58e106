//! Loads and writes binary scenes (.sqb).

use std::fs::File;
use std::io::{BufReader, Cursor};
use std::path::Path;

use anyhow::{Context, Result, anyhow};
use superegg_exchange::read::Input;
use superegg_exchange::sqb::{self, BinaryScene};
use superegg_lang::{Diagnostic, Flow, Session, run_script, write_without_tables};
use superegg_scene::{InstanceTable, Scene};

use crate::files::access;
use crate::files::names::folder_of;
use crate::files::surroundings::unreadable_picture;

/// Whether a path ends in `.sqb`.
pub(crate) fn has_extension(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("sqb"))
}

/// A file as a seekable stream; standard input for `-`.
pub(super) fn open_input(path: &Path) -> Result<Box<dyn Input>> {
    if access::is_standard_stream(path) {
        return Ok(Box::new(Cursor::new(access::read(path)?)));
    }
    access::check_plain_file(path)?;
    let file = File::open(path).with_context(|| format!("cannot read '{}'", path.display()))?;
    Ok(Box::new(BufReader::with_capacity(1 << 18, file)))
}

/// Loads a binary scene.
///
/// # Errors
/// The file cannot be read, or is incomplete or damaged.
pub(super) fn load(path: &Path, input: &mut dyn Input) -> Result<(Session, Vec<Diagnostic>)> {
    let cannot_read = || format!("cannot read '{}'", path.display());
    let BinaryScene { text, tables } = sqb::read(input).with_context(cannot_read)?;
    let mut scene = Scene::default();
    for (name, table) in tables {
        scene.add_table(&name, table).map_err(|error| anyhow!("{}: {error}", cannot_read()))?;
    }
    let mut session = Session::with_scene(scene, None);
    let mut diagnostics = Vec::new();
    let name = path.display().to_string();
    run_script(&mut session, &name, text.as_bytes(), &mut diagnostics, &mut |_, line, effect, _| {
        unreadable_picture(line, &effect, folder_of(path)).map_or(Ok(Flow::Continue), Err)
    });
    Ok((session, diagnostics))
}

/// Writes a scene as a binary file, completely or not at all.
///
/// # Errors
/// The file cannot be written.
pub(crate) fn write(path: &Path, scene: &Scene, selected: Option<&str>) -> Result<()> {
    let text = write_without_tables(scene, selected);
    let tables: Vec<(&str, &InstanceTable)> = scene.tables().collect();
    access::write_with(path, |output| sqb::write(output, &text, &tables))
}
