//! Runs input lines and ends the session.

use std::borrow::Cow;
use std::path::Path;
use std::sync::atomic::Ordering;

use anyhow::Result;
use superegg_lang::{
    Command, Diagnostic, Effect, Fault, FaultCode, Request, SessionCommand, creation_note, parse_line,
    rename_in_line, split_commands, visible,
};
use superegg_viewer::FromViewer;

use crate::files::names::{name_seen_from, path_seen_from};
use crate::modeller::faults::at_argument;
use crate::modeller::journal::Record;
use crate::modeller::reporter::Message;
use crate::modeller::requests::run_request;
use crate::modeller::state::{Modeller, Pending, Reply};
use crate::text::counted;

/// The maximum length of a line in bytes.
pub(crate) const LONGEST_LINE: usize = 1 << 20;

impl Modeller {
    /// Opens a scene file, as the command `load` does.
    pub(crate) fn open(&mut self, file: &str) -> Reply {
        let request = Request::Source { file: Some(file.to_owned()), is_forced: false };
        if let Err(fault) = run_request(self, &request, &format!("load {file}")) {
            self.report_diagnostic(&Diagnostic::of_line("", 1, "", fault));
        }
        if self.timeline.undo_count() > 0 {
            self.timeline.mark_start();
        }
        self.reply()
    }

    /// Runs one line, which may have several commands, and reports their results. A fault ends the
    /// line.
    pub(crate) fn enter(&mut self, line: &str) -> Reply {
        if line.len() > LONGEST_LINE {
            let fault = Fault::new(FaultCode::TooLong, format!("a line has {LONGEST_LINE} bytes at most"));
            self.reject("", fault.help("is it a text at all?").at(0..1));
            return self.reply();
        }
        self.lines.push(line.to_owned());
        self.interrupt.store(false, Ordering::Relaxed);
        if self.is_interactive() {
            self.queue_commands(line);
        } else {
            // In a file a name may end in a `;`, so only a line that is no command is several.
            self.waiting = vec![(0, line.to_owned())];
        }
        self.run_waiting(line);
        self.reply()
    }

    /// Puts the commands of a line in the queue, with their columns.
    fn queue_commands(&mut self, line: &str) {
        let commands = split_commands(line).into_iter().rev();
        self.waiting = commands.map(|(column, command)| (column, command.to_owned())).collect();
    }

    /// Runs the waiting commands of a line until one asks a question, has a fault or is interrupted.
    fn run_waiting(&mut self, line: &str) {
        while self.pending.is_none() && !self.interrupt.load(Ordering::Relaxed) {
            let Some((column, command)) = self.waiting.pop() else { return };
            if let Err(fault) = self.run_line(&self.seen_from_folder(&command)) {
                if command.len() == line.len() && line.contains(';') {
                    self.queue_commands(line);
                    if self.waiting.iter().any(|(_, command)| command.len() < line.len()) {
                        continue;
                    }
                }
                self.waiting.clear();
                self.report_fault(line, fault.moved(column));
            }
        }
    }

    /// Rejects a line that cannot be run, such as one that is not valid UTF-8.
    pub(crate) fn reject(&mut self, line: &str, fault: Fault) {
        self.lines.push(line.to_owned());
        self.report_fault(line, fault);
    }

    /// Runs or drops the pending action.
    pub(crate) fn answer(&mut self, yes: bool) -> Reply {
        match self.pending.take() {
            Some(pending) if yes => self.finish(pending),
            Some(_) => {
                self.waiting.clear();
                self.print("nothing has changed");
            }
            None => {}
        }
        let line = self.lines.last().cloned().unwrap_or_default();
        self.run_waiting(&line);
        self.reply()
    }

    fn reply(&mut self) -> Reply {
        self.after_line();
        match &self.pending {
            _ if self.output_error.is_some() => Reply::Leave,
            Some(Pending::Leave) => Reply::Leave,
            Some(Pending::Load { .. } | Pending::Recover(_) | Pending::New { .. }) => {
                Reply::Ask("the scene has changes that are not saved; replace it even so?".to_owned())
            }
            Some(Pending::Discard(sessions)) => {
                let sessions = counted(sessions.len(), "unsaved session");
                Reply::Ask(format!("{sessions} will be lost for good; forget them?"))
            }
            None => Reply::Continue,
        }
    }

    /// Shows the result of a line in the viewer, and keeps what is kept between sessions.
    fn after_line(&mut self) {
        self.keep_settings();
        self.document.on_changes(self.timeline.undo_count());
        self.update_viewer();
    }

