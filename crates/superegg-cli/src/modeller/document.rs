//! The file that a session edits, the files of earlier sessions, and the scene that its journal
//! begins with.

use std::path::{Path, PathBuf};

use superegg_lang::Session;
use superegg_viewer::Document;

use crate::files::recent::RecentFiles;
use crate::files::scene::lines_of;

/// The document of a session.
#[derive(Default)]
pub(super) struct DocumentState {
    /// The absolute path of the scene file last loaded or saved. Data of other programs, and files
    /// with errors, are not saved to.
    file: Option<PathBuf>,
    /// The number of changes when the file was loaded. Undoing more leads to another document.
    since: usize,
    /// `None` if this session keeps no list.
    recent: Option<RecentFiles>,
    /// The scene that the session began with, until the journal has it.
    beginning: Option<Beginning>,
    /// The session ends with its window.
    ends_with_window: bool,
    /// The description of an earlier session that ended without a save.
    unsaved_before: Option<String>,
}

/// The scene that a session began with.
pub(super) struct Beginning {
    path: PathBuf,
    session: Session,
}

impl Beginning {
    pub(super) fn label(&self) -> String {
        format!("load {}", self.path.display())
    }

    pub(super) fn lines(&self) -> String {
        lines_of(&self.path, &self.session)
    }
}

impl DocumentState {
    /// Begins with the scene of a file, or with a new one, in a window without a prompt.
    /// `is_its_scene` is false if saving to the file would lose something.
    pub(super) fn begin(&mut self, scene: Option<(&Path, Session)>, is_its_scene: bool) {
        self.ends_with_window = true;
        if let Some((path, session)) = scene {
            self.beginning = Some(Beginning { path: path.to_owned(), session });
            self.open(path, is_its_scene, 0);
        }
    }

    /// Keeps the list of recent files in this file.
    pub(super) fn keep_recent(&mut self, path: Option<PathBuf>) {
        let mut recent = RecentFiles::read(path);
        if let Some(file) = &self.file {
            // The list is a convenience: the session goes on without it.
            let _ = recent.add(file);
        }
        self.recent = Some(recent);
    }

    /// Takes a loaded file as the document after so many changes.
    pub(super) fn open(&mut self, path: &Path, is_its_scene: bool, changes: usize) {
        let path = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
        if let Some(recent) = &mut self.recent {
            let _ = recent.add(&path);
        }
        (self.file, self.since) = (Some(path).filter(|_| is_its_scene), changes);
    }

    /// Takes a saved file as the document.
    pub(super) fn save(&mut self, path: &Path) {
        self.open(path, true, self.since);
    }

    /// Begins a document without a file after so many changes.
    pub(super) fn detach(&mut self, changes: usize) {
        (self.file, self.since) = (None, changes);
    }

    /// Forgets the file if the document has been undone: there are only so many changes now.
    pub(super) fn on_changes(&mut self, changes: usize) {
        if changes < self.since {
            self.detach(0);
        }
    }

    /// The scene that the session began with, unless it has been taken.
    pub(super) fn take_beginning(&mut self) -> Option<Beginning> {
        self.beginning.take()
    }

    /// Offers an earlier session in the window, or none.
    pub(super) fn set_unsaved_before(&mut self, description: Option<String>) {
        self.unsaved_before = description;
    }

    pub(super) fn offers_unsaved(&self) -> bool {
        self.unsaved_before.is_some()
    }

    /// The document for the window.
    pub(super) fn of_viewer(&self, is_unsaved: bool) -> Document {
        Document {
            file: self.file.clone(),
            is_unsaved,
            recent: self.recent.as_ref().map_or_else(Vec::new, |recent| recent.files().to_vec()),
            ends_with_window: self.ends_with_window,
            unsaved_before: self.unsaved_before.clone(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_file_belongs_to_its_document_alone() {
        let mut document = DocumentState::default();
        let file = |document: &DocumentState| document.of_viewer(false).file;
        document.open(Path::new("/a.scn"), true, 3);
        document.on_changes(7);
        document.save(Path::new("/b.scn"));
        document.on_changes(3);
        assert_eq!(file(&document), Some("/b.scn".into()));
        // The load is undone.
        document.on_changes(2);
        assert_eq!(file(&document), None);
        document.save(Path::new("/c.scn"));
        document.open(Path::new("/data.csv"), false, 4);
        assert_eq!(file(&document), None);
    }
}
