//! Ray streams: incoherent rays. Many against the boxes of one node ([`intersect_boxes`]), eight at once into the boxes of
//! shapes of their own ([`ShapeEntries`]), 32 at once against those shapes ([`StreamLanes`]).
//!
//! List traversal of ray streams (Tsakok 2009). The steps that need f64 come first: a ray is mapped to its shape's space and
//! to the point where it enters the shape's box; only the segment inside the box is searched in f32. Boxes are inlined into
//! the caller's own lane code; the searches of [`StreamLanes`] are compiled once for each instruction set.

mod boxes;
mod chords;
mod entry;
mod search;
mod solve;

pub use boxes::{BoxRay, ListedRay, NodeEntries, intersect_boxes};
pub use chords::StreamChords;
pub use entry::{END, ENTRY_LANES, EntryKind, ShapeEntries, ShapeEntry};
pub use solve::{STREAM_LANES, StreamHits, StreamLanes, TOLERANCE};
