//! Which instance of a primitive is meant.

use arrayvec::ArrayVec;
use superegg_scene::MAX_DEPTH;

/// The way from the root down to an instance: the place of the child in each group passed. Empty for a root that is a primitive.
#[derive(Clone, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct InstancePath(ArrayVec<u32, { MAX_DEPTH as usize }>);

impl InstancePath {
    /// The places of the children, from the root down.
    pub fn indices(&self) -> &[u32] {
        &self.0
    }

    /// One level down. A compiled scene is never deeper than [`MAX_DEPTH`].
    pub(crate) fn push(&mut self, index: u32) {
        self.0.push(index);
    }

    pub(crate) fn pop(&mut self) {
        self.0.pop();
    }
}
