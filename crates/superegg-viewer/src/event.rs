//! Events of the event loop.

use crate::live::tracer::Pass;
use crate::live::worker::SceneResult;
use crate::protocol::Shown;

/// An event from another thread for the event loop.
#[derive(Debug)]
pub(crate) enum Event {
    /// Open the window, or bring it to the front, with this snapshot.
    Open(Box<Shown>),
    /// Show this snapshot.
    Show(Box<Shown>),
    /// Show a line of text for a while. It is the error of a command from the window, so a pending
    /// change is dropped.
    Notice(String),
    /// Show a line of text for a while. A pending change stays.
    Inform(String),
    /// Show the progress of a picture, or `None` at its end.
    Rendering(Option<String>),
    /// Give the window the keyboard.
    Interact,
    /// Close the window.
    Close,
    /// Close the window and end the event loop.
    Quit,
    /// A result of the scene worker.
    Ready(SceneResult),
    /// A pass of the tracer.
    Traced(Box<Pass>),
    /// The graphics driver has failed.
    GpuFault(String),
}
