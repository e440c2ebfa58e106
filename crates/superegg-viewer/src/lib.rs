//! The window onto a scene: what it shows, and what can be done in it.
//!
//! Pure state (`Arcball`, `Eye`, `ViewState`, `keys`) knows no window and no GPU; `draw` draws on wgpu into a window or an image and
//! knows no keys. The crate reads snapshots of a scene and never writes one: what is changed in the window leaves it as lines of the
//! modelling language.
//!
//! All of this needs the feature `window`. Without it the crate keeps the names that a program calls, [`Viewer`] foremost, none of its
//! heavy dependencies, and each attempt to open a window fails with [`NoWindow::NotBuilt`]. So a program that calls it needs no
//! conditional code.

mod frame_stats;
mod protocol;

#[cfg(not(feature = "window"))]
mod absent;

#[cfg(feature = "window")]
mod annotations;
#[cfg(feature = "window")]
mod arcball;
#[cfg(feature = "window")]
mod bench;
#[cfg(feature = "window")]
mod cast;
#[cfg(feature = "window")]
mod display_loss;
#[cfg(feature = "window")]
pub mod draw;
#[cfg(feature = "window")]
mod eye;
#[cfg(feature = "window")]
mod gpu;
#[cfg(feature = "window")]
mod io_grid;
#[cfg(feature = "window")]
pub mod keys;
#[cfg(feature = "window")]
mod panel;
#[cfg(feature = "window")]
mod preview;
#[cfg(feature = "window")]
mod screenshot;
#[cfg(feature = "window")]
mod state;
#[cfg(feature = "window")]
mod tessellate;
#[cfg(feature = "window")]
mod tracer;
#[cfg(feature = "window")]
mod viewer;
#[cfg(feature = "window")]
mod window;
#[cfg(feature = "window")]
mod worker;

pub use frame_stats::{DrawStats, FrameTimes, PreviewBench, TraceBench, ViewerBench};
pub use protocol::{FromViewer, NoWindow, Shown};

#[cfg(not(feature = "window"))]
pub use absent::{Viewer, ViewerHandle, bench};

#[cfg(feature = "window")]
pub use {
    arcball::Arcball,
    bench::bench,
    cast::{CastHit, cast},
    eye::Eye,
    gpu::{Gpu, GpuError},
    io_grid::{GridSpec, IoGrid},
    preview::{Preview, PreviewBudget, PreviewInstance, PreviewShape, SceneIndex},
    state::{Request, ViewState, Viewport},
    tessellate::{MOST_PATCHES, Mesh, Vertex, drawn_patches, tessellate},
    tracer::{Pace, Pass, TraceJob, available_threads, trace_pass},
    viewer::{Viewer, ViewerHandle},
};
