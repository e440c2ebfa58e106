//! Loads and saves scenes, and changes and lists folders.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use superegg_lang::{Fault, FaultCode, write_session};

use crate::files::binary_scene;
use crate::files::names::{existing_or_typed, folder_of, name_seen_from, path_seen_from, rename_in_lines};
use crate::files::scene::{Loaded, lines_of, load_into};
use crate::files::{self, Overwrite};
use crate::modeller::faults::{not_loadable, quoted, unreadable, unwritable};
use crate::modeller::journal::Record;
use crate::modeller::reporter::Message;
use crate::modeller::state::{Modeller, Pending};
use crate::system::terminal::has_cursor;
use crate::text::counted;

/// The maximum number of errors of one file that are reported one by one.
const MOST_REPORTED: usize = 100;

impl Modeller {
    /// Reads a file and replaces the scene by it. Without `is_forced` a file with errors changes
    /// nothing, and unsaved changes of a person need a confirmation.
    pub(super) fn load(&mut self, file: Option<&str>, is_forced: bool, line: &str) -> Result<(), Fault> {
        let typed = file.map_or_else(|| self.folders.quicksave_to_load(), |file| self.folders.expand(file));
        let path = with_scene_extension_if_found(typed);
        let loaded = self.read_scene(&path, file)?;
        let errors = counted(loaded.error_count(), "error");
        if loaded.has_errors() && !is_forced {
            let message = format!("'{}' has {errors}; the scene is as it was", path.display());
            let name = file.map_or_else(String::new, |file| format!(" {}", quoted(file)));
            return Err(Fault::new(FaultCode::NotLoaded, message)
                .help(format!("'load!{name}' loads the lines without errors")));
        }
        if loaded.has_errors() {
            self.print(&format!(
                "{}: loaded except for {errors}; 'undo' restores the scene before",
                path.display()
            ));
        }
        let pending = Pending::Load { loaded: Box::new(loaded), path, label: line.trim().to_owned() };
        self.finish_or_confirm(pending, is_forced);
        Ok(())
    }

    /// Reads a scene file and reports its diagnostics.
    fn read_scene(&mut self, path: &Path, file: Option<&str>) -> Result<Loaded, Fault> {
        files::check_plain_file(path).map_err(|error| not_loadable(&error, file))?;
        let mut loaded = load_into(path, self.session().settings, &self.interrupt)
            .map_err(|error| not_loadable(&error, file))?;
        // They are seen from the working folder.
        let renamed = loaded.session.rename_files(&mut |name| {
            name_seen_from(&self.folder, name, &path_seen_from(Path::new("."), name))
        });
        if renamed {
            loaded.lines = lines_of(path, &loaded.session);
        }
        loaded.notes.iter().for_each(|note| self.print(&note.to_string()));
        for diagnostic in loaded.diagnostics.iter().take(MOST_REPORTED) {
            self.report_diagnostic(diagnostic);
        }
        let more = loaded.diagnostics.len().saturating_sub(MOST_REPORTED);
        if more > 0 {
            self.report(Message::Diagnostic(format!("... and {more} more in '{}'", path.display())));
        }
        if loaded.is_interrupted {
            return Err(Fault::new(
                FaultCode::Interrupted,
                "the load was interrupted; the scene is as it was",
            )
            .help("load it again, and let it end"));
        }
        Ok(loaded)
    }

    /// Reads a file and adds its contents to the scene, as one change. A file with errors changes
    /// nothing.
    pub(super) fn include(&mut self, file: &str, line: &str) -> Result<(), Fault> {
        let path = with_scene_extension_if_found(self.folders.expand(file));
        let loaded = self.read_scene(&path, Some(file))?;
        if loaded.has_errors() {
            let errors = counted(loaded.error_count(), "error");
            let message = format!("'{}' has {errors}; the scene is as it was", path.display());
            return Err(Fault::new(FaultCode::NotLoaded, message)
                .help("correct the file; 'superegg check' lists its errors"));
        }
        let lines = self.session().lines_to_include(&loaded.session)?;
        loaded.prints.iter().for_each(|text| self.print(text));
        let label = line.trim().to_owned();
        if !lines.is_empty() {
            self.timeline.run_lines(&label, &lines)?;
            self.record(Record::Lines { label: &label, lines: &lines });
        }
        if self.answers_person() {
            let added = loaded.session.scene();
            let text = format!(
                "{}: {}, {} included",
                path.display(),
                counted(added.primitives().count(), "primitive"),
                counted(added.objects().count(), "object")
            );
            self.print(&text);
        }
        Ok(())
    }

