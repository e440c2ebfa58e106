//! The scalar traversal of a group's tree, for rays, points and boxes.

use std::ops::ControlFlow;

use smallvec::{SmallVec, smallvec};
use superegg_geom::Aabb;

use crate::scene::group::Group;
use crate::scene::node::Slot;

/// The tests and actions of a traversal.
pub(crate) trait Visitor {
    /// Whether children are visited in the order of their keys. Otherwise leaves and instances are visited as soon as
    /// they are found.
    const IS_ORDERED: bool;

    /// Tests the box of a child, in the tree's space. Returns the child's key, or `None` to skip the child.
    fn enter(&mut self, bounds: &Aabb) -> Option<f64>;

    /// Whether children of this key need no visit any more.
    fn is_behind(&self, _key: f64) -> bool {
        false
    }

    /// Visits a leaf, by its index in the group.
    fn leaf(&mut self, index: u32) -> ControlFlow<()>;

    /// Visits an instance, by its index in the group.
    fn instance(&mut self, index: u32, key: f64) -> ControlFlow<()>;

    /// Visits a leaf or an instance.
    fn child(&mut self, slot: Slot, key: f64) -> ControlFlow<()> {
        match slot {
            Slot::Node(_) => ControlFlow::Continue(()),
            Slot::Leaf(index) => self.leaf(index),
            Slot::Instance(index) => self.instance(index, key),
        }
    }
}

/// The slots that most traversals keep at a time.
const USUAL_PENDING: usize = 32;

impl Group {
    /// Visits the children of this group whose boxes the visitor enters, until the visitor breaks.
    pub(crate) fn walk<V: Visitor>(&self, visitor: &mut V) -> ControlFlow<()> {
        let mut pending: SmallVec<[(Slot, f64); USUAL_PENDING]> = smallvec![(Slot::Node(0), 0.0)];
        while let Some((slot, key)) = pending.pop() {
            if visitor.is_behind(key) {
                continue;
            }
            let Slot::Node(node) = slot else {
                visitor.child(slot, key)?;
                continue;
            };
            let first = pending.len();
            for (bounds, slot) in self.nodes[node as usize].children() {
                let Some(key) = visitor.enter(&bounds) else { continue };
                if V::IS_ORDERED || matches!(slot, Slot::Node(_)) {
                    pending.push((slot, key));
                } else {
                    visitor.child(slot, key)?;
                }
            }
            if V::IS_ORDERED {
                // The least key is popped first.
                pending[first..].sort_by(|a, b| b.1.total_cmp(&a.1));
            }
        }
        ControlFlow::Continue(())
    }
}
