//! Paths to instances.

use smallvec::SmallVec;

/// The path from the root to an instance: in each group the index of the child to follow.
///
/// The last index is that of a leaf, or of a group that is hit as a whole ([`InstancePath::is_proxy`]). A path is only
/// meaningful for the compiled scene that it came from. [`CompiledScene::path_name`](crate::CompiledScene::path_name) gives
/// its name.
#[derive(Debug, Default, PartialEq, Eq, Hash)]
pub struct InstancePath(SmallVec<[u32; INLINE_DEPTH]>);

impl Clone for InstancePath {
    /// Copies the indices as a slice: each mirrored ray has the path that it starts from, and a copy element by element takes
    /// several times as long.
    #[inline]
    fn clone(&self) -> Self {
        Self(SmallVec::from_slice(&self.0))
    }
}

/// Longer paths are allocated.
const INLINE_DEPTH: usize = 6;

impl InstancePath {
    /// Marks a last index that is an instance's, not a leaf's.
    pub(crate) const INSTANCE: u32 = 1 << 31;

    /// The instance id of the floor.
    pub const FLOOR_ID: u32 = 1;

    /// The indices, from the root down. The last one is that of a leaf, or with [`InstancePath::INSTANCE`] that of a
    /// group hit as a whole.
    pub(crate) fn indices(&self) -> &[u32] {
        &self.0
    }

    /// Whether the path has no level: that of a miss.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Whether the path ends at a group that was too small to be opened and was hit as its proxy.
    #[inline]
    pub fn is_proxy(&self) -> bool {
        self.0.last().is_some_and(|last| last & Self::INSTANCE != 0)
    }

    /// Adds a level.
    #[doc(hidden)]
    #[inline]
    pub fn push(&mut self, index: u32) {
        self.0.push(index);
    }

    /// Removes all levels.
    pub(crate) fn clear(&mut self) {
        self.0.clear();
    }

    /// Removes the last level.
    pub(crate) fn pop(&mut self) {
        self.0.pop();
    }
}
