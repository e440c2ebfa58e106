//! Columns: the structure-of-arrays memory of the kernels.

use std::ops::{Index, IndexMut};

use pulp::Simd;

use crate::vector::{Lanes, Mask};

/// `N` numbers, aligned so that registers load and store them whole. `N` is a multiple of 16, the widest register.
///
/// Registers are numbered from 0: register `i` holds the numbers from `i * S::F32_LANES` on. `load` and `store` with
/// `K > 1` use the `K` registers from `i` on.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(64))]
pub struct Column<T, const N: usize>(pub [T; N]);

impl<T: Copy, const N: usize> Column<T, N> {
    /// The same number `N` times.
    #[inline(always)]
    pub const fn splat(x: T) -> Self {
        Self([x; N])
    }
}

impl<T, const N: usize> Index<usize> for Column<T, N> {
    type Output = T;
    #[inline(always)]
    fn index(&self, i: usize) -> &T {
        &self.0[i]
    }
}

impl<T, const N: usize> IndexMut<usize> for Column<T, N> {
    #[inline(always)]
    fn index_mut(&mut self, i: usize) -> &mut T {
        &mut self.0[i]
    }
}

impl<const N: usize> Column<f32, N> {
    /// Loads `K` registers.
    #[inline(always)]
    pub fn load<S: Simd, const K: usize>(&self, simd: S, i: usize) -> Lanes<S, K> {
        Lanes::load(simd, &self.0, i)
    }

    /// Stores `K` registers.
    #[inline(always)]
    pub fn store<S: Simd, const K: usize>(&mut self, i: usize, lanes: Lanes<S, K>) {
        lanes.store(&mut self.0, i);
    }

    /// Stores the lanes of one register for which the mask is true; the others keep their numbers.
    #[inline(always)]
    pub fn store_where<S: Simd>(&mut self, mask: Mask<S>, i: usize, lanes: Lanes<S>) {
        let register = &mut S::as_mut_simd_f32s(&mut self.0).0[i];
        *register = mask.select(lanes, lanes.with(kept(register))).register();
    }
}

impl<const N: usize> Column<u32, N> {
    /// Stores one number in all lanes of a register.
    #[inline(always)]
    pub fn store<S: Simd>(&mut self, simd: S, i: usize, x: u32) {
        S::as_mut_simd_u32s(&mut self.0).0[i] = simd.splat_u32s(x);
    }

    /// Stores one number in the lanes of a register for which the mask is true.
    #[inline(always)]
    pub fn store_where<S: Simd>(&mut self, mask: Mask<S>, i: usize, x: u32) {
        let register = &mut S::as_mut_simd_u32s(&mut self.0).0[i];
        *register = mask.select_u32(mask.simd().splat_u32s(x), kept(register));
    }

    /// Copies the lanes of a register for which the mask is true from another column.
    #[inline(always)]
    pub fn copy_where<S: Simd>(&mut self, mask: Mask<S>, i: usize, from: &Self) {
        let register = &mut S::as_mut_simd_u32s(&mut self.0).0[i];
        *register = mask.select_u32(S::as_simd_u32s(&from.0).0[i], kept(register));
    }

    /// True in the lanes of a register that hold `x`.
    #[inline(always)]
    pub fn equals<S: Simd>(&self, simd: S, i: usize, x: u32) -> Mask<S> {
        Mask::of_equal(simd, S::as_simd_u32s(&self.0).0[i], simd.splat_u32s(x))
    }
}

impl<const N: usize> Column<f64, N> {
    /// The registers of a column of f64.
    #[inline(always)]
    pub fn registers<S: Simd>(&self, _: S) -> &[S::f64s] {
        S::as_simd_f64s(&self.0).0
    }
}

/// A register of which some lanes will be replaced.
///
/// The compiler turns the load, the choice of lanes and the store into one masked store, which is slow on AMD's
/// processors without AVX-512. It does not do so after a volatile load.
#[inline(always)]
#[expect(unsafe_code, reason = "only a volatile load is kept apart from the store")]
fn kept<T: Copy>(register: &T) -> T {
    // SAFETY: a reference is valid for reads.
    unsafe { std::ptr::from_ref(register).read_volatile() }
}

#[cfg(test)]
mod tests {
    use pulp::{Arch, Scalar, WithSimd};

    use super::*;

    /// Doubles the numbers above a limit, and marks them with 9 in a second column.
    struct DoubleAbove {
        x: Column<f32, 32>,
        limit: f32,
    }

    impl WithSimd for DoubleAbove {
        type Output = (Column<f32, 32>, Column<u32, 32>, u32);

        #[inline(always)]
        fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
            let Self { x, limit } = self;
            let (mut doubled, mut marks, mut nines) = (x, Column::splat(1), 0);
            for i in 0..32 / S::F32_LANES {
                let lanes = x.load::<S, 1>(simd, i);
                let above = lanes.all(limit).lt(lanes);
                doubled.store_where(above, i, lanes + lanes);
                marks.store_where(above, i, 9);
                nines += marks.equals(simd, i, 9).bits().count_ones();
            }
            (doubled, marks, nines)
        }
    }

    #[test]
    fn stores_reach_the_lanes_of_the_mask_and_no_others() {
        let x = Column(std::array::from_fn(|i| (i * 7 % 32) as f32));
        for limit in [-1.0, 11.0, 40.0] {
            let work = || DoubleAbove { x, limit };
            for (doubled, marks, nines) in [Arch::new().dispatch(work()), work().with_simd(Scalar)] {
                for i in 0..32 {
                    let is_above = x[i] > limit;
                    assert_eq!(doubled[i], if is_above { 2.0 * x[i] } else { x[i] });
                    assert_eq!(marks[i], if is_above { 9 } else { 1 });
                }
                assert_eq!(nines as usize, x.0.iter().filter(|x| **x > limit).count());
            }
        }
    }
}
