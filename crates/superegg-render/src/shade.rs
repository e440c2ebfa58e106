//! Shading: materials, direct light, reflection and refraction.

pub(crate) mod context;
pub(crate) mod direct;
pub(crate) mod floor;
pub(crate) mod medium;
pub(crate) mod pattern;
pub(crate) mod phong;
pub(crate) mod point;
pub(crate) mod whitted;
