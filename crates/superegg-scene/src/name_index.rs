//! Numbers by the hashes of their names.

use std::hash::BuildHasher;

use foldhash::fast::RandomState;

use crate::persistent_vector::PersistentVector;

/// The logarithm of the number of slots that a change after a clone copies.
const LEAF_BITS: u32 = 9;

/// A persistent hash table from names to numbers. It holds no names: who looks up says whether a
/// number is that of the name. A number that has lost its name may stay.
#[derive(Clone, Debug, Default)]
pub(crate) struct NameIndex {
    hasher: RandomState,
    /// A power of two of slots, or none. A free slot is 0; the upper half of another one is that of
    /// the name's hash, the lower half the number plus 1.
    slots: PersistentVector<u64, LEAF_BITS>,
    /// The number of slots that are not free, at most three quarters.
    used: usize,
}

impl NameIndex {
    /// The index of `count` numbers with their names.
    pub(crate) fn of<'a>(count: usize, names: impl Iterator<Item = (u32, &'a str)>) -> Self {
        let hasher = RandomState::default();
        let length = (2 * count + 1).next_power_of_two();
        let leaf = length.min(1 << LEAF_BITS);
        let mut leaves = vec![vec![0; leaf]; length / leaf];
        for (number, name) in names.take(count) {
            let hash = hasher.hash_one(name);
            let mut at = hash as usize & (length - 1);
            while leaves[at >> LEAF_BITS][at & (leaf - 1)] != 0 {
                at = (at + 1) & (length - 1);
            }
            leaves[at >> LEAF_BITS][at & (leaf - 1)] = slot(hash, number);
        }
        Self { hasher, slots: PersistentVector::from_leaves(leaves), used: count }
    }

    /// Whether there are no slots.
    pub(crate) fn is_empty(&self) -> bool {
        self.slots.len() == 0
    }

    /// Whether another name needs a larger index.
    pub(crate) fn is_full(&self) -> bool {
        4 * (self.used + 1) > 3 * self.slots.len()
    }

    /// The number of a name. `is_named` says whether a number has the name.
    pub(crate) fn find(&self, name: &str, is_named: impl Fn(u32) -> bool) -> Option<u32> {
        let hash = self.hasher.hash_one(name);
        let mut at = hash as usize & (self.slots.len().wrapping_sub(1));
        loop {
            match *self.slots.get(at)? {
                0 => return None,
                held if held >> 32 == hash >> 32 && is_named(number(held)) => return Some(number(held)),
                _ => at = (at + 1) & (self.slots.len() - 1),
            }
        }
    }

    /// Adds the number of a name. The index must not be full.
    pub(crate) fn insert(&mut self, name: &str, number: u32) {
        let hash = self.hasher.hash_one(name);
        let mask = self.slots.len().wrapping_sub(1);
        let mut at = hash as usize & mask;
        while self.slots.get(at).is_some_and(|held| *held != 0) {
            at = (at + 1) & mask;
        }
        if let Some(free) = self.slots.get_mut(at) {
            *free = slot(hash, number);
            self.used += 1;
        }
    }
}

fn slot(hash: u64, number: u32) -> u64 {
    (hash & !u64::from(u32::MAX)) | (u64::from(number) + 1)
}

fn number(slot: u64) -> u32 {
    (slot as u32).wrapping_sub(1)
}