    /// Writes the scene, or with `as_history` the typed lines, to a file or to the quicksave.
    pub(super) fn save(
        &mut self,
        file: Option<&str>,
        is_forced: bool,
        as_history: bool,
    ) -> Result<(), Fault> {
        let path = match file {
            Some(file) => with_scene_extension(self.folders.expand(file)),
            None => self.prepare_quicksave()?,
        };
        let is_stream = files::is_standard_stream(&path);
        if !is_stream {
            files::check_not_pipe(&path)
                .and_then(|()| files::check_output(Some(&path), Path::new(""), Overwrite::Any))
                .map_err(|error| unwritable(&error))?;
            if !is_forced {
                let option = if as_history { "--history " } else { "" };
                self.known_files.check_overwrite(&path).map_err(|reason| {
                    let name = quoted(&path.display().to_string());
                    Fault::new(FaultCode::NotOurs, reason)
                        .help(format!("'save! {option}{name}' overwrites it"))
                })?;
            }
        }
        let mut missing = BTreeSet::new();
        let mut new_name = |name: &str| {
            let file = path_seen_from(&self.folder, name);
            if file.exists() {
                return name_seen_from(folder_of(&path), name, &file);
            }
            if !path_seen_from(folder_of(&path), name).exists() {
                missing.insert(name.to_owned());
            }
            None
        };
        let mut session = self.session().clone();
        if !is_stream {
            session.rename_files(&mut new_name);
        }
        if binary_scene::has_extension(&path) && !as_history {
            binary_scene::write(&path, session.scene(), session.selected())
        } else {
            let text = match as_history {
                true if is_stream => self.timeline.typed_lines(),
                true => rename_in_lines(&self.timeline.typed_lines(), &mut new_name),
                false => write_session(&session),
            };
            files::write(&path, text.as_bytes())
        }
        .map_err(|error| unwritable(&error))?;
        if is_stream || !path.is_file() {
            return Ok(());
        }
        for name in missing {
            self.print(&format!(
                "warning: the scene names '{name}', which is not found and keeps its name: put it beside the saved scene"
            ));
        }
        self.known_files.remember(&path);
        self.timeline.mark_saved();
        self.record(Record::Saved);
        if !as_history {
            self.document.save(&path);
        }
        if self.answers_person() {
            self.print(&format!("saved as {}", path.display()));
        }
        self.scene_file = Some(path);
        Ok(())
    }

    /// The path of the quicksave; creates its folder.
    fn prepare_quicksave(&self) -> Result<PathBuf, Fault> {
        let path = self.folders.quicksave().ok_or_else(|| {
            Fault::new(FaultCode::Unwritable, "the system has no folder for the quicksave")
                .help("name a file: save NAME.scn")
        })?;
        let folder = path.parent().unwrap_or(Path::new("."));
        std::fs::create_dir_all(folder).map_err(|error| {
            unwritable(&anyhow::Error::from(error).context(format!("cannot make '{}'", folder.display())))
        })?;
        Ok(path)
    }

    /// Prints the last `count` lines, or all, with their numbers.
    pub(super) fn print_history(&mut self, count: Option<u32>) {
        let skipped = self.lines.len().saturating_sub(count.map_or(usize::MAX, |count| count as usize));
        let lines = self.lines.iter().enumerate().skip(skipped);
        let text = lines.map(|(i, line)| format!("{:>5}  {line}", i + 1)).collect::<Vec<_>>().join("\n");
        self.print(&text);
    }

    /// Clears the terminal; without a terminal it does nothing.
    pub(super) fn clear_screen(&mut self) {
        if self.is_interactive() && has_cursor() {
            self.print_raw("\x1b[H\x1b[2J\x1b[3J");
        }
    }

    /// Prints the working folder.
    pub(super) fn print_folder(&mut self) -> Result<(), Fault> {
        let folder = std::env::current_dir().map_err(|error| unreadable(&error.into()))?;
        self.print(&folder.display().to_string());
        Ok(())
    }

    /// Changes the working folder, by default to the home folder.
    pub(super) fn change_folder(&mut self, folder: Option<&str>) -> Result<(), Fault> {
        let path = match (folder, &self.folders.home) {
            (Some(folder), _) => self.folders.expand(folder),
            (None, Some(home)) => home.clone(),
            (None, None) => {
                return Err(
                    Fault::new(FaultCode::Unreadable, "the system has no home folder").help("name a folder")
                );
            }
        };
        std::env::set_current_dir(&path).map_err(|error| {
            unreadable(&anyhow::Error::from(error).context(format!("cannot go to '{}'", path.display())))
        })?;
        // A relative name would refer to another file now.
        self.scene_file = self.scene_file.take().and_then(|file| file.file_name().map(PathBuf::from));
        Ok(())
    }

    /// Lists a folder, by default the working folder: folders first, without hidden entries.
    pub(super) fn list_folder(&mut self, folder: Option<&str>) -> Result<(), Fault> {
        let path = folder.map_or_else(|| PathBuf::from("."), |folder| self.folders.expand(folder));
        let entries = std::fs::read_dir(&path).map_err(|error| {
            unreadable(&anyhow::Error::from(error).context(format!("cannot list '{}'", path.display())))
        })?;
        let mut names: Vec<(bool, String)> = entries
            .flatten()
            .map(|entry| (entry.path().is_dir(), entry.file_name().to_string_lossy().into_owned()))
            .filter(|(_, name)| !name.starts_with('.'))
            .collect();
        names.sort_by(|a, b| (!a.0, &a.1).cmp(&(!b.0, &b.1)));
        let lines: Vec<String> =
            names.into_iter().map(|(is_folder, name)| if is_folder { name + "/" } else { name }).collect();
        self.print(&if lines.is_empty() { "the folder is empty".to_owned() } else { lines.join("\n") });
        Ok(())
    }
}

/// Adds `.scn` to a name without an extension, except for an existing entry that is not a plain
/// file.
fn with_scene_extension(path: PathBuf) -> PathBuf {
    let is_special = files::is_standard_stream(&path) || (path.exists() && !path.is_file());
    if path.extension().is_some() || is_special { path } else { path.with_extension("scn") }
}

/// The path of a typed name; with `.scn` if only the file with that extension exists.
fn with_scene_extension_if_found(path: PathBuf) -> PathBuf {
    let path = existing_or_typed(path);
    let mut longer = path.clone().into_os_string();
    longer.push(".scn");
    let longer = existing_or_typed(PathBuf::from(longer));
    if !path.exists() && longer.is_file() { longer } else { path }
}
