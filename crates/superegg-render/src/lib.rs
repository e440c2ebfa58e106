//! From a scene to what rays hit, and from there to pictures and answers.
//!
//! [`CompiledScene::compile`] is the one way from the description to render-ready data: groups keyed by (object, remaining depth), so
//! that a self-referring object is a small graph and never unrolled. [`CompiledScene::intersect`], [`CompiledScene::occluded`]
//! and [`CompiledScene::query_point`] ask it; [`render`] draws it into a [`Film`]. [`flatten`] is the slow trusted twin
//! for shallow scenes.

mod adaptive;
mod beam;
mod bvh;
mod compile;
mod compiled;
mod develop;
mod exr_file;
mod film;
mod filter;
pub mod flatten;
mod flight;
mod footprint;
mod gather;
mod ground;
mod integrator;
mod interaction;
mod lighting;
pub mod measure;
mod medium;
mod packet_light;
mod partial;
mod path;
mod pattern;
mod pencil;
mod placement;
mod point;
mod point_query;
mod render;
mod sampler;
mod sequence;
mod shading;
mod share;
mod shows;
mod stand_in;
mod stream;
mod support;
mod tile;
mod tiling;
mod traverse;
mod view;

pub use compiled::{CompiledScene, Swelling};
pub use develop::{Development, ImageError};
pub use exr_file::{ExrError, exr_file};
pub use film::{Film, Pixel};
pub use flight::FlightRay;
pub use footprint::{Footprint, LEAST_FOOTPRINT};
pub use integrator::{RayCounts, Taken};
pub use interaction::SurfaceInteraction;
pub use partial::{Difference, Part, PartError, PartHeader};
pub use path::InstancePath;
pub use point_query::PointAnswer;
pub use render::{RenderBudget, RenderSettings, Rendered, Surroundings, TileWork, render, render_tiles};
pub use share::Share;
pub use shows::Shows;
pub use tiling::{Tile, tiles};
pub use traverse::{Departure, Hit, Side};
pub use view::View;
