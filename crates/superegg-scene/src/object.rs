//! Objects: named groups of children.

use std::sync::Arc;

use imbl::Vector;
use superegg_geom::{Transform, TransformError, TransformStep};

use crate::ordered_map::OrderedMap;

/// A list of transform steps, with the transform they compose to.
#[derive(Clone, Debug, PartialEq)]
struct StepList {
    /// The last steps, at most [`MOST_RECENT`]. A plain vector is small, and scenes have millions
    /// of short lists.
    recent: Vec<TransformStep>,
    /// The steps before those. Clones share them.
    earlier: Vector<TransformStep>,
    composed: Transform,
}

/// The number of steps that a clone copies.
const MOST_RECENT: usize = 16;

impl Default for StepList {
    fn default() -> Self {
        Self { recent: Vec::new(), earlier: Vector::new(), composed: Transform::IDENTITY }
    }
}

impl StepList {
    /// The composed transform with one more step appended.
    fn composed_with(&self, step: &TransformStep) -> Result<Transform, TransformError> {
        Transform::from_steps([step])?.after(&self.composed)
    }

    fn push(&mut self, step: TransformStep, composed: Transform) {
        if self.recent.len() == MOST_RECENT {
            self.earlier.extend(self.recent.drain(..));
        }
        self.recent.push(step);
        self.composed = composed;
    }

    fn steps(&self) -> impl Iterator<Item = &TransformStep> {
        self.earlier.iter().chain(&self.recent)
    }
}

/// A reference to a primitive or object within an object, with its own transform.
#[derive(Clone, Debug, PartialEq)]
pub struct Child {
    target: Arc<str>,
    own: StepList,
}

impl Child {
    pub(crate) fn new(target: &str) -> Self {
        Self { target: target.into(), own: StepList::default() }
    }

    /// The name of the primitive or object that the child refers to.
    pub fn target(&self) -> &str {
        &self.target
    }

    /// The steps of its own transform, in order: the first one acts on a point first.
    pub fn steps(&self) -> impl Iterator<Item = &TransformStep> {
        self.own.steps()
    }
}

/// A group of children, with a transform of the whole group.
#[derive(Clone, Debug, Default)]
pub struct Object {
    children: OrderedMap<Child>,
    overall: StepList,
    cursor: Option<Arc<str>>,
    /// An upper bound of the [`extent`] of the children's own transforms; removed children may
    /// still count.
    child_extent: f64,
}

impl PartialEq for Object {
    fn eq(&self, other: &Self) -> bool {
        // The bound depends on history, not only on content.
        self.children == other.children && self.overall == other.overall && self.cursor == other.cursor
    }
}

/// The largest absolute entry of a transform and its inverse.
fn extent(map: &Transform) -> f64 {
    let largest = |affine: &superegg_geom::glam::DAffine3| {
        affine.to_cols_array().into_iter().map(f64::abs).fold(0.0, f64::max)
    };
    largest(map.forward()).max(largest(map.inverse()))
}

impl Object {
    /// The children with their aliases, in the order of addition.
    pub fn children(&self) -> impl ExactSizeIterator<Item = (&str, &Child)> + DoubleEndedIterator {
        self.children.iter()
    }

    /// The steps of the transform of the whole, in order. It acts after each child's own transform.
    pub fn overall_steps(&self) -> impl Iterator<Item = &TransformStep> {
        self.overall.steps()
    }

    /// The alias and child at the cursor: the child that transforms move. Each object has its own
    /// cursor.
    pub fn cursor(&self) -> Option<(&str, &Child)> {
        let alias = self.cursor.as_deref()?;
        Some((alias, self.children.get(alias)?))
    }

    /// The child with this alias.
    pub fn child(&self, alias: &str) -> Option<&Child> {
        self.children.get(alias)
    }

