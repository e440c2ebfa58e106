//! New, open, save, import, export and leave: the question about unsaved changes and the choice of
//! a file before they are lines of the language.

use std::path::{Path, PathBuf};

use egui::{Key, Modal, Ui};

use super::file_dialog::{Chosen, FileDialog, FileKind};
use crate::commands;
use crate::input::FileAction;
use crate::protocol::Document;

/// A task of the session or the window.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum FileEvent {
    /// Run this line.
    Command(String),
    /// Close the window.
    Leave,
    /// Show this text.
    Notice(String),
}

/// The action with files that is in progress.
#[derive(Debug, Default)]
pub(crate) struct Files {
    stage: Stage,
    /// The question or the dialog has not been drawn yet: the key that has opened it is not its own.
    is_fresh: bool,
}

#[derive(Debug, Default)]
enum Stage {
    #[default]
    Idle,
    /// Unsaved changes are asked about before this action.
    Asking(FileAction),
    /// A file is chosen, and saved before the action if there is one.
    Choosing(Box<FileDialog>, Option<FileAction>),
    /// The scene is saved before this action.
    Saving(FileAction),
}

/// The answer to the question about unsaved changes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Answer {
    Save,
    Discard,
    Cancel,
}

impl Files {
    /// Whether a question or a dialog has the keyboard.
    pub(crate) fn is_open(&self) -> bool {
        matches!(self.stage, Stage::Asking(_) | Stage::Choosing(..))
    }

    /// Begins an action: asks first if it would lose unsaved changes.
    pub(crate) fn begin(&mut self, action: FileAction, document: &Document) -> Vec<FileEvent> {
        let loses = match action {
            FileAction::New | FileAction::Open | FileAction::OpenFile(_) => true,
            FileAction::Leave => document.ends_with_window,
            FileAction::Save
            | FileAction::SaveAs
            | FileAction::Import
            | FileAction::Export
            | FileAction::Render => false,
        };
        self.is_fresh = true;
        if loses && document.is_unsaved {
            self.stage = Stage::Asking(action);
            return Vec::new();
        }
        self.perform(action, document)
    }

    /// Continues an action that waits for the scene to be saved.
    pub(crate) fn on_snapshot(&mut self, document: &Document) -> Vec<FileEvent> {
        match std::mem::take(&mut self.stage) {
            Stage::Saving(then) if !document.is_unsaved => self.perform(then, document),
            stage => {
                self.stage = stage;
                Vec::new()
            }
        }
    }

    /// Drops an action that waits for the scene to be saved: it could not be.
    pub(crate) fn on_failure(&mut self) {
        if matches!(self.stage, Stage::Saving(_)) {
            self.stage = Stage::Idle;
        }
    }

    fn perform(&mut self, action: FileAction, document: &Document) -> Vec<FileEvent> {
        self.stage = Stage::Idle;
        match action {
            FileAction::New => vec![FileEvent::Command(commands::new_scene())],
            FileAction::OpenFile(path) => vec![line("load", &path)],
            FileAction::Leave => vec![FileEvent::Leave],
            FileAction::Save => match &document.file {
                Some(file) => vec![line("save", file)],
                None => self.choose(FileKind::Save, document, None),
            },
            FileAction::Open => self.choose(FileKind::Open, document, None),
            FileAction::SaveAs => self.choose(FileKind::Save, document, None),
            FileAction::Import => self.choose(FileKind::Import, document, None),
            FileAction::Export => self.choose(FileKind::Export, document, None),
            FileAction::Render => self.choose(FileKind::Render, document, None),
        }
    }

    fn choose(&mut self, kind: FileKind, document: &Document, then: Option<FileAction>) -> Vec<FileEvent> {
        let dialog = FileDialog::new(kind, document.file.as_deref());
        self.stage = Stage::Choosing(Box::new(dialog), then);
        Vec::new()
    }

    fn answer(&mut self, then: FileAction, answer: Answer, document: &Document) -> Vec<FileEvent> {
        match (answer, &document.file) {
            (Answer::Save, Some(file)) => {
                self.stage = Stage::Saving(then);
                vec![line("save", file)]
            }
            (Answer::Save, None) => self.choose(FileKind::Save, document, Some(then)),
            (Answer::Discard, _) => self.perform(then, document),
            (Answer::Cancel, _) => Vec::new(),
        }
    }

    fn chosen(&mut self, dialog: &FileDialog, path: &Path, then: Option<FileAction>) -> Vec<FileEvent> {
        if let Some(then) = then {
            self.stage = Stage::Saving(then);
        }
        let command = match dialog.kind() {
            FileKind::Open => "load",
            FileKind::Import => "include",
            FileKind::Render => "render",
            // The dialog has asked about a file that is there.
            FileKind::Export => "export!",
            // The dialog has asked about a file that is there.
            FileKind::Save => "save!",
        };
        vec![line(command, path)]
    }

    /// Draws the question or the dialog, if there is one.
    pub(crate) fn show(&mut self, ui: &Ui, document: &Document) -> Vec<FileEvent> {
        let is_fresh = std::mem::take(&mut self.is_fresh);
        let is_escaped = !is_fresh && ui.input(|input| input.key_pressed(Key::Escape));
        match std::mem::take(&mut self.stage) {
            Stage::Asking(then) => match ask(ui, &then, document, is_escaped) {
                Some(answer) => self.answer(then, answer, document),
                None => {
                    self.stage = Stage::Asking(then);
                    Vec::new()
                }
            },
            Stage::Choosing(mut dialog, then) => match dialog.show(ui, &document.recent, is_escaped) {
                Some(Chosen::File(path)) => self.chosen(&dialog, &path, then),
                Some(Chosen::Cancelled) => Vec::new(),
                None => {
                    self.stage = Stage::Choosing(dialog, then);
                    Vec::new()
                }
            },
            stage @ (Stage::Idle | Stage::Saving(_)) => {
                self.stage = stage;
                Vec::new()
            }
        }
    }
}

