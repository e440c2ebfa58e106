//! Replaces the scene of a session by a loaded file or by an unsaved session.

use std::path::Path;

use superegg_lang::{Command, Request, Session, Timeline, load_text, parse_line};

use crate::files::names::{name_seen_from, path_seen_from, rename_in_lines};
use crate::files::scene::{Loaded, load};
use crate::modeller::journal::{Record, UnsavedSession, read_records};
use crate::modeller::reporter::Message;
use crate::modeller::state::{Modeller, Pending};
use crate::text::counted;

impl Modeller {
    /// Runs an action that replaces the scene, or leaves it pending if a person has unsaved
    /// changes.
    pub(super) fn finish_or_confirm(&mut self, pending: Pending, is_forced: bool) {
        if self.is_interactive() && !is_forced && self.timeline.has_unsaved_changes() {
            self.pending = Some(pending);
        } else {
            self.finish(pending);
        }
    }

    /// Runs a confirmed action.
    pub(super) fn finish(&mut self, pending: Pending) {
        match pending {
            Pending::Leave => {}
            Pending::Load { loaded, path, label } => {
                let is_its_scene = loaded.is_whole_scene();
                let Loaded { session, lines, prints, .. } = *loaded;
                prints.iter().for_each(|text| self.print(text));
                self.timeline.replace(session, &label, &lines);
                self.timeline.mark_saved();
                self.record(Record::Scene { label: &label, lines: &lines });
                self.record(Record::Saved);
                self.known_files.remember(&path);
                self.document.open(&path, is_its_scene, self.timeline.undo_count());
                if self.answers_person() {
                    let scene = self.session().scene();
                    let text = format!(
                        "{}: {}, {}",
                        path.display(),
                        counted(scene.primitives().count(), "primitive"),
                        counted(scene.objects().count(), "object")
                    );
                    self.print(&text);
                }
                self.scene_file = Some(path);
            }
            Pending::Recover(unsaved) => {
                self.restore(unsaved);
                self.refresh_offer();
            }
            Pending::Discard(sessions) => {
                self.print(&format!("forgotten: {}", counted(sessions.len(), "session")));
                sessions.into_iter().for_each(UnsavedSession::remove);
                self.refresh_offer();
            }
            Pending::New { label } => {
                let mut session = Session::default();
                session.settings = self.session().settings;
                self.timeline.replace(session, &label, "");
                self.timeline.mark_saved();
                self.record(Record::Scene { label: &label, lines: "" });
                self.record(Record::Saved);
                self.scene_file = None;
                self.document.detach(self.timeline.undo_count());
            }
        }
    }

    /// Offers what is left after a session has been restored or discarded.
    fn refresh_offer(&mut self) {
        if self.document.offers_unsaved() {
            self.offer_unsaved_in_viewer();
        }
    }

    fn restore(&mut self, unsaved: UnsavedSession) {
        let recovered = replay(&unsaved.text);
        let folder =
            Some(unsaved.folder()).filter(|folder| folder.is_dir()).unwrap_or(&self.folder).to_owned();
        if self.timeline.undo_count() == 0 && self.journal.is_empty() {
            // The journal of the other session has its own beginning.
            self.document.take_beginning();
            self.folder = folder;
            let settings = self.session().settings;
            self.timeline = recovered;
            self.timeline.set_settings(settings);
            if let Some(trouble) = self.journal.take_over(whole_records(&unsaved.text)) {
                self.report(Message::Diagnostic(format!("superegg: {trouble}")));
            }
        } else {
            let mut new_name =
                |name: &str| name_seen_from(&self.folder, name, &path_seen_from(&folder, name));
            let lines = rename_in_lines(&recovered.typed_lines(), &mut new_name);
            let mut session = recovered.session().clone();
            session.rename_files(&mut new_name);
            session.settings = self.session().settings;
            self.timeline.replace(session, "recover", &lines);
            self.record(Record::Scene { label: "recover", lines: &lines });
        }
        self.document.detach(0);
        let text = unsaved.describe();
        // Keep the old file until this journal contains all of it. That of a script is gone at its end.
        if self.journal.is_written() && self.answers_person() {
            unsaved.remove();
        }
        self.print(&format!("recovered: {text}"));
    }
}

/// The session that results from the records of a journal.
fn replay(text: &str) -> Timeline {
    let mut timeline = Timeline::default();
    for record in read_records(text).unwrap_or_default() {
        match record {
            Record::Line(line) => {
                // The line succeeded when it was recorded.
                let _ = timeline.run_line(line);
            }
            Record::Scene { label, lines } => {
                timeline.replace(session_of(label, lines), label, lines);
            }
            Record::Lines { label, lines } => {
                // They succeeded when they were recorded.
                let _ = timeline.run_lines(label, lines);
            }
            Record::Saved => timeline.mark_saved(),
        }
    }
    timeline
}

/// The session that lines of a journal make. Large data is journalled as the file to load again; if
/// that is gone, so is the data.
fn session_of(label: &str, lines: &str) -> Session {
    let parsed = parse_line(lines.lines().next().unwrap_or_default()).ok().flatten();
    let file = match parsed.map(|parsed| parsed.command) {
        Some(Command::Request(Request::Source { file: Some(file), .. })) if lines.lines().count() == 1 => {
            file
        }
        _ => return load_text(label, lines).0,
    };
    load(Path::new(&file)).map_or_else(|_| Session::default(), |loaded| loaded.session)
}

/// A journal without the incomplete line at its end.
fn whole_records(text: &str) -> &str {
    text.rfind('\n').map_or("", |end| &text[..=end])
}
