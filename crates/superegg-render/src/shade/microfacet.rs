//! Surfaces of tiny facets: `roughness` and `metallic`, for paths.

pub(crate) mod albedo;
pub(crate) mod ggx;
pub(crate) mod surface;
