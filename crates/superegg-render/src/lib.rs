//! From a compiled scene to pictures.
//!
//! [`render`] draws a [`superegg_trace::CompiledScene`] into a [`Film`]: camera rays, shading by light, mirrors and glass, samples
//! and filters; [`Development`] turns the film into the bytes of a picture file, [`PartFile`] keeps a part of the work in a file.

mod camera;
mod film;
#[cfg(feature = "bench")]
#[doc(hidden)]
pub mod measure;
mod render;
mod settings;
mod shade;
mod stats;

pub use camera::view::View;
pub use film::buffer::Film;
pub use film::develop::{Development, ImageError};
pub use film::exr::{ExrError, exr_file};
pub use film::pixel::Pixel;
pub use film::tile::{Tile, tiles};
pub use render::frame::{RenderError, RenderOptions, Rendered, TileWork, render, render_tiles};
pub use render::part_file::{Difference, PartError, PartFile, PartHeader};
pub use render::shard::Shard;
pub use settings::{Environment, Output, RenderSettings, SettingsError};
pub use stats::{RayCounts, TraceStats};

/// The example of the README.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
