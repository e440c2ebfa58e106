//! The two tests of the course text as data, without a window: the inside-outside test and the
//! intersection test.

mod cast;
mod io_grid;

pub use cast::{CastHit, cast};
pub use io_grid::{GridChoice, GridSpec, IoGrid};
