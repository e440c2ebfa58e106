//! The modeller: a session with the world around it. It takes lines, from a prompt, a pipe or a file, and does all that they say.

mod journal;
mod known_files;
mod preview;
mod renders;
mod requests;
mod tree;
mod viewer_link;
mod voice;

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use anyhow::Result;
use superegg_lang::{Diagnostic, Effect, Fault, Request, Session, Severity, Timeline, parse_line};

use crate::folders::Folders;
use crate::load::Loaded;
use crate::modeller::journal::{Journal, LeftBehind, Record, left_behind};
use crate::modeller::known_files::KnownFiles;
use crate::modeller::renders::Renders;
use crate::modeller::viewer_link::ViewerLink;
pub(crate) use crate::modeller::voice::{Said, Voice, visible};

/// No line is longer, in bytes.
pub(crate) const LONGEST_LINE: usize = 1 << 20;

/// Where the lines come from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Input {
    /// A person at a terminal, who sees what was typed and can be asked.
    Person,
    /// A pipe or file of this name, which cannot.
    Lines(String),
}

/// Whether to go on after a line.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Reply {
    /// With the next line.
    Continue,
    /// With the answer to this question, yes or no.
    Ask(String),
    /// No further.
    Leave,
}

/// What waits to be done.
enum Pending {
    /// Leaving.
    Leave,
    /// Taking a file that has been read.
    Load { loaded: Box<Loaded>, path: PathBuf, label: String },
    /// Taking a session that was left.
    Recover(LeftBehind),
}

/// A session with its past, its files, its pictures and its journal.
pub(crate) struct Modeller {
    timeline: Timeline,
    input: Input,
    folders: Folders,
    /// The lines entered, those that failed too.
    typed: Vec<String>,
    /// The scene file last loaded or saved.
    scene_file: Option<PathBuf>,
    known: KnownFiles,
    journal: Journal,
    renders: Renders,
    voice: Voice,
    /// Turns true when the person breaks off what runs.
    interrupt: Arc<AtomicBool>,
    /// What waits for the answer to a question.
    pending: Option<Pending>,
    has_errors: bool,
    /// Standard output can no longer be written.
    broken: Option<anyhow::Error>,
    viewer: ViewerLink,
}

impl Modeller {
    /// An empty scene. A journal is kept where `is_journaled`.
    pub(crate) fn new(input: Input, is_journaled: bool, voice: Voice, interrupt: Arc<AtomicBool>) -> Self {
        let folders = Folders::of_user();
        let journals = folders.journals().filter(|_| is_journaled);
        Self {
            timeline: Timeline::default(),
            input,
            typed: Vec::new(),
            scene_file: None,
            known: KnownFiles::default(),
            journal: Journal::new(journals),
            renders: Renders::new(Arc::clone(&voice)),
            voice,
            folders,
            interrupt,
            pending: None,
            has_errors: false,
            broken: None,
            viewer: ViewerLink::default(),
        }
    }

    /// The same with a scene that was loaded already, and this selected in it.
    pub(crate) fn with_scene(mut self, session: Session, root: Option<&str>) -> Self {
        self.timeline = Timeline::beginning_with(session, root);
        self
    }

    pub(crate) fn session(&self) -> &Session {
        self.timeline.session()
    }

    pub(crate) fn folders(&self) -> &Folders {
        &self.folders
    }

    pub(crate) fn has_person(&self) -> bool {
        self.input == Input::Person
    }

    /// Opens a scene as if its name had been loaded.
    pub(crate) fn open(&mut self, file: &str) -> Reply {
        let request = Request::Source { file: Some(file.to_owned()), is_forced: false };
        if let Err(fault) = self.carry_out(&request, &format!("load {file}")) {
            self.complain(&Diagnostic::of_line("", 1, "", fault));
        }
        self.reply()
    }

    /// Takes one line, and tells all that is to be told about it.
    pub(crate) fn enter(&mut self, line: &str) -> Reply {
        if line.len() > LONGEST_LINE {
            let fault = Fault::new("too-long", format!("a line has {LONGEST_LINE} bytes at most"));
            self.refuse("", fault.help("is it a text at all?").at(0..1));
            return self.reply();
        }
        self.typed.push(line.to_owned());
        self.interrupt.store(false, Ordering::Relaxed);
        if let Err(fault) = self.try_enter(line) {
            self.tell_fault(line, fault);
        }
        self.reply()
    }

    /// A line that is none, such as one that is no text.
    pub(crate) fn refuse(&mut self, line: &str, fault: Fault) {
        self.typed.push(line.to_owned());
        self.tell_fault(line, fault);
    }

