//! Arcball, eye, key bindings and the state of the view: pure state without a window or a GPU.
//! Arcball, eye and keys are there without the feature `window`, for other front ends.

mod arcball;
mod eye;
#[cfg(feature = "window")]
pub(crate) mod gizmo;
pub mod keys;
#[cfg(feature = "window")]
mod projection;
mod view_side;
#[cfg(feature = "window")]
mod view_state;
#[cfg(feature = "window")]
mod viewport;

pub use arcball::Arcball;
pub use eye::Eye;
#[cfg(feature = "window")]
pub use gizmo::Tool;
#[cfg(feature = "window")]
pub(crate) use projection::Projection;
pub use view_side::ViewSide;
#[cfg(feature = "window")]
pub use view_state::{FileAction, Request, ViewState};
#[cfg(feature = "window")]
pub use viewport::Viewport;
