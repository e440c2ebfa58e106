//! Arcball, eye, key bindings and the state of the view: pure state without a window or a GPU.

mod arcball;
mod eye;
pub mod keys;
mod view_state;

pub use arcball::Arcball;
pub use eye::Eye;
pub use view_state::{FileAction, Request, ViewState, Viewport};
