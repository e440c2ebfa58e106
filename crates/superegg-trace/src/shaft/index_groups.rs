//! Groups of neighbours with the same key.

use std::collections::HashMap;
use std::hash::Hash;
use std::ops::Range;

use foldhash::fast::RandomState;

/// The indices of items by their keys, in groups of neighbours.
#[derive(Debug, Default)]
pub struct IndexGroups {
    /// The indices, one group after the other.
    order: Vec<usize>,
    groups: Vec<Range<usize>>,
    /// The items that belong to no group.
    single: Vec<usize>,
}

impl IndexGroups {
    /// Groups of at most `most` items that have one key, in their order. The order of groups is that of the first items with
    /// their keys. Items without a key belong to no group.
    pub fn of<K: Copy + Eq + Hash>(keys: impl ExactSizeIterator<Item = Option<K>>, most: usize) -> Self {
        let mut numbers: HashMap<K, usize, RandomState> = HashMap::default();
        let mut numbered: Vec<(usize, usize)> = Vec::with_capacity(keys.len());
        let (mut counts, mut single) = (Vec::<usize>::new(), Vec::new());
        let mut last = None;
        for (index, key) in keys.enumerate() {
            let Some(key) = key else {
                single.push(index);
                continue;
            };
            let number = match last {
                Some((last_key, number)) if last_key == key => number,
                _ => *numbers.entry(key).or_insert_with(|| {
                    counts.push(0);
                    counts.len() - 1
                }),
            };
            last = Some((key, number));
            counts[number] += 1;
            numbered.push((number, index));
        }
        let (mut groups, mut first) = (Vec::with_capacity(numbered.len() / most + counts.len()), 0);
        // The counts become the places of the next items.
        for count in &mut counts {
            let end = first + std::mem::replace(count, first);
            groups.extend((first..end).step_by(most).map(|first| first..end.min(first + most)));
            first = end;
        }
        let mut order = vec![0; numbered.len()];
        for (number, index) in numbered {
            order[counts[number]] = index;
            counts[number] += 1;
        }
        Self { order, groups, single }
    }

    /// The indices of the items of each group: at least one.
    pub fn groups(&self) -> impl ExactSizeIterator<Item = &[usize]> {
        self.groups.iter().map(|range| &self.order[range.clone()])
    }

    /// The indices of the items that belong to no group.
    pub fn single(&self) -> &[usize] {
        &self.single
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn groups_have_one_key_and_keep_the_order() {
        let keys = [Some('b'), None, Some('a'), Some('b'), Some('b'), None, Some('a'), Some('b')];
        let groups = IndexGroups::of(keys.into_iter(), 3);
        assert_eq!(groups.groups().collect::<Vec<_>>(), [&[0, 3, 4][..], &[7], &[2, 6]]);
        assert_eq!(groups.single(), [1, 5]);
        assert_eq!(IndexGroups::of([None::<u8>; 2].into_iter(), 3).groups().len(), 0);
    }
}
