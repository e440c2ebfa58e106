//! The link from a session to its viewer: snapshots of the scene go out.

use superegg_lang::{Fault, FaultCode, Session};
use superegg_scene::Scene;
use superegg_viewer::{Document, Frames, Shown, ViewerHandle};

/// The viewer of a session, if there is one.
#[derive(Default)]
pub(super) struct ViewerLink {
    handle: Option<ViewerHandle>,
    /// Why there is no viewer.
    unavailable: Option<String>,
    /// Lines from the viewer that are not yet in the history of the prompt.
    lines: Vec<String>,
    /// The frame that the viewer shows.
    frame: Option<ShownFrame>,
    /// A line from the viewer is being run: what it prints is shown in the window too.
    is_answering: bool,
}

/// A frame of data. The viewer shows it in place of the session's own tables, so that all else that
/// the user has changed stays.
pub(crate) struct ShownFrame {
    pub(crate) frames: Frames,
    /// The scene of the frame.
    pub(crate) scene: Scene,
}

impl ViewerLink {
    pub(super) fn attach(&mut self, handle: ViewerHandle) {
        self.handle = Some(handle);
    }

    /// Removes the viewer. Commands that need it report the reason.
    pub(super) fn detach(&mut self, reason: String) {
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

    /// The scene and the settings that the viewer shows.
    pub(super) fn snapshot(&self, session: &Session, document: Document) -> Shown {
        let mut scene = session.scene().clone();
        if let Some(frame) = &self.frame {
            scene.share_tables(&frame.scene);
        }
        Shown {
            scene,
            selected: session.selected().map(str::to_owned),
            settings: session.settings.view,
            frames: self.frame.as_ref().map(|frame| frame.frames),
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
