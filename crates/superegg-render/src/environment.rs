//! Light from far away in all directions: pictures of surroundings, and daylight.

pub(crate) mod daylight;
pub(crate) mod map;
pub(crate) mod read;
