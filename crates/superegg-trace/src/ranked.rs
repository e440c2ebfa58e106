//! The entries of best-first queues.

use std::cmp::Ordering;

/// An item of a [`std::collections::BinaryHeap`] whose greatest priority is next; at equal priorities, the greatest rank.
pub(crate) struct Ranked<R, T> {
    pub(crate) priority: f64,
    pub(crate) rank: R,
    pub(crate) item: T,
}

impl<R: Ord, T> PartialEq for Ranked<R, T> {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl<R: Ord, T> Eq for Ranked<R, T> {}

impl<R: Ord, T> PartialOrd for Ranked<R, T> {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl<R: Ord, T> Ord for Ranked<R, T> {
    fn cmp(&self, other: &Self) -> Ordering {
        self.priority.total_cmp(&other.priority).then_with(|| self.rank.cmp(&other.rank))
    }
}
