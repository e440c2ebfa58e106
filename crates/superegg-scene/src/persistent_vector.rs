//! A persistent vector: a tree of chunks that clones share.

use std::sync::Arc;

/// The logarithm of the number of children of an inner node.
const FANOUT_BITS: u32 = 7;

/// A vector whose clones take constant time and memory: they share all chunks that neither has
/// changed. A chunk has at most `1 << LEAF_BITS` items, and a change after a clone copies one.
#[derive(Clone, Debug)]
pub(crate) struct PersistentVector<T, const LEAF_BITS: u32> {
    /// `None` if there are no items.
    root: Option<Node<T>>,
    /// The number of levels above the leaves.
    height: u32,
    len: usize,
}

/// A node of the tree. All leaves are equally deep, and all nodes full but the last of each level.
#[derive(Clone, Debug)]
enum Node<T> {
    Leaf(Arc<Vec<T>>),
    Inner(Arc<Vec<Node<T>>>),
}

// Not derived: no item is needed for an empty vector.
impl<T, const LEAF_BITS: u32> Default for PersistentVector<T, LEAF_BITS> {
    fn default() -> Self {
        Self { root: None, height: 0, len: 0 }
    }
}

impl<T: PartialEq, const LEAF_BITS: u32> PartialEq for PersistentVector<T, LEAF_BITS> {
    /// Takes no time for chunks that both share.
    fn eq(&self, other: &Self) -> bool {
        self.len == other.len && self.root == other.root
    }
}

impl<T: PartialEq> PartialEq for Node<T> {
    fn eq(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Leaf(a), Self::Leaf(b)) => Arc::ptr_eq(a, b) || a == b,
            (Self::Inner(a), Self::Inner(b)) => Arc::ptr_eq(a, b) || a == b,
            (Self::Leaf(_), Self::Inner(_)) | (Self::Inner(_), Self::Leaf(_)) => false,
        }
    }
}

impl<T, const LEAF_BITS: u32> PersistentVector<T, LEAF_BITS> {
    const LEAF_MASK: usize = (1 << LEAF_BITS) - 1;

    /// The items of leaves, all of which are full but the last one.
    pub(crate) fn from_leaves(leaves: Vec<Vec<T>>) -> Self {
        let len = leaves.iter().map(Vec::len).sum();
        let mut nodes: Vec<Node<T>> = leaves.into_iter().map(|leaf| Node::Leaf(Arc::new(leaf))).collect();
        let mut height = 0;
        while nodes.len() > 1 {
            let mut below = nodes.into_iter().peekable();
            nodes = Vec::new();
            while below.peek().is_some() {
                nodes.push(Node::Inner(Arc::new(below.by_ref().take(1 << FANOUT_BITS).collect())));
            }
            height += 1;
        }
        Self { root: nodes.pop(), height, len }
    }

    pub(crate) fn len(&self) -> usize {
        self.len
    }

    /// The chunk that has the item of an index.
    fn leaf(&self, index: usize) -> Option<&[T]> {
        let (mut node, mut level) = (self.root.as_ref()?, self.height);
        loop {
            match node {
                Node::Leaf(items) => return Some(items),
                Node::Inner(children) => node = children.get(child_index::<LEAF_BITS>(index, level))?,
            }
            level -= 1;
        }
    }

    pub(crate) fn get(&self, index: usize) -> Option<&T> {
        if index >= self.len {
            return None;
        }
        self.leaf(index)?.get(index & Self::LEAF_MASK)
    }

    /// The items, in order.
    pub(crate) fn iter(&self) -> Iter<'_, T, LEAF_BITS> {
        Iter { vector: self, front: 0, back: self.len, front_leaf: &[], back_leaf: &[] }
    }
}

/// The index of the child, at a level above the leaves, that leads to an item.
fn child_index<const LEAF_BITS: u32>(index: usize, level: u32) -> usize {
    (index >> (LEAF_BITS + FANOUT_BITS * (level - 1))) & ((1 << FANOUT_BITS) - 1)
}

impl<T: Clone, const LEAF_BITS: u32> PersistentVector<T, LEAF_BITS> {
    /// Mutable access to an item. Clones no longer share its chunk.
    pub(crate) fn get_mut(&mut self, index: usize) -> Option<&mut T> {
        if index >= self.len {
            return None;
        }
        let (mut node, mut level) = (self.root.as_mut()?, self.height);
        loop {
            match node {
                Node::Leaf(items) => return Arc::make_mut(items).get_mut(index & Self::LEAF_MASK),
                Node::Inner(children) => {
                    let child = child_index::<LEAF_BITS>(index, level);
                    node = Arc::make_mut(children).get_mut(child)?;
                }
            }
            level -= 1;
        }
    }

