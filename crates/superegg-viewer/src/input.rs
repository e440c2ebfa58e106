//! Arcball, eye, key bindings and the state of the view: pure state without a window or a GPU.

mod arcball;
mod eye;
pub(crate) mod gizmo;
pub mod keys;
mod projection;
mod view_state;
mod viewport;

pub use arcball::Arcball;
pub use eye::Eye;
pub use gizmo::Tool;
pub(crate) use projection::Projection;
pub use view_state::{FileAction, Request, ViewSide, ViewState};
pub use viewport::Viewport;
