//! The names that most programs need: `use superegg::prelude::*;`.

pub use superegg_geom::glam::{DAffine3, DMat3, DQuat, DVec3};
pub use superegg_geom::{Exponents, HitBatch, Ray, RayBatch, Superquadric, TransformStep};
pub use superegg_render::{Film, Output, RenderOptions, RenderSettings};
pub use superegg_scene::{Camera, Light, LightKind, Material, Pattern, Scene};
pub use superegg_trace::{BatchOptions, CompiledScene, Hit, TraceRay};

pub use crate::{Error, Model, Part, Rendering};
