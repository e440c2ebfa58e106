//! Writes the scene for another program.

use std::path::Path;

use superegg_exchange::write::export::ExportOptions;
use superegg_lang::{Fault, FaultCode};

use crate::export::{Export, export_targets};
use crate::files::{self, Overwrite};
use crate::modeller::faults::{not_exportable, quoted, unwritable};
use crate::modeller::state::Modeller;
use crate::text::counted;

impl Modeller {
    /// Writes the selected entity. The ending of the file is the format.
    pub(super) fn export(&mut self, file: &str, is_forced: bool) -> Result<(), Fault> {
        let root = self.selected_root()?.to_owned();
        let output = self.folders.expand(file);
        for target in export_targets(&output).map_err(|error| not_exportable(&error))? {
            self.check_export(&target, is_forced)?;
        }
        let scene = self.session().scene();
        let export = Export { scene, root: &root, output: &output, options: ExportOptions::default() };
        let exported = export.write().map_err(|error| not_exportable(&error))?;
        exported.files.iter().for_each(|file| self.known_files.remember(file));
        exported.note.iter().for_each(|note| self.print(note));
        for loss in &exported.losses {
            self.print(&format!("warning: {loss}"));
        }
        if self.answers_person() {
            let warnings = match exported.losses.len() {
                0 => String::new(),
                count => format!(", with {}", counted(count, "warning")),
            };
            self.print(&format!("exported as {}{warnings}", output.display()));
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
