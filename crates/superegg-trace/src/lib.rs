//! Ray queries: from a scene to what rays hit.
//!
//! [`CompiledScene::compile`] turns the description into render-ready data: groups keyed by (object, remaining depth), so that a
//! self-referring object is a small graph and never unrolled. [`CompiledScene::intersect`], [`CompiledScene::occluded`] and
//! [`CompiledScene::query_point`] query it. [`flatten`] is the slow reference for shallow scenes.

#[doc(hidden)]
pub mod beam;
mod bvh;
mod compile;
mod compiled;
pub mod flatten;
mod flight;
mod footprint;
mod interaction;
#[doc(hidden)]
pub mod measure;
mod path;
#[doc(hidden)]
pub mod pencil;
mod point_query;
mod stand_in;
mod stream;
mod support;
#[cfg(test)]
mod test_camera;
mod traverse;

pub use compiled::{CompiledPrimitive, CompiledScene, Swelling};
pub use flight::FlightRay;
pub use footprint::{Footprint, LEAST_FOOTPRINT};
pub use interaction::SurfaceInteraction;
pub use path::InstancePath;
pub use point_query::PointAnswer;
pub use traverse::{Departure, Hit, Side};
