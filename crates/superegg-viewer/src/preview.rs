//! The scene as the GPU draws it: instances of primitives, expanded from the graph of objects, and
//! their meshes.

mod data;
mod expand;
mod index;
mod tessellate;

pub use data::{Preview, PreviewBudget, PreviewInstance, PreviewShape};
pub use index::SceneIndex;
pub(crate) use tessellate::{Vertex, drawn_patches, tessellate};
