//! Renders compiled scenes to pictures.
//!
//! [`render`] traces a [`superegg_trace::CompiledScene`] into a [`Film`]. [`Development`] maps the
//! film to the bytes of a picture file. [`PartFile`] reads the tiles of an unfinished picture.

mod camera;
mod environment;
mod film;
#[cfg(feature = "bench")]
#[doc(hidden)]
pub mod measure;
mod render;
mod settings;
mod shade;
mod stats;
mod texture;

pub use camera::framing::{Framing, facing};
pub use camera::framing_of_data::frame_data;
pub use camera::view::View;
pub use environment::map::{EnvironmentMap, EnvironmentPixels};
pub use environment::read::EnvironmentError;
pub use film::buffer::Film;
pub use film::develop::Development;
pub use film::encoded::{EncodedPicture, ImageError, NotesError, PictureNote, SOFTWARE, notes_of_png};
#[cfg(feature = "exr")]
pub use film::exr::{ExrError, ExrPicture, exr_file, notes_of_exr};
pub use film::matte::{Coverage, MATTE_RANKS, MatteLevel, matte_id};
pub use film::pixel::{LightPasses, Pixel};
pub use film::tile::{Tile, tiles};
pub use render::frame::{
    RenderError, RenderOptions, RenderResources, Rendered, TileWork, render, render_tiles, render_tiles_with,
};
pub use render::output::OutputColoring;
pub use render::part_file::{Difference, PartError, PartFile, PartHeader};
pub use render::shard::Shard;
pub use settings::{Environment, Output, RenderSettings, SettingsError};
pub use stats::{RayCounts, TraceStats};
pub use texture::pixels::{TextureError, TexturePixels};
pub use texture::set::TextureSet;

/// The example of the README.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