    /// The transform from a child's space to the space of the object's parent: the child's own
    /// steps, then the steps of the whole.
    ///
    /// # Errors
    /// The composition leaves the range of f64. In a valid scene it never does.
    pub fn parent_from_child(&self, child: &Child) -> Result<Transform, TransformError> {
        self.overall.composed.after(&child.own.composed)
    }

    pub(crate) fn push_child(&mut self, alias: &str, child: Child) {
        self.child_extent = self.child_extent.max(extent(&child.own.composed));
        self.children.insert(alias, child);
        self.cursor = Some(alias.into());
    }

    /// Removes a child. A cursor on it moves to the last child. Returns whether the alias existed.
    pub(crate) fn remove_child(&mut self, alias: &str) -> bool {
        let is_removed = self.children.remove(alias);
        if is_removed && self.cursor.as_deref() == Some(alias) {
            self.cursor = self.children.last_name().map(Into::into);
        }
        is_removed
    }

    /// Makes all children that refer to `from` refer to `to`.
    pub(crate) fn retarget(&mut self, from: &str, to: &str) {
        let aliases: Vec<String> = self.aliases_of(from).map(str::to_owned).collect();
        for alias in aliases {
            if let Some(child) = self.children.get_mut(&alias) {
                child.target = to.into();
            }
        }
    }

    /// The aliases of the children that refer to a name.
    pub fn aliases_of<'a>(&'a self, target: &'a str) -> impl Iterator<Item = &'a str> {
        self.children().filter(move |(_, child)| child.target() == target).map(|(alias, _)| alias)
    }

    /// Moves the cursor to a child. Returns whether the alias exists.
    pub(crate) fn move_cursor(&mut self, alias: &str) -> bool {
        let is_there = self.children.contains(alias);
        if is_there {
            self.cursor = Some(alias.into());
        }
        is_there
    }

    /// Appends a step to the child at the cursor. Returns false if there is no child.
    pub(crate) fn push_child_step(&mut self, step: TransformStep) -> Result<bool, TransformError> {
        let child = self.cursor.as_deref().and_then(|alias| self.children.get_mut(alias));
        let Some(child) = child else { return Ok(false) };
        let composed = child.own.composed_with(&step)?;
        self.overall.composed.after(&composed)?;
        self.child_extent = self.child_extent.max(extent(&composed));
        child.own.push(step, composed);
        Ok(true)
    }

    /// Appends a step to the transform of the whole.
    pub(crate) fn push_overall_step(&mut self, step: TransformStep) -> Result<(), TransformError> {
        let composed = self.overall.composed_with(&step)?;
        // Below this bound on the entries of both transforms and their inverses no product
        // overflows, and no column cancels to zero. Only above it is each child checked.
        const WELL_CONDITIONED: f64 = 1e12;
        let is_plain = extent(&composed) * self.child_extent < WELL_CONDITIONED;
        for (_, child) in self.children().filter(|_| !is_plain) {
            composed.after(&child.own.composed)?;
        }
        self.overall.push(step, composed);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use superegg_geom::glam::DVec3;

    use super::*;

    #[test]
    fn steps_keep_their_order_and_clones_those_they_had() {
        let mut object = Object::default();
        object.push_child("egg", Child::new("egg"));
        let step = |i: usize| TransformStep::Translate(DVec3::new(i as f64, 0.0, 0.0));
        let mut before = Vec::new();
        for i in 0..3 * MOST_RECENT + 1 {
            before.push(object.clone());
            assert_eq!(object.push_child_step(step(i)), Ok(true));
            object.push_overall_step(step(i)).unwrap();
        }
        for (count, object) in before.iter().chain([&object]).enumerate() {
            let child = object.child("egg").unwrap();
            assert!(child.steps().eq(&(0..count).map(step).collect::<Vec<_>>()));
            assert!(child.steps().eq(object.overall_steps()));
            let moved = object.parent_from_child(child).unwrap().forward().translation.x;
            assert_eq!(moved, (0..count).sum::<usize>() as f64 * 2.0);
        }
    }
}
