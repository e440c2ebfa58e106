//! The scene as a user describes it: primitives and objects in one pool of names, lights, a camera, a background.
//!
//! A [`Scene`] is plain data with its invariants kept: names are unique over both kinds, every child names something that
//! exists, aliases are unique within an object, every list of transform steps is invertible. What rays hit is compiled from
//! it elsewhere.

mod animation;
mod camera;
mod light;
mod nesting;
mod object;
mod ordered_map;
mod picture;
mod primitive;
mod scene;
mod surroundings;
mod view_settings;

pub use animation::{Key, Track, TrackSubject, TrackWord};
pub use camera::{Camera, Lens};
pub use light::{Light, LightKind};
pub use nesting::object_heights;
pub use object::{Child, Object};
pub use picture::{Encoding, Filter, Picture, Tone};
pub use primitive::{Material, MaterialShare, Patches, Pattern, Primitive};
pub use scene::{DEFAULT_DEPTH, Entity, MAX_DEPTH, Scene, SceneError};
pub use surroundings::{AmbientOcclusion, Floor, Sky};
pub use view_settings::{Shading, ViewSettings};
