//! Drawing on the GPU, into a window or into an image. It knows cameras, instances, lines and
//! marks, and nothing of windows, keys or scenes.

mod attachments;
mod color;
mod drawing;
mod eye_space;
mod gpu;
mod gpu_data;
mod instances;
mod lod;
mod meshes;
mod picture;
mod pipelines;

pub(crate) use color::encoded;
pub use drawing::Drawing;
pub(crate) use gpu::by_family;
pub use gpu::{Gpu, GpuError};
pub use gpu_data::MOST_LIGHTS;
pub(crate) use picture::Target;
pub use picture::{FilmTexture, Line, Mark, Picture, Selected, Style};
pub use pipelines::SHADERS;
