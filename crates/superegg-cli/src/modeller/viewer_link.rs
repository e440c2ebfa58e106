//! The link from a session to its viewer: snapshots of the scene go out.

use std::sync::{Arc, Mutex, PoisonError};

use superegg_lang::{Fault, FaultCode, Session, scene_at};
use superegg_scene::Scene;
use superegg_viewer::{Document, Frames, Shown, ViewerHandle};

use crate::modeller::reporter::{Message, Reporter};

/// The viewer of a session, if there is one.
#[derive(Default)]
pub(super) struct ViewerLink {
    handle: Option<ViewerHandle>,
    /// The same for the thread that renders.
    shared: SharedHandle,
    /// Why there is no viewer.
    unavailable: Option<String>,
    /// Lines from the viewer that are not yet in the history of the prompt.
    lines: Vec<String>,
    /// The frame that the viewer shows.
    frame: Option<ShownFrame>,
    /// The frame of the scene's keys that the viewer shows; `None` for the scene without keys.
    key_frame: Option<usize>,
    /// A line from the viewer is being run: what it prints is shown in the window too.
    is_answering: bool,
}

/// A handle that other threads see once it is there.
#[derive(Clone, Default)]
pub(super) struct SharedHandle(Arc<Mutex<Option<ViewerHandle>>>);

impl SharedHandle {
    fn set(&self, handle: Option<ViewerHandle>) {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) = handle;
    }

    /// Shows a message of a picture in the window.
    fn show(&self, message: &Message) {
        let handle = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let Some(handle) = handle.as_ref() else { return };
        match message {
            Message::Progress(text) => handle.rendering(Some(text.clone())),
            Message::Done(text) | Message::Failed(text) => {
                handle.rendering(None);
                handle.inform(text.clone());
            }
            Message::Text(_) | Message::Diagnostic(_) | Message::Page(_) => {}
        }
    }

    /// A reporter that shows its messages in the window, too.
    pub(super) fn reporter(&self, reporter: &Reporter) -> Reporter {
        let (shared, reporter) = (self.clone(), Arc::clone(reporter));
        Arc::new(move |message| {
            shared.show(&message);
            reporter(message)
        })
    }
}

/// A frame of data. The viewer shows it in place of the session's own tables, so that all else that
/// the user has changed stays.
pub(crate) struct ShownFrame {
    pub(crate) frames: Frames,
    /// The scene of the frame.
    pub(crate) scene: Scene,
}

/// The number of frames of a scene's keys: up to the last key.
fn key_frame_count(session: &Session) -> usize {
    let keys = session.scene().tracks().flat_map(superegg_scene::Track::keys);
    let last = keys.map(|key| key.frame).fold(-1.0, f64::max);
    (last.floor().clamp(-1.0, MOST_FRAMES) + 1.0) as usize
}

/// Most frames of keys that the viewer shows.
const MOST_FRAMES: f64 = 1e6;

impl ViewerLink {
    pub(super) fn attach(&mut self, handle: ViewerHandle) {
        self.shared.set(Some(handle.clone()));
        self.handle = Some(handle);
    }

    /// The handle for the thread that renders.
    pub(super) fn shared(&self) -> &SharedHandle {
        &self.shared
    }

    /// Removes the viewer. Commands that need it report the reason.
    pub(super) fn detach(&mut self, reason: String) {
        self.shared.set(None);
        self.handle = None;
        self.unavailable = Some(reason);
    }

    pub(super) fn is_attached(&self) -> bool {
        self.handle.is_some()
    }

    pub(super) fn show(&self, shown: Shown) {
        if let Some(handle) = &self.handle {
            handle.show(shown);
        }
    }

    /// Begins or ends a line from the viewer.
    pub(super) fn set_answering(&mut self, is_answering: bool) {
        self.is_answering = is_answering;
    }

    /// Whether a line from the viewer is being run.
    pub(super) fn is_answering(&self) -> bool {
        self.is_answering
    }

    /// Shows the first line of an answer to the viewer in its window.
    pub(super) fn answer(&self, text: &str) {
        if let Some(handle) = self.handle.as_ref().filter(|_| self.is_answering) {
            handle.inform(text.lines().next().unwrap_or_default().to_owned());
        }
    }

    /// Output a short message in the window.
    pub(super) fn notice(&self, text: String) {
        if let Some(handle) = &self.handle {
            handle.notice(text);
        }
    }

    /// The viewer, or the fault of a command that needs it.
    pub(super) fn require(&self) -> Result<&ViewerHandle, Fault> {
        self.handle.as_ref().ok_or_else(|| {
            let reason = self.unavailable.as_deref().unwrap_or("a session without a terminal has no window");
            let fault = Fault::new(FaultCode::NoViewer, format!("there is no viewer: {reason}"));
            fault.help("'preview' draws the scene in the terminal, 'render' writes a picture").warning()
        })
    }

    /// Shows a frame from now on.
    pub(super) fn set_frame(&mut self, frame: ShownFrame) {
        self.frame = Some(frame);
    }

    /// Shows a frame of the scene's keys from now on. Returns whether there is such a frame: frames
    /// of data come first.
    ///
    /// # Errors
    /// A keyed command cannot be carried out at the frame.
    pub(super) fn set_key_frame(&mut self, session: &Session, frame: usize) -> Result<bool, Fault> {
        let has_frame = self.frame.is_none() && frame < key_frame_count(session);
        if has_frame {
            scene_at(session, frame as f64)?;
            self.key_frame = Some(frame);
        }
        Ok(has_frame)
    }

    /// The scene and the settings that the viewer shows.
    pub(super) fn snapshot(&self, session: &Session, document: Document) -> Shown {
        let mut scene = session.scene().clone();
        if let Some(frame) = &self.frame {
            scene.share_tables(&frame.scene);
        }
        let mut frames = self.frame.as_ref().map(|frame| frame.frames);
        let count = key_frame_count(session);
        if frames.is_none() && count > 0 {
            let current = self.key_frame.unwrap_or(0).min(count - 1);
            frames = Some(Frames { count, current });
            // A frame that an edit has made impossible is shown without keys.
            if let Some(Ok(still)) = self.key_frame.map(|_| scene_at(session, current as f64)) {
                scene = still;
            }
        }
        Shown {
            scene,
            selected: session.selected().map(str::to_owned),
            settings: session.settings.view,
            frames,
            document,
        }
    }

    pub(super) fn push_line(&mut self, line: String) {
        self.lines.push(line);
    }

    /// The lines that came from the viewer since the last call.
    pub(super) fn drain_lines(&mut self) -> Vec<String> {
        std::mem::take(&mut self.lines)
    }
}