    /// Takes the answer to the question that was asked.
    pub(crate) fn answer(&mut self, yes: bool) -> Reply {
        match self.pending.take() {
            Some(pending) if yes => self.finish(pending),
            Some(_) => self.print("nothing has changed"),
            None => {}
        }
        self.reply()
    }

    fn reply(&mut self) -> Reply {
        self.show_in_viewer();
        match &self.pending {
            _ if self.broken.is_some() => Reply::Leave,
            Some(Pending::Leave) => Reply::Leave,
            Some(_) => Reply::Ask("the scene has changes that are not saved; replace it even so?".to_owned()),
            None => Reply::Continue,
        }
    }

    fn try_enter(&mut self, line: &str) -> Result<(), Fault> {
        match self.timeline.run_line(line)? {
            Effect::Done => {}
            Effect::Changed(told) => {
                self.write_down(Record::Line(line));
                if let Some(told) = told {
                    self.print(&told);
                }
            }
            Effect::Print(text) => self.print(&text),
            Effect::Ask(Request::Stop) => self.pending = Some(Pending::Leave),
            Effect::Ask(request) => {
                self.carry_out(&request, line).map_err(|fault| place_at_argument(fault, line, 1))?;
            }
        }
        Ok(())
    }

    fn write_down(&mut self, record: Record<'_>) {
        if let Some(trouble) = self.journal.append(record) {
            self.say(Said::Complaint(format!("superegg: {trouble}")));
        }
    }

    fn say(&mut self, said: Said) {
        if let Err(error) = (self.voice)(said) {
            self.broken.get_or_insert(error);
        }
    }

    /// Shows text, with what could steer a terminal made visible.
    fn print(&mut self, text: &str) {
        self.print_raw(&visible(text));
    }

    fn print_raw(&mut self, text: &str) {
        self.say(Said::Text(text.to_owned()));
    }

    fn tell_fault(&mut self, line: &str, fault: Fault) {
        let file = match &self.input {
            Input::Person => "",
            Input::Lines(name) => name,
        };
        self.complain(&Diagnostic::of_line(file, self.typed.len(), line, fault));
    }

    fn complain(&mut self, diagnostic: &Diagnostic) {
        self.has_errors |= diagnostic.severity == Severity::Error;
        self.say(Said::Complaint(visible(&diagnostic.to_string())));
    }

    /// Stops what runs behind the prompt, if anything does.
    pub(crate) fn stop_renders(&self) -> bool {
        self.renders.stop() > 0
    }

    /// The sessions that ended without being saved.
    fn left_behind(&self) -> Vec<LeftBehind> {
        self.folders.journals().map_or_else(Vec::new, |journals| left_behind(&journals))
    }

    /// Tells a person of sessions that ended without being saved.
    pub(crate) fn offer_recovery(&mut self) {
        let left = self.left_behind();
        if let Some(last) = left.first() {
            let told = requests::tell_left_behind(last);
            self.print(&format!("A session was not saved: {told}."));
            self.print(&match left.len() {
                1 => "'recover' brings it back, 'recover discard' forgets it.".to_owned(),
                count => format!("'recover' brings it back, 'recover list' tells of all {count}."),
            });
        }
    }

    /// Ends the session: waits for pictures, and leaves the journal where a person has changes that are not saved. Returns whether there
    /// were errors.
    ///
    /// # Errors
    /// Standard output could not be written.
    pub(crate) fn leave(&mut self) -> Result<bool> {
        self.interrupt.store(false, Ordering::Relaxed);
        if self.renders.is_busy() && self.has_person() {
            self.print("waiting for the picture (ctrl-c stops it)");
        }
        self.renders.wait(&self.interrupt);
        if self.has_person() && self.timeline.has_unsaved_changes() {
            self.print("The scene was not saved; the next start offers it again.");
            self.journal.keep();
        } else {
            self.journal.discard();
        }
        match self.broken.take() {
            Some(error) => Err(error),
            None => Ok(self.has_errors || self.renders.has_failed()),
        }
    }
}

/// A fault of a request without a place stands at this argument, or at the command where there is none.
fn place_at_argument(fault: Fault, line: &str, argument: usize) -> Fault {
    if fault.columns.is_some() {
        return fault;
    }
    let columns = parse_line(line).ok().flatten().map(|parsed| parsed.columns).unwrap_or_default();
    match columns.get(argument).or(columns.first()) {
        Some(columns) => fault.at(columns.clone()),
        None => fault,
    }
}
