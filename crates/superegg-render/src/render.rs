//! From a compiled scene to a film, in tiles over threads.

pub(crate) mod frame;
pub(crate) mod lane_kernels;
pub(crate) mod output;
pub(crate) mod part_file;
pub(crate) mod part_words;
pub(crate) mod shard;
pub(crate) mod tracer;
pub(crate) mod worker;
