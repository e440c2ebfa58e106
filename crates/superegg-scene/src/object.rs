//! Objects: named groups of children.

use std::sync::Arc;

use imbl::{OrdSet, Vector};
use smol_str::SmolStr;
use superegg_geom::{Transform, TransformBound, TransformError, TransformStep};

use crate::ordered_map::OrderedMap;

/// A list of transform steps. Lists are short, and scenes have millions of them: the transform that
/// the steps compose to is not kept.
#[derive(Clone, Debug, Default, PartialEq)]
struct StepList {
    /// The last steps, at most [`MOST_RECENT`]; `None` for none.
    recent: Option<Arc<[TransformStep]>>,
    /// The steps before those.
    earlier: Option<Arc<EarlierSteps>>,
}

/// The steps of a long list but for the last ones.
#[derive(Clone, Debug, PartialEq)]
struct EarlierSteps {
    steps: Vector<TransformStep>,
    composed: Transform,
}

/// The number of steps that are composed, or copied, again and again.
const MOST_RECENT: usize = 16;

impl StepList {
    fn recent(&self) -> &[TransformStep] {
        self.recent.as_deref().unwrap_or_default()
    }

    /// The transform that the steps compose to.
    #[inline]
    fn composed(&self) -> Result<Transform, TransformError> {
        let Some(earlier) = &self.earlier else { return Transform::from_steps(self.recent()) };
        let mut composed = earlier.composed;
        self.recent().iter().try_for_each(|step| composed.append(step))?;
        Ok(composed)
    }

    /// The bounds of that transform; `None` if its steps do not prove any.
    fn bound(&self) -> Option<TransformBound> {
        let of_earlier = |earlier: &Arc<EarlierSteps>| TransformBound::of(&earlier.composed);
        let earlier = self.earlier.as_ref().map_or(TransformBound::IDENTITY, of_earlier);
        self.recent().iter().try_fold(earlier, TransformBound::after)
    }

    /// Appends a step, without a check.
    fn push(&mut self, step: TransformStep) -> Result<(), TransformError> {
        if self.recent().len() < MOST_RECENT {
            self.recent = Some(self.recent().iter().cloned().chain([step]).collect());
            return Ok(());
        }
        let composed = self.composed()?;
        let mut steps = self.earlier.take().map(|earlier| earlier.steps.clone()).unwrap_or_default();
        steps.extend(self.recent().iter().cloned());
        self.earlier = Some(Arc::new(EarlierSteps { steps, composed }));
        self.recent = Some(Arc::new([step]));
        Ok(())
    }

    fn steps(&self) -> impl Iterator<Item = &TransformStep> {
        let earlier = self.earlier.iter().flat_map(|earlier| &earlier.steps);
        earlier.chain(self.recent())
    }
}

/// A reference to a primitive or object within an object, with its own transform.
#[derive(Clone, Debug, PartialEq)]
pub struct Child {
    target: SmolStr,
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
    /// The transform of the whole; `None` without steps.
    overall: Option<Box<Overall>>,
    cursor: Option<Box<Cursor>>,
    /// The aliases of the children that are hidden; `None` without any. Children are many, and
    /// hidden ones few.
    hidden: Option<Box<OrdSet<SmolStr>>>,
    /// An upper bound of the [`extent`] of the children's own transforms; removed children may
    /// still count.
    child_extent: f64,
}

/// The transform of a whole object.
#[derive(Clone, Debug, PartialEq)]
struct Overall {
    steps: StepList,
    composed: Transform,
}

/// The child that transforms move.
#[derive(Clone, Debug)]
struct Cursor {
    alias: SmolStr,
    /// The number of the child in the map of children.
    number: usize,
    /// The bounds of the child's own transform; `None` if its steps do not prove any.
    bound: Option<TransformBound>,
}

impl PartialEq for Object {
    fn eq(&self, other: &Self) -> bool {
        // The bound depends on history, not only on content.
        self.children == other.children
            && self.hidden == other.hidden
            && self.overall == other.overall
            && self.cursor_alias() == other.cursor_alias()
    }
}

