//! The scene as the GPU draws it: instances of primitives, expanded from the graph of objects, and
//! their meshes.

mod data;
mod expand;
mod index;
mod superellipse;
mod tessellate;

pub use data::{Preview, PreviewBudget, PreviewInstance, PreviewShape};
pub use index::SceneIndex;
pub(crate) use tessellate::{Mesh, Vertex, drawn_patches, quarter_segments, tessellate, tessellate_within};
