//! The viewer of a build without the feature `window`: the same names, but no value can be made.

use std::convert::Infallible;
use std::sync::mpsc::Sender;

use superegg_scene::Scene;

use crate::frame_stats::ViewerBench;
use crate::protocol::{FromViewer, NoWindow, Shown};

/// The event loop and its window. This build cannot make one.
#[derive(Debug)]
pub struct Viewer(Infallible);

/// Access to a [`Viewer`]. This build cannot make one.
#[derive(Clone, Debug)]
pub struct ViewerHandle(Infallible);

impl Viewer {
    /// Always fails.
    ///
    /// # Errors
    /// Always [`NoWindow::NotBuilt`].
    pub fn new() -> Result<Self, NoWindow> {
        Err(NoWindow::NotBuilt)
    }

    /// A handle for other threads.
    pub fn handle(&self) -> ViewerHandle {
        match self.0 {}
    }

    /// Runs the event loop.
    pub fn run(
        self,
        _first: Option<Shown>,
        _out: Sender<FromViewer>,
        _after_loss: impl FnOnce() + Send + 'static,
    ) {
        match self.0 {}
    }
}

impl ViewerHandle {
    /// Opens the window with this snapshot.
    pub fn open(&self, _shown: Shown) {
        match self.0 {}
    }

    /// Shows this snapshot.
    pub fn show(&self, _shown: Shown) {
        match self.0 {}
    }

    /// Shows a line of text in the window for a while.
    pub fn notice(&self, _text: String) {
        match self.0 {}
    }

    /// Shows a line of text in the window for a while.
    pub fn inform(&self, _text: String) {
        match self.0 {}
    }

    /// Shows the progress of a picture in the window.
    pub fn rendering(&self, _progress: Option<String>) {
        match self.0 {}
    }

    /// Requests the keyboard for the window.
    pub fn interact(&self) {
        match self.0 {}
    }

    /// Closes the window.
    pub fn close(&self) {
        match self.0 {}
    }

    /// Ends [`Viewer::run`].
    pub fn quit(&self) {
        match self.0 {}
    }
}

/// Always fails.
///
/// # Errors
/// Always [`NoWindow::NotBuilt`].
pub fn bench(
    _scene: &Scene,
    _root: Option<&str>,
    _size: (u32, u32),
    _frames: usize,
) -> Result<ViewerBench, NoWindow> {
    Err(NoWindow::NotBuilt)
}
