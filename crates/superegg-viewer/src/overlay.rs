//! Annotations in the scene: axes, lights, and the inside-outside and intersection tests of the
//! course text.

pub(crate) mod annotations;
pub(crate) mod cast;
pub(crate) mod io_grid;
