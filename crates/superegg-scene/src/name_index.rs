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
    /// The index of `count` numbers with their names. It is not full.
    pub(crate) fn of<'a>(count: usize, names: impl Iterator<Item = (u32, &'a str)>) -> Self {
        let hasher = RandomState::default();
        let slots = names.take(count).map(|(number, name)| slot(hasher.hash_one(name), number));
        let slots = slots_of((2 * count + 3).next_power_of_two(), slots);
        Self { hasher, slots, used: count }
    }

    /// Makes room for as many names again. The names need not be hashed: slots have the bits of
    /// their hashes that count.
    pub(crate) fn grow(&mut self) {
        let used = self.slots.iter().copied().filter(|slot| *slot != 0);
        self.slots = slots_of(2 * self.slots.len(), used);
    }

    /// The number of names that were added.
    pub(crate) fn used(&self) -> usize {
        self.used
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
        let mut at = first_slot(hash, self.slots.len());
        loop {
            match *self.slots.get(at)? {
                0 => return None,
                held if held >> 32 == hash >> 32 && is_named(number(held)) => return Some(number(held)),
                _ => at = (at + 1) & (self.slots.len() - 1),
            }
        }
    }

    /// Adds the number of a name, unless another number has the name. Returns whether it was added.
    /// `is_named` is as in [`NameIndex::find`]. The index must not be full.
    pub(crate) fn insert(&mut self, name: &str, number: u32, is_named: impl Fn(u32) -> bool) -> bool {
        let hash = self.hasher.hash_one(name);
        let mask = self.slots.len().wrapping_sub(1);
        let mut at = first_slot(hash, self.slots.len());
        while let Some(held) = self.slots.get(at).copied().filter(|held| *held != 0) {
            if held >> 32 == hash >> 32 && is_named(self::number(held)) {
                return false;
            }
            at = (at + 1) & mask;
        }
        if let Some(free) = self.slots.get_mut(at) {
            *free = slot(hash, number);
            self.used += 1;
        }
        true
    }
}

/// A table of this many slots, a power of two, with some used ones.
fn slots_of(length: usize, used: impl Iterator<Item = u64>) -> PersistentVector<u64, LEAF_BITS> {
    let leaf = length.min(1 << LEAF_BITS);
    let mut leaves = vec![vec![0; leaf]; length / leaf];
    for slot in used {
        let mut at = first_slot(slot, length);
        while leaves[at >> LEAF_BITS][at & (leaf - 1)] != 0 {
            at = (at + 1) & (length - 1);
        }
        leaves[at >> LEAF_BITS][at & (leaf - 1)] = slot;
    }
    PersistentVector::from_leaves(leaves)
}

/// Where the search for a name begins, from its hash or its slot: by the half that both have.
fn first_slot(hash: u64, length: usize) -> usize {
    (hash >> 32) as usize & length.wrapping_sub(1)
}

fn slot(hash: u64, number: u32) -> u64 {
    (hash & !u64::from(u32::MAX)) | (u64::from(number) + 1)
}

fn number(slot: u64) -> u32 {
    (slot as u32).wrapping_sub(1)
}
