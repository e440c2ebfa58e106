//! From a compiled scene to pictures.
//!
//! [`render`] draws a [`superegg_trace::CompiledScene`] into a [`Film`]: camera rays, shading by light, mirrors and glass, samples
//! and filters; [`Development`] turns the film into the bytes of a picture file, [`Part`] keeps a part of the work in a file.

mod adaptive;
mod develop;
mod exr_file;
mod film;
mod filter;
mod gather;
mod ground;
mod integrator;
mod lighting;
pub mod measure;
mod medium;
mod packet_light;
mod partial;
mod pattern;
mod placement;
mod point;
mod render;
mod sampler;
mod sequence;
mod shading;
mod share;
mod shows;
mod tile;
mod tiling;
mod view;

pub use develop::{Development, ImageError};
pub use exr_file::{ExrError, exr_file};
pub use film::{Film, Pixel};
pub use integrator::{RayCounts, Taken};
pub use partial::{Difference, Part, PartError, PartHeader};
pub use render::{RenderBudget, RenderSettings, Rendered, Surroundings, TileWork, render, render_tiles};
pub use share::Share;
pub use shows::Shows;
pub use tiling::{Tile, tiles};
pub use view::View;
