//! Writes the scene for another program.

use std::path::Path;

use superegg_exchange::write::export::{ExportFormat, ExportOptions, export};
use superegg_lang::{Fault, FaultCode};

use crate::files::{self, Overwrite};
use crate::modeller::faults::{quoted, unwritable};
use crate::modeller::state::Modeller;
use crate::text::counted;

impl Modeller {
    /// Writes the selected entity. The ending of the file is the format.
    pub(super) fn export(&mut self, file: &str, is_forced: bool) -> Result<(), Fault> {
        let root = self.selected_root()?.to_owned();
        let path = self.folders.expand(file);
        let format = ExportFormat::of(&path).map_err(|error| unwritable(&error.into()))?;
        let materials = path.with_extension("mtl");
        let targets = if format == ExportFormat::Obj { vec![&path, &materials] } else { vec![&path] };
        targets.into_iter().try_for_each(|target| self.check_export(target, is_forced))?;
        let options = ExportOptions {
            materials: materials.file_name().unwrap_or_default().to_string_lossy().into_owned(),
            ..ExportOptions::default()
        };
        let written = export(self.session().scene(), &root, format, &options)
            .map_err(|error| unwritable(&error.into()))?;
        if let Some(companion) = &written.companion {
            files::write(&materials, companion).map_err(|error| unwritable(&error))?;
            self.known_files.remember(&materials);
        }
        files::write(&path, &written.bytes).map_err(|error| unwritable(&error))?;
        self.known_files.remember(&path);
        for loss in &written.losses {
            self.print(&format!("warning: {loss}"));
        }
        if self.answers_person() {
            let warnings = match written.losses.len() {
                0 => String::new(),
                count => format!(", with {}", counted(count, "warning")),
            };
            self.print(&format!("exported as {}{warnings}", path.display()));
        }
        Ok(())
    }

    /// Checks that a file may be written.
    fn check_export(&self, path: &Path, is_forced: bool) -> Result<(), Fault> {
        let overwrite = if is_forced { Overwrite::Any } else { Overwrite::Writable };
        files::check_not_pipe(path)
            .and_then(|()| files::check_output(Some(path), Path::new(""), overwrite))
            .map_err(|error| unwritable(&error))?;
        if is_forced {
            return Ok(());
        }
        self.known_files.check_overwrite(path).map_err(|reason| {
            let name = quoted(&path.display().to_string());
            Fault::new(FaultCode::NotOurs, reason).help(format!("'export! {name}' overwrites it"))
        })
    }
}
