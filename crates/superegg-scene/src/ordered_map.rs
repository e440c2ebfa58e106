//! A persistent map from names to values that keeps the order of insertion.

use smol_str::SmolStr;

use crate::name_index::NameIndex;
use crate::persistent_vector::{self, PersistentVector};

/// The logarithm of the number of entries that a change after a clone copies.
const LEAF_BITS: u32 = 6;

/// Names of up to this many entries are compared one by one. Most objects have few children.
const MOST_COMPARED: usize = 16;

/// A persistent map: cloning takes constant time and memory, and clones share everything that
/// neither changes. A snapshot of a scene, or a step of an undo history, is therefore cheap. Two
/// maps are equal if they have equal names and values in the same order.
///
/// A change after a clone copies the values of 64 entries, so values should be small, or shared.
#[derive(Clone, Debug)]
pub(crate) struct OrderedMap<V> {
    /// `None` where an entry was removed, so that no other one moves.
    entries: PersistentVector<Option<Entry<V>>, LEAF_BITS>,
    /// The number of entries that are not removed.
    count: usize,
    /// The number of the last entry that is not removed; any number if there is none.
    last: usize,
    /// Empty as long as names are compared one by one.
    index: NameIndex,
}

#[derive(Clone, Debug, PartialEq)]
struct Entry<V> {
    name: SmolStr,
    value: V,
}

// Not derived: no value is needed for an empty map.
impl<V> Default for OrderedMap<V> {
    fn default() -> Self {
        Self { entries: PersistentVector::default(), count: 0, last: 0, index: NameIndex::default() }
    }
}

impl<V: PartialEq> PartialEq for OrderedMap<V> {
    fn eq(&self, other: &Self) -> bool {
        // Where entries were removed depends on history, not on content.
        self.count == other.count && (self.entries == other.entries || self.iter().eq(other.iter()))
    }
}

impl<V: PartialEq> OrderedMap<V> {
    /// Whether both have the same names with equal values, in any order.
    pub(crate) fn has_same_entries(&self, other: &Self) -> bool {
        self.count == other.count
            && (self.entries == other.entries
                || self.iter().all(|(name, value)| other.get(name) == Some(value)))
    }
}

impl<V> OrderedMap<V> {
    fn entry(&self, number: usize) -> Option<&Entry<V>> {
        self.entries.get(number)?.as_ref()
    }

    /// The number of a name. It stays the same until an entry is removed.
    pub(crate) fn number_of(&self, name: &str) -> Option<usize> {
        if self.index.is_empty() {
            return self.entries.iter().position(|entry| entry.as_ref().is_some_and(|e| e.name == name));
        }
        let is_named = |number: u32| self.entry(number as usize).is_some_and(|entry| entry.name == name);
        self.index.find(name, is_named).map(|number| number as usize)
    }

    pub(crate) fn get(&self, name: &str) -> Option<&V> {
        self.get_at(self.number_of(name)?)
    }

    /// The value of a number.
    pub(crate) fn get_at(&self, number: usize) -> Option<&V> {
        self.entry(number).map(|entry| &entry.value)
    }

    /// The name of a number.
    pub(crate) fn name_at(&self, number: usize) -> Option<&str> {
        self.entry(number).map(|entry| &*entry.name)
    }

    pub(crate) fn contains(&self, name: &str) -> bool {
        self.number_of(name).is_some()
    }

    /// Names and values, in order.
    pub(crate) fn iter(&self) -> Iter<'_, V> {
        Iter { entries: self.entries.iter(), left: self.count }
    }

    /// The numbers, names and values, in order.
    pub(crate) fn numbered(&self) -> impl Iterator<Item = (usize, &str, &V)> {
        let numbered = self.entries.iter().enumerate();
        numbered
            .filter_map(|(number, entry)| entry.as_ref().map(|entry| (number, &*entry.name, &entry.value)))
    }

    /// The name of the last entry.
    pub(crate) fn last_name(&self) -> Option<&str> {
        self.name_at(self.last)
    }
}

impl<V: Clone> OrderedMap<V> {
    /// Mutable access to the value of a name. Clones no longer share that value.
    pub(crate) fn get_mut(&mut self, name: &str) -> Option<&mut V> {
        self.get_mut_at(self.number_of(name)?)
    }

    /// Mutable access to the value of a number.
    pub(crate) fn get_mut_at(&mut self, number: usize) -> Option<&mut V> {
        self.entries.get_mut(number)?.as_mut().map(|entry| &mut entry.value)
    }

    /// Replaces the value of a name at its position, or appends it.
    pub(crate) fn insert(&mut self, name: &str, value: V) {
        match self.number_of(name) {
            Some(number) => {
                if let Some(held) = self.get_mut_at(number) {
                    *held = value;
                }
            }
            None => {
                self.push(name, value);
            }
        }
    }

    /// Appends a name and returns its number; `None` if the map has the name.
    pub(crate) fn push(&mut self, name: &str, value: V) -> Option<usize> {
        let number = self.entries.len();
        if !self.index_name(name, number) {
            return None;
        }
        self.entries.push(Some(Entry { name: name.into(), value }));
        self.count += 1;
        self.last = number;
        Some(number)
    }

    /// Clones the value that another map has under a name, at its position here. Does nothing unless
    /// both maps have the name.
    pub(crate) fn share(&mut self, name: &str, other: &Self) {
        if let (Some(held), Some(shared)) = (self.get_mut(name), other.get(name)) {
            held.clone_from(shared);
        }
    }

