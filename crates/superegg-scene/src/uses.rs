//! Which children refer to a name.

use imbl::{HashMap, OrdSet};
use smol_str::SmolStr;

use crate::object::Object;

/// The children of a scene by the name that they refer to. Cloning takes constant time.
#[derive(Clone, Debug, Default)]
pub(crate) struct Uses {
    /// Object and alias of each child, by its target.
    by_target: HashMap<SmolStr, OrdSet<(SmolStr, SmolStr)>>,
}

impl Uses {
    /// The uses in these objects.
    pub(crate) fn of<'s>(objects: impl Iterator<Item = (&'s str, &'s Object)>) -> Self {
        let mut uses = Self::default();
        objects.for_each(|(name, object)| uses.add_object(name, object));
        uses
    }

    pub(crate) fn add(&mut self, target: &str, object: &str, alias: &str) {
        self.by_target.entry(target.into()).or_default().insert((object.into(), alias.into()));
    }

    pub(crate) fn remove(&mut self, target: &str, object: &str, alias: &str) {
        let left = self.by_target.get_mut(target).map(|uses| {
            uses.remove(&(object.into(), alias.into()));
            uses.len()
        });
        if left == Some(0) {
            self.by_target.remove(target);
        }
    }

    /// Adds the children of an object.
    pub(crate) fn add_object(&mut self, name: &str, object: &Object) {
        object.children().for_each(|(alias, child)| self.add(child.target(), name, alias));
    }

    /// Removes the children of an object.
    pub(crate) fn remove_object(&mut self, name: &str, object: &Object) {
        object.children().for_each(|(alias, child)| self.remove(child.target(), name, alias));
    }

    /// The object and alias of each child that refers to a name.
    pub(crate) fn of_target(&self, target: &str) -> impl Iterator<Item = (&str, &str)> {
        let uses = self.by_target.get(target).into_iter().flatten();
        uses.map(|(object, alias)| (object.as_str(), alias.as_str()))
    }
}
