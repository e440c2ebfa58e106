//! A persistent map from names to values that keeps the order of insertion.

use std::sync::Arc;

use foldhash::fast::RandomState;
use imbl::shared_ptr::DefaultSharedPtr;
use imbl::{GenericHashMap, OrdMap};

/// A persistent map: cloning takes constant time and memory, and clones share everything that
/// neither changes. A snapshot of a scene, or a step of an undo history, is therefore cheap. Two
/// maps are equal if they have equal names and values in the same order.
#[derive(Clone, Debug)]
pub(crate) struct OrderedMap<V> {
    /// Entries by an increasing number, so that no entry moves when another is removed.
    entries: OrdMap<u64, (Arc<str>, Arc<V>)>,
    number_of: GenericHashMap<Arc<str>, u64, RandomState, DefaultSharedPtr>,
}

// Not derived: no value is needed for an empty map.
impl<V> Default for OrderedMap<V> {
    fn default() -> Self {
        Self { entries: OrdMap::new(), number_of: GenericHashMap::default() }
    }
}

impl<V: PartialEq> PartialEq for OrderedMap<V> {
    fn eq(&self, other: &Self) -> bool {
        // The numbers depend on history, not only on content.
        self.entries.len() == other.entries.len() && self.entries.values().eq(other.entries.values())
    }
}

impl<V: PartialEq> OrderedMap<V> {
    /// Whether both have the same names with equal values, in any order.
    pub(crate) fn has_same_entries(&self, other: &Self) -> bool {
        let in_other = |name: &str| Some(&other.entries.get(other.number_of.get(name)?)?.1);
        self.entries.len() == other.entries.len()
            && self.entries.values().all(|(name, value)| {
                in_other(name).is_some_and(|other| Arc::ptr_eq(other, value) || other == value)
            })
    }
}

impl<V: Clone> OrderedMap<V> {
    pub(crate) fn get(&self, name: &str) -> Option<&V> {
        Some(&*self.entries.get(self.number_of.get(name)?)?.1)
    }

    /// Mutable access to the value of a name. Clones no longer share that value.
    pub(crate) fn get_mut(&mut self, name: &str) -> Option<&mut V> {
        let number = self.number_of.get(name)?;
        self.entries.get_mut(number).map(|(_, value)| Arc::make_mut(value))
    }

    pub(crate) fn contains(&self, name: &str) -> bool {
        self.number_of.contains_key(name)
    }

    /// Replaces the value of a name at its position, or appends it.
    pub(crate) fn insert(&mut self, name: &str, value: V) {
        if let Some(held) = self.get_mut(name) {
            *held = value;
            return;
        }
        let number = self.entries.get_max().map_or(0, |(last, _)| last + 1);
        let name: Arc<str> = name.into();
        self.number_of.insert(Arc::clone(&name), number);
        self.entries.insert(number, (name, Arc::new(value)));
    }

    /// Shares the value that another map has under a name, at its position here. Does nothing unless
    /// both maps have the name.
    pub(crate) fn share(&mut self, name: &str, other: &Self) {
        let shared = other.number_of.get(name).and_then(|number| other.entries.get(number));
        let held = self.number_of.get(name).and_then(|number| self.entries.get_mut(number));
        if let (Some((_, value)), Some((_, shared))) = (held, shared) {
            *value = Arc::clone(shared);
        }
    }

    /// Removes an entry; the others keep their order. Returns whether it existed.
    pub(crate) fn remove(&mut self, name: &str) -> bool {
        let number = self.number_of.remove(name);
        number.is_some_and(|number| self.entries.remove(&number).is_some())
    }

    /// Renames an entry, which keeps its position. Returns false if `name` is unknown or `new`
    /// exists.
    pub(crate) fn rename(&mut self, name: &str, new: &str) -> bool {
        if self.contains(new) {
            return false;
        }
        let Some(number) = self.number_of.remove(name) else { return false };
        let new: Arc<str> = new.into();
        if let Some((held, _)) = self.entries.get_mut(&number) {
            *held = Arc::clone(&new);
        }
        self.number_of.insert(new, number);
        true
    }

    /// Names and values, in order.
    pub(crate) fn iter(&self) -> impl ExactSizeIterator<Item = (&str, &V)> + DoubleEndedIterator {
        self.entries.values().map(|(name, value)| (&**name, &**value))
    }

    /// The name of the last entry.
    pub(crate) fn last_name(&self) -> Option<&str> {
        self.entries.get_max().map(|(_, (name, _))| &**name)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clones_do_not_see_later_changes_and_the_order_stays() {
        let mut map = OrderedMap::default();
        for (name, value) in [("a", 1), ("b", 2), ("c", 3)] {
            map.insert(name, value);
        }
        let before = map.clone();
        map.insert("b", 20);
        assert!(map.rename("a", "z") && !map.rename("z", "c") && !map.rename("a", "y"));
        assert!(map.remove("c") && !map.remove("c"));
        map.insert("c", 30);
        assert_eq!(map.iter().collect::<Vec<_>>(), [("z", &1), ("b", &20), ("c", &30)]);
        assert_eq!(before.iter().collect::<Vec<_>>(), [("a", &1), ("b", &2), ("c", &3)]);
        assert_eq!((map.last_name(), map.get("a"), map.get("z")), (Some("c"), None, Some(&1)));
        let mut again = OrderedMap::default();
        for (name, value) in [("z", 1), ("b", 20), ("c", 30)] {
            again.insert(name, value);
        }
        assert!(again == map && before != map && again.has_same_entries(&map));
        again.rename("z", "y");
        assert!(!again.has_same_entries(&map));
    }
}
