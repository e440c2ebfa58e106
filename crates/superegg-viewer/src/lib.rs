//! The window of Superegg: preview, panel and live ray tracing of a scene.
//!
//! [`Viewer`] runs the window on the main thread. [`ViewerHandle`] sends it snapshots ([`Shown`])
//! from any thread, and its messages ([`FromViewer`]) return over a channel. The window reads
//! snapshots of a scene and never writes one: each change leaves as a line of the modelling
//! language. [`bench()`] measures frame times without a window.
//!
//! Pure state knows no window and no GPU: `Arcball`, `Eye`, `ViewState` and the key bindings in
//! `keys`.
//!
//! The feature `window` brings the window. Without it the crate keeps the names that a program
//! calls and has none of the heavy dependencies; each attempt to open a window returns
//! [`NoWindow::NotBuilt`]. A program that calls it needs no conditional code.
//!
//! The feature `state` brings what a front end without this window needs: arcball, eye, keys, and the
//! tests of the course text as data. It is part of `window`.
//!
//! Hidden items serve the project's own tests and may change at any time.

mod frame_stats;
mod protocol;

#[cfg(not(feature = "window"))]
mod absent;

#[cfg(feature = "window")]
mod bench;
#[cfg(feature = "window")]
mod commands;
#[cfg(feature = "window")]
#[doc(hidden)]
pub mod draw;
#[cfg(feature = "window")]
mod event;
#[cfg(feature = "state")]
mod input;
#[cfg(feature = "window")]
mod live;
#[cfg(feature = "window")]
mod overlay;
#[cfg(feature = "window")]
mod panel;
#[cfg(feature = "window")]
#[doc(hidden)]
pub mod preview;
#[cfg(feature = "state")]
mod queries;
#[cfg(feature = "window")]
mod text;
#[cfg(feature = "window")]
mod viewer;
#[cfg(feature = "window")]
mod window;

pub use frame_stats::{DrawStats, FrameTimes, PreviewBench, TraceBench, ViewerBench};
pub use protocol::{Document, Frames, FromViewer, NoWindow, Shown};

#[cfg(not(feature = "window"))]
pub use absent::{Viewer, ViewerHandle, bench};

#[cfg(feature = "state")]
pub use {
    input::{Arcball, Eye, ViewSide, keys},
    queries::{CastHit, GridChoice, GridSpec, IoGrid, cast},
};

#[cfg(feature = "window")]
pub use {
    bench::bench,
    draw::GpuError,
    input::{FileAction, Request, Tool, ViewState, Viewport},
    viewer::{Viewer, ViewerHandle},
};

/// The examples of the README.
#[cfg(all(doctest, feature = "window"))]
#[doc = include_str!("../README.md")]
struct Readme;
