//! Actions with files, the title of the window, and leaving it.

use super::app::App;
use crate::input::FileAction;
use crate::panel::{FileEvent, document_name};
use crate::protocol::{Document, FromViewer};

const PROGRAM: &str = "Superegg";

impl App {
    /// Begins an action with files.
    pub(super) fn begin_file_action(&mut self, action: FileAction) {
        let events = self.files.begin(action, self.content.document());
        self.on_file_events(events);
        self.redraw();
    }

    /// Returns the keyboard to the prompt. A window without a prompt closes.
    pub(super) fn keyboard_back(&mut self) {
        if self.content.document().ends_with_window {
            self.begin_file_action(FileAction::Leave);
        } else {
            self.outbox.send(FromViewer::KeyboardBack);
        }
    }

    /// Takes over the file of a new snapshot.
    pub(super) fn after_snapshot(&mut self) {
        self.update_title();
        let events = self.files.on_snapshot(self.content.document());
        self.on_file_events(events);
    }

    fn on_file_events(&mut self, events: Vec<FileEvent>) {
        events.into_iter().for_each(|event| self.on_file_event(event));
    }

    pub(super) fn on_file_event(&mut self, event: FileEvent) {
        match event {
            FileEvent::Command(line) => self.outbox.command(line),
            FileEvent::Leave => self.close(true),
            FileEvent::Notice(text) => self.report(text),
        }
    }

    pub(super) fn update_title(&self) {
        if let Some(open) = &self.window {
            open.surface.window.set_title(&title(self.content.document()));
        }
    }
}

/// The title of the window: the file, with a star if it has unsaved changes.
fn title(document: &Document) -> String {
    if document.file.is_none() && !document.is_unsaved {
        return PROGRAM.to_owned();
    }
    let star = if document.is_unsaved { "*" } else { "" };
    format!("{}{star} - {PROGRAM}", document_name(document))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unsaved_changes_are_marked_in_the_title() {
        let title_of = |file: Option<&str>, is_unsaved| {
            title(&Document { file: file.map(Into::into), is_unsaved, ..Document::default() })
        };
        assert_eq!(title_of(None, false), "Superegg");
        assert_eq!(title_of(None, true), "untitled* - Superegg");
        assert_eq!(title_of(Some("/x/a.scn"), false), "a.scn - Superegg");
        assert_eq!(title_of(Some("a.scn"), true), "a.scn* - Superegg");
    }
}
