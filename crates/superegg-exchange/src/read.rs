//! Readers: what other programs wrote, in our conventions.

#[allow(dead_code, reason = "readers that use all of it come next")]
mod check;
mod dump;
mod error;
mod format;
mod frame;
mod import;
mod number;
mod options;
mod particles;
mod source;
#[allow(dead_code, reason = "readers that use it come next")]
mod spacing;

pub use error::ReadError;
pub use format::Format;
pub use frame::Frame;
pub use import::{Content, Import, Input};
pub use options::{ColumnMap, ReadOptions};
pub use particles::{Particles, SimulationBox};
pub use source::{Source, open, sniff};
