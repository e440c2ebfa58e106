//! The state of a modelling session, and the output and journal operations that every request uses.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use superegg_lang::{Diagnostic, Fault, FaultCode, Session, Severity, Timeline, visible};
use superegg_scene::{Scene, ViewSettings};
use superegg_viewer::{Document, Shown, ViewerHandle};

use crate::files::folders::Folders;
use crate::files::kept_settings::{Kept, KeptSettings};
use crate::files::names::use_paths;
use crate::files::scene::Loaded;
use crate::modeller::document::DocumentState;
use crate::modeller::journal::{Journal, Record, UnsavedSession, unsaved_sessions};
use crate::modeller::known_files::KnownFiles;
use crate::modeller::render_queue::RenderQueue;
use crate::modeller::reporter::{Message, Reporter};
use crate::modeller::viewer_link::{ShownFrame, ViewerLink};

/// The source of the input lines.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Input {
    /// A person at a terminal, who sees the input and can answer questions.
    Person,
    /// A pipe or file with this name. It cannot answer questions.
    Lines {
        name: String,
        /// Whether the lines are those of a file, which has an end. The first ones of many errors are
        /// reported and the others counted.
        is_file: bool,
    },
}

/// The maximum number of errors and warnings of a file that are reported one by one.
const MOST_REPORTED: usize = 100;

/// The next step after a line.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Reply {
    /// Read the next line.
    Continue,
    /// Ask this yes-or-no question.
    Ask(String),
    /// End the session.
    Leave,
}

/// An action that waits for confirmation.
pub(super) enum Pending {
    /// End the session.
    Leave,
    /// Replace the scene by a file that has been read.
    Load { loaded: Box<Loaded>, path: PathBuf, label: String },
    /// Replace the scene by an unsaved session.
    Recover(UnsavedSession),
    /// Discard unsaved sessions.
    Discard(Vec<UnsavedSession>),
    /// Begin a new scene.
    New { label: String },
}

/// A session with its undo history, files, render queue, journal and window.
pub(crate) struct Modeller {
    pub(super) timeline: Timeline,
    pub(super) input: Input,
    pub(super) folders: Folders,
    /// The folder in which the session began. The names of files in its scene are seen from there.
    pub(super) folder: PathBuf,
    /// All input lines, including those that failed.
    pub(super) lines: Vec<String>,
    /// The scene file last loaded or saved.
    pub(super) scene_file: Option<PathBuf>,
    pub(super) known_files: KnownFiles,
    pub(super) journal: Journal,
    pub(super) renders: RenderQueue,
    pub(super) reporter: Reporter,
    /// Becomes true when the user interrupts the running command.
    pub(super) interrupt: Arc<AtomicBool>,
    /// The action that waits for an answer.
    pub(super) pending: Option<Pending>,
    /// The commands behind the one that asks, with their columns in the line.
    pub(super) waiting: Vec<(usize, String)>,
    pub(super) has_errors: bool,
    /// The number of errors and warnings of the lines so far.
    faults: usize,
    /// The first error of standard output; no output is possible after it.
    pub(super) output_error: Option<anyhow::Error>,
    pub(super) viewer: ViewerLink,
    /// The settings that are kept for later sessions; `None` if this session leaves them alone.
    kept: Option<KeptSettings>,
    pub(super) document: DocumentState,
}

impl Modeller {
    /// Starts with an empty scene. `is_journaled` enables the autosave journal.
    pub(crate) fn new(
        input: Input,
        is_journaled: bool,
        reporter: Reporter,
        interrupt: Arc<AtomicBool>,
    ) -> Self {
        let folders = Folders::of_user();
        let viewer = ViewerLink::default();
        let folder = std::env::current_dir().unwrap_or_default();
        let journals = folders.journals().filter(|_| is_journaled);
        Self {
            timeline: Timeline::default(),
            input,
            lines: Vec::new(),
            scene_file: None,
            known_files: KnownFiles::default(),
            renders: RenderQueue::new(viewer.shared().reporter(&reporter)),
            reporter,
            folders,
            journal: Journal::new(journals, &folder),
            folder,
            interrupt,
            pending: None,
            waiting: Vec::new(),
            has_errors: false,
            faults: 0,
            output_error: None,
            viewer,
            kept: None,
            document: DocumentState::default(),
        }
    }

