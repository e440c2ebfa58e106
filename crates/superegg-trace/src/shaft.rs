//! Shaft culling: what may occlude rays from one box to another.
//!
//! The shadow rays from neighbouring points to an area light lie in the convex hull of a box around the points and a box
//! around the light: a shaft (Haines and Wallace 1991). One traversal of the scene per shaft finds the few shapes that may
//! occlude its rays. Most shafts are empty, and their rays need no test.

mod beams;
mod chords;
mod first_hits;
pub(crate) mod hull;
mod index_groups;
mod occluders;
mod occlusion;

pub use beams::{BeamHits, RayBeam};
pub use chords::{Chord, Chords};
pub use first_hits::{FirstHit, FirstHits};
pub use hull::Shaft;
pub use index_groups::IndexGroups;
pub use occluders::{Occluder, ShaftStart};
pub use occlusion::{OpenRays, ShaftRays};
