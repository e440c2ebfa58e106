//! A bound on what compressed data may expand to.

/// The arrays of a compressed file may have so many bytes in memory, and [`RATIO`] times the
/// file's size more.
const FREE: u64 = 256 << 20;
/// The greatest ratio of memory to file size beyond [`FREE`]. Zlib reaches 1000 on zeros only.
const RATIO: u64 = 64;

/// The memory in bytes that the arrays of a compressed file of `size` bytes may take: a file that
/// needs more is taken for a bomb.
pub(super) fn expansion_limit(size: usize) -> u64 {
    FREE.saturating_add(RATIO.saturating_mul(size as u64))
}