    /// Starts from a loaded session with `root` selected.
    pub(crate) fn with_scene(mut self, session: Session, root: Option<&str>) -> Self {
        self.timeline = Timeline::beginning_with(session, root);
        self
    }

    pub(crate) fn session(&self) -> &Session {
        self.timeline.session()
    }

    /// A scene of the session for a picture, which may be rendered after the working folder has changed.
    pub(super) fn scene_to_render(&self, mut scene: Scene) -> Scene {
        use_paths(&mut scene, &self.folder);
        scene
    }

    pub(crate) fn folders(&self) -> &Folders {
        &self.folders
    }

    /// Whether a person at a terminal enters the lines.
    pub(crate) fn is_interactive(&self) -> bool {
        self.input == Input::Person
    }

    /// The selected primitive or object, for a command that needs one.
    pub(super) fn selected_root(&self) -> Result<&str, Fault> {
        self.session().selected().ok_or_else(|| {
            Fault::new(FaultCode::Selection, "nothing is selected")
                .help("'primitive NAME' or 'object NAME' selects what is to be in the picture")
        })
    }

    /// Cancels all background renders. Returns whether there were any.
    pub(crate) fn stop_renders(&self) -> bool {
        self.renders.stop() > 0
    }

    /// Output the scene in this viewer from now on.
    pub(crate) fn attach_viewer(&mut self, handle: ViewerHandle) {
        self.viewer.attach(handle);
    }

    /// Continues without a viewer. Commands that need one report the reason.
    pub(crate) fn detach_viewer(&mut self, reason: String) {
        self.viewer.detach(reason);
    }

    /// Begins with the settings that earlier sessions have kept, or with those of the course program,
    /// and keeps later changes.
    pub(crate) fn use_kept_settings(&mut self, is_course: bool) {
        let mut kept = KeptSettings::read(self.folders.settings());
        let mut settings = self.session().settings;
        if is_course || kept.current().is_course {
            settings.view = ViewSettings::COURSE;
        }
        settings.view.theme = kept.current().theme;
        self.timeline.set_settings(settings);
        kept.set_current(Kept::of(&settings.view));
        self.kept = Some(kept);
        self.document.keep_recent(self.folders.recent());
    }

    /// Keeps a change of the settings that are kept.
    pub(super) fn keep_settings(&mut self) {
        let current = Kept::of(&self.session().settings.view);
        let Some(kept) = &mut self.kept else { return };
        if let Err(error) = kept.keep(current) {
            self.report(Message::Diagnostic(format!("superegg: the setting is not kept: {error:#}")));
        }
    }

    /// Begins to edit a loaded file in a window without a prompt. `is_its_scene` is false if saving to
    /// the file would lose something.
    pub(crate) fn begin_document(&mut self, path: Option<&Path>, is_its_scene: bool) {
        let session = self.session().clone();
        self.document.begin(path.map(|path| (path, session)), is_its_scene);
        if let Some(path) = path.filter(|_| is_its_scene) {
            self.known_files.remember(path);
            self.scene_file = Some(path.to_owned());
        }
        self.offer_unsaved_in_viewer();
    }

    /// Offers the last session that ended without a save in the window.
    pub(super) fn offer_unsaved_in_viewer(&mut self) {
        let description = self.unsaved_sessions().first().map(UnsavedSession::describe);
        self.document.set_unsaved_before(description);
    }

    /// The document as the viewer shows it.
    fn document_of_viewer(&self) -> Document {
        self.document.of_viewer(self.timeline.has_unsaved_changes())
    }

