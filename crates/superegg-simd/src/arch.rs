//! Instruction sets that code generic over [`Simd`] can test for.
//!
//! Each test compares type ids, which the compiler folds to a constant: the branch costs nothing.

#![cfg(target_arch = "x86_64")]

use std::any::Any;

use pulp::Simd;
use pulp::x86::{V3, V4};

/// The AVX-512 instructions, where `S` is AVX-512.
#[inline(always)]
pub(crate) fn avx512<S: Simd>(simd: S) -> Option<V4> {
    (&simd as &dyn Any).downcast_ref::<V4>().copied()
}

/// The AVX2 instructions, where `S` is AVX2.
#[inline(always)]
pub(crate) fn avx2<S: Simd>(simd: S) -> Option<V3> {
    (&simd as &dyn Any).downcast_ref::<V3>().copied()
}

/// AVX2 where `S` is AVX-512: for work on eight numbers, which fill half of a register of `S`.
#[inline(always)]
pub fn half_width<S: Simd>(simd: S) -> Option<V3> {
    avx512(simd).map(|v4| *v4)
}