/// The line of a command with a file.
fn line(command: &str, path: &Path) -> FileEvent {
    match commands::with_file(command, &within_working_folder(path)) {
        Some(line) => FileEvent::Command(line),
        None => FileEvent::Notice(format!(
            "'{}' cannot be named in a line of the language; rename the file",
            path.display()
        )),
    }
}

/// The path from the working folder if it is within it, which is shorter in the history.
fn within_working_folder(path: &Path) -> PathBuf {
    let folder = std::env::current_dir().ok();
    let shorter = folder.and_then(|folder| path.strip_prefix(folder).map(Path::to_owned).ok());
    shorter.unwrap_or_else(|| path.to_owned())
}

/// The name of the session's file for people.
pub(crate) fn document_name(document: &Document) -> String {
    let name = document.file.as_deref().and_then(Path::file_name);
    name.map_or_else(|| "untitled".to_owned(), |name| name.to_string_lossy().into_owned())
}

/// Asks about unsaved changes. `None` while there is no answer.
fn ask(ui: &Ui, then: &FileAction, document: &Document, is_escaped: bool) -> Option<Answer> {
    let mut answer = None;
    let before = match then {
        FileAction::Leave => "before closing",
        FileAction::New => "before a new scene begins",
        _ => "before another scene is opened",
    };
    let modal = Modal::new(egui::Id::unique("unsaved changes")).show(ui.ctx(), |ui| {
        ui.set_max_width(360.0);
        ui.heading(format!("Save '{}' {before}?", document_name(document)));
        ui.label("It has changes that are not saved.");
        ui.add_space(8.0);
        ui.horizontal(|ui| {
            let save = ui.button("Save");
            if ui.memory(|memory| memory.focused().is_none()) {
                save.request_focus();
            }
            for (response, is) in [
                (save, Answer::Save),
                (ui.button("Don't save"), Answer::Discard),
                (ui.button("Cancel"), Answer::Cancel),
            ] {
                if response.clicked() {
                    answer = Some(is);
                }
            }
        });
    });
    if is_escaped || modal.backdrop_response.clicked() {
        answer = answer.or(Some(Answer::Cancel));
    }
    answer
}

#[cfg(test)]
mod tests {
    use super::*;

    fn document(file: Option<&str>, is_unsaved: bool) -> Document {
        let file = file.map(PathBuf::from);
        Document { file, is_unsaved, ends_with_window: true, ..Document::default() }
    }

    fn command(line: &str) -> Vec<FileEvent> {
        vec![FileEvent::Command(line.to_owned())]
    }

    #[test]
    fn a_saved_scene_is_replaced_and_left_without_a_question() {
        let mut files = Files::default();
        let saved = document(Some("a b.scn"), false);
        assert_eq!(files.begin(FileAction::New, &saved), command("new"));
        assert_eq!(files.begin(FileAction::OpenFile("c.scn".into()), &saved), command("load \"c.scn\""));
        assert_eq!(files.begin(FileAction::Leave, &saved), [FileEvent::Leave]);
        assert_eq!(files.begin(FileAction::Save, &saved), command("save \"a b.scn\""));
        assert!(!files.is_open());
        // Beside a prompt the session outlives the window.
        let beside = Document { ends_with_window: false, ..document(None, true) };
        assert_eq!(files.begin(FileAction::Leave, &beside), [FileEvent::Leave]);
        assert!(matches!(files.begin(FileAction::OpenFile("a\"b".into()), &saved)[0], FileEvent::Notice(_)));
    }

    #[test]
    fn unsaved_changes_are_asked_about_and_saved_first() {
        for action in [FileAction::New, FileAction::Leave, FileAction::OpenFile("c.scn".into())] {
            let unsaved = document(Some("a.scn"), true);
            let begin = |files: &mut Files| {
                assert!(files.begin(action.clone(), &unsaved).is_empty() && files.is_open());
                let Stage::Asking(then) = std::mem::take(&mut files.stage) else { panic!("{action:?}") };
                then
            };
            let mut files = Files::default();
            let done = files.perform(action.clone(), &unsaved);
            let then = begin(&mut files);
            assert!(files.answer(then, Answer::Cancel, &unsaved).is_empty() && !files.is_open());
            let then = begin(&mut files);
            assert_eq!(files.answer(then, Answer::Discard, &unsaved), done);
            let then = begin(&mut files);
            assert_eq!(files.answer(then, Answer::Save, &unsaved), command("save \"a.scn\""));
            assert!(files.on_snapshot(&unsaved).is_empty());
            assert_eq!(files.on_snapshot(&document(Some("a.scn"), false)), done);
            // A save that fails keeps everything.
            let then = begin(&mut files);
            files.answer(then, Answer::Save, &unsaved);
            files.on_failure();
            assert!(files.on_snapshot(&document(Some("a.scn"), false)).is_empty());
            // Without a file one is chosen first.
            let then = begin(&mut files);
            assert!(files.answer(then, Answer::Save, &document(None, true)).is_empty() && files.is_open());
        }
    }
}