    /// Whether a person sees the answers: at the prompt, or in the window that the line came from.
    pub(super) fn answers_person(&self) -> bool {
        self.is_interactive() || self.viewer.is_answering()
    }

    /// The scene and the settings that a viewer shows now.
    pub(crate) fn snapshot(&self) -> Shown {
        self.viewer.snapshot(self.session(), self.document_of_viewer())
    }

    /// Sends the scene to the viewer.
    pub(super) fn update_viewer(&self) {
        if self.viewer.is_attached() {
            self.viewer.show(self.snapshot());
        }
    }

    /// Shows a frame of data in the viewer from now on, in place of the session's own tables.
    pub(crate) fn show_frame(&mut self, frame: ShownFrame) {
        self.viewer.set_frame(frame);
        self.update_viewer();
    }

    /// Reports in the window and on the console that a request of the viewer has failed.
    pub(crate) fn report_viewer_error(&mut self, text: String) {
        self.report(Message::Diagnostic(format!("superegg: {}", visible(&text))));
        self.viewer.notice(text);
    }

    /// The lines that came from the viewer since the last call.
    pub(crate) fn drain_viewer_lines(&mut self) -> Vec<String> {
        self.viewer.drain_lines()
    }

    /// The sessions that ended without a save, newest first.
    pub(super) fn unsaved_sessions(&self) -> Vec<UnsavedSession> {
        self.folders.journals().map_or_else(Vec::new, |journals| unsaved_sessions(&journals))
    }

    /// Appends a record to the journal and reports a failure.
    pub(super) fn record(&mut self, record: Record<'_>) {
        if let Some(beginning) = self.document.take_beginning() {
            let (label, lines) = (beginning.label(), beginning.lines());
            self.append(Record::Scene { label: &label, lines: &lines });
            self.append(Record::Saved);
        }
        self.append(record);
    }

    fn append(&mut self, record: Record<'_>) {
        if let Some(trouble) = self.journal.append(record) {
            self.report(Message::Diagnostic(format!("superegg: {trouble}")));
        }
    }

    pub(super) fn report(&mut self, message: Message) {
        if let Err(error) = (self.reporter)(message) {
            self.output_error.get_or_insert(error);
        }
    }

    /// Prints text with control characters escaped.
    pub(super) fn print(&mut self, text: &str) {
        self.viewer.answer(text);
        self.print_raw(&visible(text));
    }

    /// Prints text with its control characters.
    pub(super) fn print_raw(&mut self, text: &str) {
        self.report(Message::Text(text.to_owned()));
    }

    /// Reports a fault of the last line.
    pub(super) fn report_fault(&mut self, line: &str, fault: Fault) {
        let file = match &self.input {
            Input::Person => "",
            Input::Lines { name, .. } => name,
        };
        let diagnostic = Diagnostic::of_line(file, self.lines.len(), line, fault);
        self.faults += 1;
        if self.faults > MOST_REPORTED && self.is_file() {
            self.has_errors |= diagnostic.severity == Severity::Error;
        } else {
            self.report_diagnostic(&diagnostic);
        }
        self.timeline.suggest(!(self.faults >= MOST_REPORTED && self.is_file()));
    }

    fn is_file(&self) -> bool {
        matches!(self.input, Input::Lines { is_file: true, .. })
    }

    /// Reports the number of errors and warnings of a file that were not reported one by one.
    pub(super) fn report_remaining_faults(&mut self) {
        let Input::Lines { name, is_file: true } = &self.input else { return };
        if let Some(more @ 1..) = self.faults.checked_sub(MOST_REPORTED) {
            let text =
                format!("{name}: {more} more errors and warnings; the first {MOST_REPORTED} are described");
            self.report(Message::Diagnostic(visible(&text)));
        }
    }

    pub(super) fn report_diagnostic(&mut self, diagnostic: &Diagnostic) {
        self.has_errors |= diagnostic.severity == Severity::Error;
        self.report(Message::Diagnostic(visible(&diagnostic.to_string())));
    }
}
