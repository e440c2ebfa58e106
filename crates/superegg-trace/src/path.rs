//! Which instance of a primitive is meant.

use smallvec::SmallVec;

/// The way from the root down to an instance: in each group passed the place of the child in the group's tree. It means something only to the
/// scene that it came from.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct InstancePath(SmallVec<[u32; USUAL_DEPTH]>);

/// Deeper paths are kept elsewhere.
const USUAL_DEPTH: usize = 6;

impl InstancePath {
    /// Marks a last place that is an instance's, not a leaf's.
    pub(crate) const INSTANCE: u32 = 1 << 31;

    /// The places, from the root down; the last one is that of a leaf, or with [`InstancePath::INSTANCE`] that of a group seen from so far that
    /// it stands in as a whole.
    pub(crate) fn places(&self) -> &[u32] {
        &self.0
    }

    /// Whether it ends at a group that stands in as a whole.
    pub fn is_stand_in(&self) -> bool {
        self.0.last().is_some_and(|last| last & Self::INSTANCE != 0)
    }

    /// The id of the floor.
    pub const FLOOR_ID: u32 = 1;

    /// One level down.
    pub fn push(&mut self, place: u32) {
        self.0.push(place);
    }

    pub(crate) fn clear(&mut self) {
        self.0.clear();
    }

    pub(crate) fn pop(&mut self) {
        self.0.pop();
    }
}
