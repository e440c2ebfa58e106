//! Readers: what other programs wrote, in our conventions.

mod arrays;
#[allow(dead_code, reason = "readers that use all of it come next")]
mod check;
mod clouds;
mod columns;
mod course_yaml;
mod dump;
mod eigen;
mod error;
mod expansion;
mod fits;
mod format;
mod frame;
mod glyph;
mod import;
mod number;
mod liggghts_vtk;
mod mercury;
mod nrrd;
mod options;
mod particles;
mod scalars;
mod povray;
mod script;
mod source;
mod spacing;
mod tensor_field;
mod vtk;
mod vtk_columns;
mod vtk_programs;
mod vtk_tensors;
mod yaml;

pub use error::ReadError;
pub use format::Format;
pub use frame::Frame;
pub use import::{Content, Import, Input};
pub use options::{ColumnMap, ReadOptions};
pub use particles::{Particles, SimulationBox};
pub use source::{Source, open, sniff};
