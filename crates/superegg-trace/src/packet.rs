//! Coherent rays: packets with one origin, for cameras and point lights. For the renderer only.

mod batch;
mod candidates;
mod frame;
mod in_order;
mod isolation;
mod query;
mod rays;
mod resolve;
mod tracer;
mod traverse;

pub use candidates::{Candidate, CandidateHit, Columns, f32_columns};
pub use query::{ShadowRay, ShadowRays, ShadowStart};
pub use rays::{DirectionsFrom, PacketRays, direction, first_lanes};
pub use resolve::{Found, LaneSurface, SurfaceLanes, VisibleSurfaces};
pub use superegg_simd::bits;
pub use tracer::{LANES, MOST_RAYS, PacketTracer};
