//! Long renders: checkpoints on disk, resumption and shards.

pub(crate) mod checkpoint;
pub(crate) mod resumable;
pub(crate) mod shard;
