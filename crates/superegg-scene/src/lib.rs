//! The scene as the user describes it: primitives, objects, lights, camera, environment, image
//! settings and keyframes.
//!
//! A [`Scene`] keeps these invariants: names are unique over primitives and objects, every child
//! refers to an existing name, aliases are unique within an object, and every list of transform
//! steps is invertible. Ray tracing works on a compiled form, which the crate superegg-trace makes.

mod animation;
mod camera;
mod decimal;
mod environment;
mod light;
mod name_index;
mod naming;
mod nesting;
mod numbers;
mod object;
mod ordered_map;
mod persistent_vector;
mod picture;
mod primitive;
mod scene;
mod table;
mod texture;
mod tracks;
mod uses;
mod view_settings;

pub use animation::{Key, Track, TrackSubject, TrackWord};
pub use camera::{Camera, Lens};
pub use decimal::short_decimal;
pub use environment::{AmbientOcclusion, Daylight, EnvironmentLight, EnvironmentPicture, Floor, Sky};
pub use light::{Light, LightKind};
pub use naming::numbered_name;
pub use nesting::object_heights;
pub use object::{Child, Object};
pub use picture::{Encoding, Filter, LightModel, Picture, Tone};
pub use primitive::{Material, MaterialWeight, Patches, Pattern, Primitive};
pub use scene::{DEFAULT_DEPTH, Entity, MAX_DEPTH, Scene, SceneError};
pub use table::{InstanceTable, TableBuilder, TableColumns, TableError, TableShape, row_name};
pub use texture::{Texture, TextureChannel, TextureMapping, Textures};
pub use view_settings::{Shading, Theme, ViewSettings};

/// Compiles the examples of the crate's README.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct ReadmeDoctests;
