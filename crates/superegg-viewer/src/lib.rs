//! The window onto a scene: what it shows, and what can be done in it.
//!
//! Pure state ([`Arcball`], [`Eye`], [`ViewState`], [`keys`]) knows no window and no GPU; [`draw`] draws on wgpu into a window or an image and
//! knows no keys. The crate reads snapshots of a scene and never writes one: what is changed in the window leaves it as lines of the
//! modelling language.

mod annotations;
mod arcball;
mod bench;
mod cast;
mod display_loss;
pub mod draw;
mod eye;
mod gpu;
mod io_grid;
pub mod keys;
mod panel;
mod preview;
mod screenshot;
mod state;
mod tessellate;
mod tracer;
mod viewer;
mod window;
mod worker;

pub use arcball::Arcball;
pub use bench::{FrameTimes, PreviewBench, TraceBench, bench_preview, bench_trace};
pub use cast::{CastHit, cast};
pub use eye::Eye;
pub use gpu::{Gpu, GpuError};
pub use io_grid::{GridSpec, IoGrid};
pub use preview::{Preview, PreviewBudget, PreviewInstance, PreviewShape, SceneIndex};
pub use state::{Request, ViewState, Viewport};
pub use tessellate::{MOST_PATCHES, Mesh, Vertex, drawn_patches, tessellate};
pub use tracer::{Pace, Pass, TraceJob, available_threads, trace_pass};
pub use viewer::{FromViewer, NoDisplay, Shown, Viewer, ViewerHandle};