    /// A typed line with the name of its picture as seen from the session's folder.
    fn seen_from_folder<'l>(&self, line: &'l str) -> Cow<'l, str> {
        rename_in_line(line, |name| name_seen_from(&self.folder, name, &path_seen_from(Path::new("."), name)))
    }

    fn run_line(&mut self, line: &str) -> Result<(), Fault> {
        let before = self.is_interactive().then(|| self.session().clone());
        match self.timeline.run_line(line)? {
            Effect::Done => {}
            Effect::Changed(text) => {
                self.record(Record::Line(line));
                let note = before.and_then(|before| creation_note(&before, self.session()));
                for text in text.into_iter().chain(note) {
                    self.print(&text);
                }
            }
            Effect::Print(text) if is_help(line) => self.report(Message::Page(visible(&text))),
            Effect::Print(text) => self.print(&text),
            Effect::Request(Request::Stop) => self.pending = Some(Pending::Leave),
            Effect::Request(request) => {
                run_request(self, &request, line).map_err(|fault| at_argument(fault, line, 1))?;
            }
        }
        Ok(())
    }

    /// Wraps texts to a terminal of so many columns from now on.
    pub(crate) fn set_columns(&mut self, columns: u16) {
        let mut settings = self.session().settings;
        settings.columns = columns;
        self.timeline.set_settings(settings);
    }

    /// Handles an event of the viewer.
    pub(crate) fn handle_viewer_event(&mut self, event: FromViewer) {
        match event {
            FromViewer::Command(line) => {
                self.viewer.set_answering(true);
                self.run_viewer_line(&line);
                self.viewer.set_answering(false);
                self.after_line();
            }
            FromViewer::Change { label, lines } => {
                self.viewer.set_answering(true);
                self.run_viewer_change(&label, &lines);
                self.viewer.set_answering(false);
                self.after_line();
            }
            FromViewer::Settings(view) => {
                let mut settings = self.session().settings;
                settings.view = view;
                self.timeline.set_settings(settings);
                self.keep_settings();
            }
            FromViewer::Message(text) => self.print(&text),
            // Frames of data belong to the program that opened the window.
            FromViewer::Frame(frame) => match self.viewer.set_key_frame(self.timeline.session(), frame) {
                Ok(true) => self.update_viewer(),
                Ok(false) => {}
                Err(fault) => self.viewer.notice(fault.message),
            },
            FromViewer::KeyboardBack | FromViewer::Closed { .. } => {}
        }
    }

    /// Runs lines of the viewer as one change.
    fn run_viewer_change(&mut self, label: &str, lines: &[String]) {
        for line in lines {
            self.report(Message::Text(visible(&format!("> {line}"))));
            self.viewer.push_line(line.clone());
            self.lines.push(line.clone());
        }
        let text = lines.join("\n") + "\n";
        match self.timeline.run_lines(label, &text) {
            Ok(()) => self.record(Record::Lines { label, lines: &text }),
            Err(fault) => {
                self.viewer.notice(fault.message.clone());
                self.report_fault(lines.last().map_or("", String::as_str), fault);
            }
        }
    }

    fn run_viewer_line(&mut self, line: &str) {
        self.report(Message::Text(visible(&format!("> {line}"))));
        self.viewer.push_line(line.to_owned());
        self.lines.push(line.to_owned());
        // The question at the prompt stays open.
        let asked = self.pending.take();
        if let Err(fault) = self.run_line(line) {
            let help = fault.help.as_ref().map(|help| format!("; {help}")).unwrap_or_default();
            self.viewer.notice(format!("{}{help}", fault.message));
            self.report_fault(line, fault);
        }
        // The window has asked about unsaved changes.
        if let Some(confirmed) = self.pending.take() {
            self.finish(confirmed);
        }
        self.pending = asked;
    }

    /// Offers a person the sessions that ended without a save.
    pub(crate) fn offer_recovery(&mut self) {
        let unsaved = self.unsaved_sessions();
        if let Some(last) = unsaved.first() {
            self.print(&format!("A session was not saved: {}.", last.describe()));
            self.print(&match unsaved.len() {
                1 => "'recover' brings it back, 'recover discard' forgets it.".to_owned(),
                count => format!("'recover' brings it back, 'recover list' lists all {count}."),
            });
        }
    }

    /// Ends the session: waits for the renders, and keeps the journal if a person has unsaved
    /// changes. Returns whether there were errors.
    ///
    /// # Errors
    /// Standard output could not be written.
    pub(crate) fn leave(&mut self) -> Result<bool> {
        self.end(self.is_interactive())
    }

    /// Ends a session without a prompt, as [`Self::leave`]. A user who closes the window has been
    /// asked about unsaved changes, so that they are kept only if something else has closed it.
    ///
    /// # Errors
    /// Standard output could not be written.
    pub(crate) fn leave_window(&mut self, by_user: bool) -> Result<bool> {
        self.end(!by_user)
    }

    fn end(&mut self, keeps_unsaved: bool) -> Result<bool> {
        self.interrupt.store(false, Ordering::Relaxed);
        if self.renders.is_busy() && self.is_interactive() {
            self.print("waiting for the picture (ctrl-c stops it)");
        }
        self.renders.wait(&self.interrupt);
        self.report_remaining_faults();
        if keeps_unsaved && self.timeline.has_unsaved_changes() {
            self.print("The scene was not saved; the next start offers it again.");
            self.journal.keep();
        } else {
            self.journal.discard();
        }
        match self.output_error.take() {
            Some(error) => Err(error),
            None => Ok(self.has_errors || self.renders.has_failed()),
        }
    }
}

/// Whether a line asks for help.
fn is_help(line: &str) -> bool {
    let parsed = parse_line(line).ok().flatten();
    parsed.is_some_and(|parsed| matches!(parsed.command, Command::Session(SessionCommand::Help(_))))
}
