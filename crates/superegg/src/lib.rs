#![doc = include_str!("../README.md")]

pub mod error;
pub mod model;
pub mod part;
pub mod picture;
pub mod prelude;
mod scene_file;

pub use error::Error;
pub use model::Model;
pub use part::Part;
pub use picture::Rendering;

#[cfg(feature = "exchange")]
pub use superegg_exchange as exchange;
#[cfg(feature = "fit")]
pub use superegg_fit as fit;
pub use superegg_geom as geom;
pub use superegg_lang as lang;
pub use superegg_render as render;
pub use superegg_scene as scene;
pub use superegg_trace as trace;