    /// Removes an entry; the others keep their order. Returns whether it existed.
    pub(crate) fn remove(&mut self, name: &str) -> bool {
        let Some(number) = self.number_of(name) else { return false };
        let Some(entry) = self.entries.get_mut(number) else { return false };
        *entry = None;
        self.count -= 1;
        if number == self.last {
            // Each removed entry is passed once.
            self.last = (0..number).rev().find(|&number| self.entry(number).is_some()).unwrap_or(0);
        }
        if self.entries.len() > 2 * self.count + MOST_COMPARED {
            self.entries = self.entries.iter().filter(|entry| entry.is_some()).cloned().collect();
            self.last = self.count.saturating_sub(1);
            self.rebuild_index();
        }
        true
    }

    /// Renames an entry, which keeps its position. Returns false if `name` is unknown or `new`
    /// exists.
    pub(crate) fn rename(&mut self, name: &str, new: &str) -> bool {
        if self.contains(new) {
            return false;
        }
        let Some(number) = self.number_of(name) else { return false };
        if !self.index_name(new, number) {
            return false;
        }
        if let Some(Some(entry)) = self.entries.get_mut(number) {
            entry.name = new.into();
        }
        true
    }

    /// Makes the number of a new name known. Returns false if the map has the name.
    fn index_name(&mut self, name: &str, number: usize) -> bool {
        if self.index.is_empty() && self.entries.len() < MOST_COMPARED {
            return !self.contains(name);
        }
        if self.index.is_full() {
            // An index without lost names grows faster than it is made anew.
            if !self.index.is_empty() && self.index.used() == self.count {
                self.index.grow();
            } else {
                self.rebuild_index();
            }
        }
        let entries = &self.entries;
        let is_named = |number: u32| {
            entries.get(number as usize).and_then(Option::as_ref).is_some_and(|entry| entry.name == name)
        };
        self.index.insert(name, number as u32, is_named)
    }

    fn rebuild_index(&mut self) {
        if self.entries.len() < MOST_COMPARED {
            self.index = NameIndex::default();
            return;
        }
        let numbered = (0..).zip(self.entries.iter());
        let names = numbered.filter_map(|(number, entry)| Some((number, &*entry.as_ref()?.name)));
        self.index = NameIndex::of(self.count, names);
    }
}

/// The names and values of an [`OrderedMap`].
#[derive(Clone, Debug)]
pub(crate) struct Iter<'a, V> {
    entries: persistent_vector::Iter<'a, Option<Entry<V>>, LEAF_BITS>,
    left: usize,
}

impl<'a, V> Iter<'a, V> {
    fn found(&mut self, entry: Option<&'a Entry<V>>) -> Option<(&'a str, &'a V)> {
        let entry = entry?;
        self.left -= 1;
        Some((&entry.name, &entry.value))
    }
}

impl<'a, V> Iterator for Iter<'a, V> {
    type Item = (&'a str, &'a V);

    fn next(&mut self) -> Option<Self::Item> {
        let entry = self.entries.find_map(Option::as_ref);
        self.found(entry)
    }

    fn size_hint(&self) -> (usize, Option<usize>) {
        (self.left, Some(self.left))
    }
}

impl<V> DoubleEndedIterator for Iter<'_, V> {
    fn next_back(&mut self) -> Option<Self::Item> {
        let entry = self.entries.by_ref().rev().find_map(Option::as_ref);
        self.found(entry)
    }
}

impl<V> ExactSizeIterator for Iter<'_, V> {}

#[cfg(test)]
mod tests {
    use std::collections::HashMap;

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

    /// The same as a list of pairs.
    #[test]
    fn a_map_of_any_size_is_a_list_of_pairs() {
        let mut state = 11_u64;
        let mut random = |below: usize| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (state >> 33) as usize % below
        };
        for most in [3, 16, 17, 40, 3000] {
            let (mut map, mut list) = (OrderedMap::default(), Vec::<(String, usize)>::new());
            let mut snapshots = Vec::new();
            let name = |i: usize| {
                if i.is_multiple_of(2) { format!("n{i}") } else { format!("a name longer than 23 {i}") }
            };
            for step in 0..8 * most {
                let (one, other) = (name(random(most)), name(random(most)));
                let at = list.iter().position(|(held, _)| *held == one);
                // Rising and falling.
                let removes = random(8) < if step / most % 2 == 0 { 1 } else { 6 };
                if removes {
                    assert_eq!(map.remove(&one), at.is_some());
                    at.map(|at| list.remove(at));
                } else if random(8) == 0 {
                    let is_new = !list.iter().any(|(held, _)| *held == other);
                    assert_eq!(map.rename(&one, &other), at.is_some() && is_new);
                    if let Some(at) = at.filter(|_| is_new) {
                        list[at].0 = other;
                    }
                } else {
                    map.insert(&one, step);
                    match at {
                        Some(at) => list[at].1 = step,
                        None => list.push((one, step)),
                    }
                }
                if random(most) < 8 {
                    snapshots.push((map.clone(), list.clone()));
                }
            }
            snapshots.push((map, list));
            for (map, list) in snapshots {
                let pairs = || list.iter().map(|(name, value)| (name.as_str(), value));
                assert!(map.iter().eq(pairs()) && map.iter().rev().eq(pairs().rev()));
                assert_eq!(map.iter().len(), list.len());
                assert!(map.numbered().all(|(number, name, _)| map.number_of(name) == Some(number)));
                let by_name: HashMap<&str, &usize> = pairs().collect();
                assert!((0..most).all(|i| map.get(&name(i)) == by_name.get(&*name(i)).copied()));
                assert_eq!(map.last_name(), list.last().map(|(name, _)| name.as_str()));
            }
        }
    }
}
