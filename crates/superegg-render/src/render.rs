//! From a compiled scene to a film, in tiles over threads.

pub(crate) mod frame;
pub(crate) mod lane_kernels;
pub(crate) mod lane_lighting;
pub(crate) mod lane_mirrors;
pub(crate) mod output;
pub(crate) mod part_file;
pub(crate) mod part_tile;
pub(crate) mod part_words;
pub(crate) mod point_shadows;
pub(crate) mod primary_hits;
pub(crate) mod shadow_queue;
pub(crate) mod shard;
pub(crate) mod surface_cache;
pub(crate) mod surface_ids;
pub(crate) mod tracer;
pub(crate) mod worker;
