//! Ray and point queries of superquadric scenes.
//!
//! [`CompiledScene::compile`] turns the description of a scene into a graph of groups, one for each object and remaining
//! depth, so that a self-referring object stays a small graph and is never unrolled. A compiled scene answers:
//!
//! - [`CompiledScene::intersect`] and [`CompiledScene::occluded`]: one ray,
//! - [`CompiledScene::intersect_batch`] and [`CompiledScene::occluded_batch`]: many rays as columns, several times as fast
//!   as one at a time,
//! - [`CompiledScene::intersect_many`] and [`CompiledScene::occluded_many`]: the same for rays with widths and starts,
//! - [`CompiledScene::interaction`]: position, normal and material at a hit,
//! - [`CompiledScene::query_point`] and [`CompiledScene::query_box`]: what is at a point or in a box,
//! - [`CompiledScene::nearest_primitive`], [`CompiledScene::primitives_holding`] and [`CompiledScene::signed_distance`]: what is
//!   nearest to a point, what holds it, and how far the surface is,
//! - [`SceneSurfaces`] and [`SceneMeasures`]: even samples of the surfaces, and volume, area and inertia.
//!
//! All answers are exact to the rounding of f64, deterministic, and the same for one ray and for many. A compiled scene is
//! immutable and may be shared by threads.
//!
//! [`mod@reference`] is a slow reference for tests.

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;

mod batch;
mod compile;
mod instances;
mod mass_properties;
#[cfg(feature = "bench")]
#[doc(hidden)]
pub mod measure;
mod nearest;
mod numbering;
#[doc(hidden)]
pub mod packet;
mod point;
mod ranked;
mod ray;
pub mod reference;
mod sample;
mod scene;
#[doc(hidden)]
pub mod shaft;
mod single;
mod stream;
mod surface;
#[cfg(test)]
mod test_camera;
mod walk;

pub use batch::{BatchOptions, HitPaths, SceneHitBatch};
pub use instances::PlacedPrimitive;
pub use mass_properties::{Estimate, MassProperties, SceneMeasures, UnionProperties};
pub use nearest::{NearestPrimitive, SceneDistance};
pub use numbering::InstanceNumbers;
pub use point::{PointAnswer, PointLimits, PrimitiveAtPoint};
pub use ray::footprint::{Footprint, LEAST_FOOTPRINT};
pub use ray::limits::{Coarsened, LimitReached, RayLimits};
pub use ray::query::{Hit, Side, SurfaceStart, TraceRay};
pub use sample::{ScenePoint, SceneSurfaces};
pub use scene::compiled::{BoxInflation, CompiledScene, Count};
pub use scene::group::Target;
pub use scene::path::InstancePath;
pub use scene::primitive::CompiledPrimitive;
pub use surface::{ForeignHit, SurfaceInteraction};