    pub(crate) fn push(&mut self, item: T) {
        let index = self.len;
        self.len += 1;
        if index == 1 << (LEAF_BITS + FANOUT_BITS * self.height) {
            self.root = self.root.take().map(|root| Node::Inner(Arc::new(vec![root])));
            self.height += 1;
        }
        let mut level = self.height;
        let mut node = self.root.get_or_insert_with(|| Node::Leaf(Arc::default()));
        loop {
            match node {
                Node::Leaf(items) => return Arc::make_mut(items).push(item),
                Node::Inner(children) => {
                    let children = Arc::make_mut(children);
                    let child = child_index::<LEAF_BITS>(index, level);
                    if child == children.len() {
                        // A first leaf grows as it needs to; what follows one is likely to be filled.
                        let leaf = || Node::Leaf(Arc::new(Vec::with_capacity(1 << LEAF_BITS)));
                        children.push(if level == 1 { leaf() } else { Node::Inner(Arc::default()) });
                    }
                    node = &mut children[child];
                }
            }
            level -= 1;
        }
    }
}

impl<T: Clone, const LEAF_BITS: u32> FromIterator<T> for PersistentVector<T, LEAF_BITS> {
    fn from_iter<I: IntoIterator<Item = T>>(items: I) -> Self {
        let mut vector = Self::default();
        items.into_iter().for_each(|item| vector.push(item));
        vector
    }
}

/// The items of a [`PersistentVector`].
#[derive(Clone, Debug)]
pub(crate) struct Iter<'a, T, const LEAF_BITS: u32> {
    vector: &'a PersistentVector<T, LEAF_BITS>,
    front: usize,
    back: usize,
    front_leaf: &'a [T],
    back_leaf: &'a [T],
}

impl<'a, T, const LEAF_BITS: u32> Iterator for Iter<'a, T, LEAF_BITS> {
    type Item = &'a T;

    fn next(&mut self) -> Option<&'a T> {
        if self.front == self.back {
            return None;
        }
        let at = self.front & PersistentVector::<T, LEAF_BITS>::LEAF_MASK;
        if at == 0 {
            self.front_leaf = self.vector.leaf(self.front)?;
        }
        self.front += 1;
        self.front_leaf.get(at)
    }

    fn size_hint(&self) -> (usize, Option<usize>) {
        (self.back - self.front, Some(self.back - self.front))
    }
}

impl<T, const LEAF_BITS: u32> DoubleEndedIterator for Iter<'_, T, LEAF_BITS> {
    fn next_back(&mut self) -> Option<Self::Item> {
        if self.front == self.back {
            return None;
        }
        self.back -= 1;
        let at = self.back & PersistentVector::<T, LEAF_BITS>::LEAF_MASK;
        if self.back_leaf.get(at).is_none() || at == PersistentVector::<T, LEAF_BITS>::LEAF_MASK {
            self.back_leaf = self.vector.leaf(self.back)?;
        }
        self.back_leaf.get(at)
    }
}

impl<T, const LEAF_BITS: u32> ExactSizeIterator for Iter<'_, T, LEAF_BITS> {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_vector_is_a_plain_one_of_which_clones_keep_what_they_had() {
        // Three levels above the leaves.
        let count = (4 << (2 * FANOUT_BITS)) + 5;
        let mut vector = PersistentVector::<usize, 2>::default();
        let mut snapshots = Vec::new();
        for i in 0..count {
            if i % 9973 == 0 || [1, 3, 4, 5, 512, 513, 65536, 65537].contains(&i) {
                snapshots.push(vector.clone());
            }
            vector.push(i);
        }
        let mut plain: Vec<usize> = (0..count).collect();
        for i in (0..count).step_by(101) {
            plain[i] += 7;
            *vector.get_mut(i).unwrap() += 7;
        }
        assert!(vector.iter().eq(&plain) && vector.iter().rev().eq(plain.iter().rev()));
        assert!((0..count).all(|i| vector.get(i) == Some(&plain[i])));
        assert_eq!((vector.get(count), vector.len()), (None, count));
        assert_eq!(vector.get_mut(count), None);
        for snapshot in snapshots {
            assert!(snapshot.iter().copied().eq(0..snapshot.len()));
            assert_eq!(snapshot.get(snapshot.len()), None);
        }
        let again: PersistentVector<usize, 2> = plain.iter().copied().collect();
        let of_leaves =
            PersistentVector::<usize, 2>::from_leaves(plain.chunks(4).map(<[_]>::to_vec).collect());
        assert!(again == vector && again.clone() == again && of_leaves == vector);
        *vector.get_mut(count - 1).unwrap() += 1;
        assert!(again != vector);
    }

    #[test]
    fn items_are_taken_from_both_ends() {
        for count in [0, 1, 4, 5, 9] {
            let vector: PersistentVector<usize, 2> = (0..count).collect();
            for front in 0..=count {
                let mut items = vector.iter();
                assert!(items.by_ref().take(front).copied().eq(0..front));
                assert_eq!(items.len(), count - front);
                assert!(items.rev().copied().eq((front..count).rev()));
            }
        }
    }
}
