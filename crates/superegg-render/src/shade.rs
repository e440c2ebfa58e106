//! Shading: materials, direct light, reflection and refraction.

pub(crate) mod bump;
pub(crate) mod clear_shadows;
pub(crate) mod context;
pub(crate) mod direct;
pub(crate) mod emitters;
pub(crate) mod floor;
pub(crate) mod grouped_light;
pub(crate) mod hemisphere;
pub(crate) mod lane_math;
pub(crate) mod light_kernel;
pub(crate) mod light_sample;
pub(crate) mod lit_points;
pub(crate) mod medium;
pub(crate) mod microfacet;
pub(crate) mod noise;
pub(crate) mod path;
pub(crate) mod path_resources;
pub(crate) mod pattern;
pub(crate) mod phong;
pub(crate) mod point;
pub(crate) mod reach;
pub(crate) mod shadow_batch;
pub(crate) mod state;
pub(crate) mod surfaces;
pub(crate) mod textured;
pub(crate) mod whitted;