/// Below this product of bounds on the entries of two transforms and their inverses no entry of
/// their product overflows, and no column cancels to zero.
const WELL_CONDITIONED: f64 = 1e12;

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

    /// The children that are not hidden, in the order of addition. Only these are in pictures, in
    /// answers to rays and points, and in exports.
    pub fn visible_children(&self) -> impl Iterator<Item = (&str, &Child)> {
        self.children().filter(|(alias, _)| !self.is_hidden(alias))
    }

    /// Whether a child is hidden.
    pub fn is_hidden(&self, alias: &str) -> bool {
        self.hidden.as_ref().is_some_and(|hidden| hidden.contains(alias))
    }

    /// The aliases of the hidden children, sorted.
    pub fn hidden_children(&self) -> impl Iterator<Item = &str> {
        self.hidden.iter().flat_map(|hidden| hidden.iter()).map(SmolStr::as_str)
    }

    /// The number of hidden children.
    pub fn hidden_count(&self) -> usize {
        self.hidden.as_ref().map_or(0, |hidden| hidden.len())
    }

    /// The steps of the transform of the whole, in order. It acts after each child's own transform.
    pub fn overall_steps(&self) -> impl Iterator<Item = &TransformStep> {
        self.overall.iter().flat_map(|overall| overall.steps.steps())
    }

    /// The transform of the whole.
    fn overall(&self) -> &Transform {
        self.overall.as_ref().map_or(&Transform::IDENTITY, |overall| &overall.composed)
    }

    fn cursor_alias(&self) -> Option<&str> {
        self.cursor.as_ref().map(|cursor| &*cursor.alias)
    }

    /// The alias and child at the cursor: the child that transforms move. Each object has its own
    /// cursor.
    pub fn cursor(&self) -> Option<(&str, &Child)> {
        let cursor = self.cursor.as_ref()?;
        Some((&cursor.alias, self.children.get_at(cursor.number)?))
    }

    /// The child with this alias.
    pub fn child(&self, alias: &str) -> Option<&Child> {
        self.children.get(alias)
    }

    /// The transform from a child's space to the space of the object's parent: the child's own
    /// steps, then the steps of the whole. It is composed on each call.
    ///
    /// # Errors
    /// The composition leaves the range of f64. In a valid scene it never does.
    #[inline]
    pub fn parent_from_child(&self, child: &Child) -> Result<Transform, TransformError> {
        let own = child.own.composed()?;
        match &self.overall {
            Some(overall) => overall.composed.after(&own),
            None => Ok(own),
        }
    }

    /// Adds a child and moves the cursor to it. Returns whether the alias was free.
    pub(crate) fn push_child(&mut self, alias: &str, child: Child) -> bool {
        let Some(number) = self.children.push(alias, child) else { return false };
        self.child_extent = self.child_extent.max(1.0);
        self.set_cursor(alias, number, Some(TransformBound::IDENTITY));
        true
    }

    fn set_cursor(&mut self, alias: &str, number: usize, bound: Option<TransformBound>) {
        let cursor = Cursor { alias: alias.into(), number, bound };
        match &mut self.cursor {
            Some(held) => **held = cursor,
            None => self.cursor = Some(Box::new(cursor)),
        }
    }

    /// Removes a child. A cursor on it moves to the last child. Returns whether the alias existed.
    pub(crate) fn remove_child(&mut self, alias: &str) -> bool {
        let is_removed = self.children.remove(alias);
        if is_removed {
            self.set_hidden(alias, false);
            // Numbers may have changed.
            let cursor = self.cursor.take().map(|cursor| cursor.alias).filter(|held| held != alias);
            let cursor = cursor.or_else(|| self.children.last_name().map(Into::into));
            if let Some(alias) = cursor {
                self.move_cursor(&alias);
            }
        }
        is_removed
    }

    /// Hides a child that is there, or shows it again.
    pub(crate) fn set_hidden(&mut self, alias: &str, is_hidden: bool) {
        if is_hidden {
            self.hidden.get_or_insert_default().insert(alias.into());
        } else if let Some(hidden) = &mut self.hidden {
            hidden.remove(alias);
            self.hidden.take_if(|hidden| hidden.is_empty());
        }
    }

    /// Shows all children.
    pub(crate) fn show_all(&mut self) {
        self.hidden = None;
    }

    /// Gives a child another alias. Returns whether it exists and the new alias is free.
    pub(crate) fn rename_child(&mut self, alias: &str, new: &str) -> bool {
        let is_renamed = self.children.rename(alias, new);
        if is_renamed {
            if self.is_hidden(alias) {
                self.set_hidden(alias, false);
                self.set_hidden(new, true);
            }
            if let Some(cursor) = self.cursor.as_mut().filter(|cursor| cursor.alias == alias) {
                cursor.alias = new.into();
            }
        }
        is_renamed
    }

    /// Makes all children that refer to `from` refer to `to`.
    pub(crate) fn retarget(&mut self, from: &str, to: &str) {
        let aliases: Vec<String> = self.aliases_of(from).map(str::to_owned).collect();
        aliases.iter().for_each(|alias| self.retarget_child(alias, to));
    }

    /// Makes a child refer to another name.
    pub(crate) fn retarget_child(&mut self, alias: &str, to: &str) {
        if let Some(child) = self.children.get_mut(alias) {
            child.target = to.into();
        }
    }

    /// The number of a child, which rises in the order of addition.
    pub(crate) fn child_number(&self, alias: &str) -> Option<usize> {
        self.children.number_of(alias)
    }

    /// The aliases of the children that refer to a name.
    pub fn aliases_of<'a>(&'a self, target: &'a str) -> impl Iterator<Item = &'a str> {
        self.children().filter(move |(_, child)| child.target() == target).map(|(alias, _)| alias)
    }

    /// Moves the cursor to a child. Returns whether the alias exists.
    pub(crate) fn move_cursor(&mut self, alias: &str) -> bool {
        let Some(number) = self.children.number_of(alias) else { return false };
        let bound = self.children.get_at(number).and_then(|child| child.own.bound());
        self.set_cursor(alias, number, bound);
        true
    }

    /// Appends a step to the child at the cursor. Returns false if there is no child.
    pub(crate) fn push_child_step(&mut self, step: TransformStep) -> Result<bool, TransformError> {
        let Some(cursor) = &mut self.cursor else { return Ok(false) };
        let Some(child) = self.children.get_mut_at(cursor.number) else { return Ok(false) };
        let bound = cursor.bound.and_then(|bound| bound.after(&step));
        let overall = self.overall.as_ref().map(|overall| &overall.composed);
        let is_plain = |bound: &TransformBound| {
            overall.is_none_or(|overall| extent(overall) * bound.largest() < WELL_CONDITIONED)
        };
        let extent = match bound.filter(is_plain) {
            Some(bound) => bound.largest(),
            None => {
                let mut composed = child.own.composed()?;
                composed.append(&step)?;
                overall.map(|overall| overall.after(&composed)).transpose()?;
                extent(&composed)
            }
        };
        child.own.push(step)?;
        self.child_extent = self.child_extent.max(extent);
        cursor.bound = bound;
        Ok(true)
    }

    /// Appends a step to the transform of the whole.
    pub(crate) fn push_overall_step(&mut self, step: TransformStep) -> Result<(), TransformError> {
        let mut composed = *self.overall();
        composed.append(&step)?;
        // Only above this bound is each child checked.
        let is_plain = extent(&composed) * self.child_extent < WELL_CONDITIONED;
        for (_, child) in self.children().filter(|_| !is_plain) {
            composed.after(&child.own.composed()?)?;
        }
        let mut steps = self.overall.take().map_or_else(StepList::default, |overall| overall.steps);
        steps.push(step)?;
        self.overall = Some(Box::new(Overall { steps, composed }));
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use superegg_geom::glam::DVec3;

    use super::*;

    #[test]
    fn hidden_children_are_skipped_and_follow_renames_and_removals() {
        let mut object = Object::default();
        for alias in ["a", "b", "c"] {
            object.push_child(alias, Child::new("egg"));
        }
        let plain = object.clone();
        object.set_hidden("b", true);
        object.set_hidden("c", true);
        let seen = |object: &Object| {
            object.visible_children().map(|(alias, _)| alias.to_owned()).collect::<Vec<_>>()
        };
        assert_eq!(
            (seen(&object), object.children().len(), object == plain),
            (vec!["a".to_owned()], 3, false)
        );
        assert!(!object.rename_child("b", "a") && !object.rename_child("gone", "d"));
        assert!(object.rename_child("c", "d") && object.cursor().is_some_and(|(alias, _)| alias == "d"));
        assert_eq!(object.hidden_children().collect::<Vec<_>>(), ["b", "d"]);
        object.remove_child("d");
        object.set_hidden("b", false);
        assert_eq!((seen(&object), object.hidden.is_none()), (vec!["a".to_owned(), "b".to_owned()], true));
        object.set_hidden("a", true);
        object.show_all();
        assert_eq!(seen(&object), ["a", "b"]);
    }

    #[test]
    fn steps_keep_their_order_and_clones_those_they_had() {
        let mut object = Object::default();
        assert!(object.push_child("egg", Child::new("egg")) && !object.push_child("egg", Child::new("egg")));
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
