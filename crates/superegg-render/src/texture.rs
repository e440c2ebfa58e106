//! Textures: pictures on surfaces, filtered by the width of rays.

pub(crate) mod mapping;
pub(crate) mod pixels;
pub(crate) mod set;
