//! The numbers of a picture, one for each pixel.

use std::fmt;
use std::ops::{Deref, DerefMut};

use bytemuck::Pod;
use memmap2::MmapMut;

/// A number, or some, of each pixel. It is a slice; where it lies is nobody's concern.
pub(crate) enum Plane<T> {
    Heap(Vec<T>),
    /// The system hands memory out page by page as it is first touched, which takes longer than to write it: what is large asks for large pages.
    Pages {
        map: MmapMut,
        count: usize,
    },
}

/// Planes of so many bytes have pages of their own: two large ones.
const LARGE_BYTES: usize = 4 << 20;

impl<T: Pod> Plane<T> {
    /// All zero.
    pub(crate) fn zeros(count: usize) -> Self {
        let bytes = count.saturating_mul(size_of::<T>());
        let map = (bytes >= LARGE_BYTES).then(|| MmapMut::map_anon(bytes).ok()).flatten();
        let Some(map) = map else { return Self::Heap(vec![T::zeroed(); count]) };
        // Where there are none it is as good without.
        #[cfg(target_os = "linux")]
        let _ = map.advise(memmap2::Advice::HugePage);
        Self::Pages { map, count }
    }
}

impl<T> From<Vec<T>> for Plane<T> {
    fn from(numbers: Vec<T>) -> Self {
        Self::Heap(numbers)
    }
}

impl<T: Pod> Deref for Plane<T> {
    type Target = [T];

    fn deref(&self) -> &[T] {
        match self {
            Self::Heap(numbers) => numbers,
            Self::Pages { map, count } => bytemuck::cast_slice(&map[..count * size_of::<T>()]),
        }
    }
}

impl<T: Pod> DerefMut for Plane<T> {
    fn deref_mut(&mut self) -> &mut [T] {
        match self {
            Self::Heap(numbers) => numbers,
            Self::Pages { map, count } => bytemuck::cast_slice_mut(&mut map[..*count * size_of::<T>()]),
        }
    }
}

impl<T: Pod> Clone for Plane<T> {
    fn clone(&self) -> Self {
        let mut copy = Self::zeros(self.len());
        copy.copy_from_slice(self);
        copy
    }
}

impl<T: Pod + PartialEq> PartialEq for Plane<T> {
    fn eq(&self, other: &Self) -> bool {
        **self == **other
    }
}

impl<T: Pod + fmt::Debug> fmt::Debug for Plane<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_list().entries(self.iter()).finish()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn small_and_large_planes_are_slices_alike() {
        for count in [0usize, 1, 1000, LARGE_BYTES / 4 - 1, LARGE_BYTES / 4, LARGE_BYTES / 4 + 77] {
            let mut plane = Plane::<u32>::zeros(count);
            assert_eq!(matches!(plane, Plane::Pages { .. }), count >= LARGE_BYTES / 4);
            assert!(plane.len() == count && plane.iter().all(|number| *number == 0));
            plane.iter_mut().zip(0..).for_each(|(to, number)| *to = number);
            let numbers: Vec<u32> = (0..count as u32).collect();
            assert!(*plane == *numbers && plane == plane.clone() && plane == Plane::from(numbers));
            if let Some(last) = plane.clone().last_mut() {
                *last = 7_777_777;
                assert_eq!(plane.last(), Some(&(count as u32 - 1)));
            }
        }
    }
}
