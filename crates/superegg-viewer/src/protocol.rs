//! What a session and its viewer say to each other: snapshots go in, lines come out.

use superegg_scene::{Scene, ViewSettings};
use thiserror::Error;

/// What the window shows: a snapshot.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Shown {
    /// The scene.
    pub scene: Scene,
    /// The selected primitive or object, which is what is shown.
    pub selected: Option<String>,
    /// The switches.
    pub settings: ViewSettings,
}

/// What the window has to say.
#[derive(Clone, Debug, PartialEq)]
pub enum FromViewer {
    /// A line exactly as the prompt would take it.
    Command(String),
    /// A key or the panel has changed a switch.
    Settings(ViewSettings),
    /// Something to tell the person at the prompt.
    Say(String),
    /// The keyboard goes back to the prompt.
    KeyboardBack,
    /// The window is closed: by its user, by [`ViewerHandle::close`], or because it can be shown no longer. [`ViewerHandle::open`] may open it
    /// again, unless a [`FromViewer::Say`] before told that the display has gone.
    Closed,
}

/// Why there can be no window.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum NoWindow {
    /// No display answers; the text says why.
    #[error("there is no display to open a window on ({0}); everything but the viewer works without one")]
    NoDisplay(String),
    /// The crate is compiled without the feature `window`.
    #[error(
        "this superegg is built without its window; `cargo build --release --features viewer` builds it with one"
    )]
    NotBuilt,
}
