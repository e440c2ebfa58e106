//! Messages between a session and its window: snapshots go in, lines come out.

use std::path::PathBuf;

use superegg_scene::{Scene, ViewSettings};
use thiserror::Error;

/// A snapshot of the session for the window.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Shown {
    /// The scene.
    pub scene: Scene,
    /// The selected primitive or object. The window shows it.
    pub selected: Option<String>,
    /// The switches of the view.
    pub settings: ViewSettings,
    /// The frames that the user can choose from; `None` if the scene does not move.
    pub frames: Option<Frames>,
    /// The file of the session.
    pub document: Document,
}

/// The scene file of a session, and what the window needs to know before it replaces or leaves it.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Document {
    /// The scene file last loaded or saved; `None` for a scene without one.
    pub file: Option<PathBuf>,
    /// The scene has changes that are not saved.
    pub is_unsaved: bool,
    /// Scene files of this and of earlier sessions, the latest first.
    pub recent: Vec<PathBuf>,
    /// The session ends with the window, because there is no prompt.
    pub ends_with_window: bool,
    /// The description of an earlier session that ended without a save.
    pub unsaved_before: Option<String>,
}

/// The frames of a series.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Frames {
    /// The number of frames, at least 1.
    pub count: usize,
    /// The index of the frame of the snapshot, less than `count`.
    pub current: usize,
}

/// A message from the window to the session.
#[derive(Clone, Debug, PartialEq)]
pub enum FromViewer {
    /// A line of the modelling language to run.
    Command(String),
    /// Lines of the modelling language to run as one change.
    Change {
        /// The name of the change in the history.
        label: String,
        /// The lines.
        lines: Vec<String>,
    },
    /// A key or the panel has changed the switches of the view.
    Settings(ViewSettings),
    /// Show the frame of this index.
    Frame(usize),
    /// A text for the user at the prompt.
    Message(String),
    /// Return the keyboard to the prompt.
    KeyboardBack,
    /// The window is closed: by the user, who has been asked about unsaved changes, by
    /// [`crate::ViewerHandle::close`], or after a failure. [`crate::ViewerHandle::open`] can open it
    /// again, unless a [`FromViewer::Message`] has reported the loss of the display.
    Closed {
        /// The user has closed it.
        by_user: bool,
    },
}

/// There can be no window.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum NoWindow {
    /// There is no display. The text is the reason.
    #[error("there is no display to open a window on ({0}); everything but the viewer works without one")]
    NoDisplay(String),
    /// The crate is compiled without the feature `window`.
    #[error(
        "this superegg is built without its window; `cargo build --release --features viewer` builds it with one"
    )]
    NotBuilt,
}
