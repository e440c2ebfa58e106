//! The identity of a compiled scene.

use std::num::NonZeroU32;
use std::sync::atomic::{AtomicU32, Ordering};

/// Identifies a compiled scene, so that a hit of another scene is recognised. A clone has the id of its original.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct SceneId(NonZeroU32);

impl SceneId {
    /// An id that no other scene of the process has, up to 2^32 - 1 scenes.
    pub(crate) fn next() -> Self {
        static NEXT: AtomicU32 = AtomicU32::new(1);
        Self(NonZeroU32::new(NEXT.fetch_add(1, Ordering::Relaxed)).unwrap_or(NonZeroU32::MIN))
    }
}
