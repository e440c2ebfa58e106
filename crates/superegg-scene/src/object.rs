//! Objects: named groups of children.

use indexmap::IndexMap;
use superegg_geom::{Transform, TransformError, TransformStep};

/// An ordered list of transform steps with the map that they compose to.
#[derive(Clone, Debug, PartialEq)]
struct StepList {
    steps: Vec<TransformStep>,
    composed: Transform,
}

impl StepList {
    const EMPTY: Self = Self { steps: Vec::new(), composed: Transform::IDENTITY };

    /// What the list composes to with one more step behind it.
    fn composed_with(&self, step: &TransformStep) -> Result<Transform, TransformError> {
        Transform::from_steps([step])?.after(&self.composed)
    }

    fn push(&mut self, step: TransformStep, composed: Transform) {
        self.steps.push(step);
        self.composed = composed;
    }
}

/// A primitive or object within an object.
#[derive(Clone, Debug, PartialEq)]
pub struct Child {
    target: String,
    own: StepList,
}

impl Child {
    pub(crate) fn new(target: String) -> Self {
        Self { target, own: StepList::EMPTY }
    }

    /// What the child stands for: the name of a primitive or object.
    pub fn target(&self) -> &str {
        &self.target
    }

    /// Its own transform, in the order written: the first step acts on a point first.
    pub fn steps(&self) -> &[TransformStep] {
        &self.own.steps
    }
}

/// A named group of children with a transform of the whole.
#[derive(Clone, Debug, PartialEq)]
pub struct Object {
    children: IndexMap<String, Child>,
    overall: StepList,
    cursor: Option<usize>,
}

impl Default for Object {
    fn default() -> Self {
        Self { children: IndexMap::new(), overall: StepList::EMPTY, cursor: None }
    }
}

impl Object {
    /// The children with their aliases, in the order they were added.
    pub fn children(&self) -> impl ExactSizeIterator<Item = (&str, &Child)> {
        self.children.iter().map(|(alias, child)| (alias.as_str(), child))
    }

    /// The transform of the whole, in the order written. It acts after each child's own.
    pub fn overall_steps(&self) -> &[TransformStep] {
        &self.overall.steps
    }

    /// Alias and child that the next transform moves: the last one added or chosen. Each object keeps its own.
    pub fn cursor(&self) -> Option<(&str, &Child)> {
        let (alias, child) = self.children.get_index(self.cursor?)?;
        Some((alias, child))
    }

    /// The child with this alias.
    pub fn child(&self, alias: &str) -> Option<&Child> {
        self.children.get(alias)
    }

    /// The map from a child's space to the space that this object stands in: the child's steps, then the overall ones.
    ///
    /// # Errors
    /// The two lists together leave the range of f64; a scene never lets them.
    pub fn parent_from_child(&self, child: &Child) -> Result<Transform, TransformError> {
        self.overall.composed.after(&child.own.composed)
    }

    pub(crate) fn push_child(&mut self, alias: String, child: Child) {
        self.cursor = Some(self.children.len());
        self.children.insert(alias, child);
    }

    /// Moves the cursor to a child. Returns whether there is one of this alias.
    pub(crate) fn move_cursor(&mut self, alias: &str) -> bool {
        let found = self.children.get_index_of(alias);
        self.cursor = found.or(self.cursor);
        found.is_some()
    }

    /// Appends a step to the child at the cursor. Returns whether there is one.
    pub(crate) fn push_child_step(&mut self, step: TransformStep) -> Result<bool, TransformError> {
        let Some((_, child)) = self.cursor.and_then(|index| self.children.get_index_mut(index)) else {
            return Ok(false);
        };
        let composed = child.own.composed_with(&step)?;
        self.overall.composed.after(&composed)?;
        child.own.push(step, composed);
        Ok(true)
    }

    /// Appends a step to the transform of the whole.
    pub(crate) fn push_overall_step(&mut self, step: TransformStep) -> Result<(), TransformError> {
        let composed = self.overall.composed_with(&step)?;
        for child in self.children.values() {
            composed.after(&child.own.composed)?;
        }
        self.overall.push(step, composed);
        Ok(())
    }
}
