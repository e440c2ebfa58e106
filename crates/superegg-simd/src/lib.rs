//! SIMD lanes for the kernels: vectors of f32 lanes ([`Lanes`], [`Triple`]), truth values ([`Mask`]), and the aligned
//! columns that they are loaded from and stored to ([`Column`]); logarithms and powers in f64 ([`power`]).
//!
//! Kernels are generic over [`Simd`] and written once. [`Arch::dispatch`] selects AVX-512 (16 lanes), AVX2 (8), NEON (4)
//! or one lane when the program runs. This is the only crate that depends on pulp, which supplies the instructions.
//!
//! Rules for callers: mark each function between `dispatch` and the lanes `#[inline(always)]`, and write loops instead of
//! iterators and closures that compute. A closure that is not inlined once made a picture take 1.6 times as long.

mod arch;
mod bits;
mod column;
pub mod power;
mod triple;
mod vector;

#[cfg(target_arch = "x86_64")]
pub use arch::half_width;
pub use bits::{bits, register_bits};
pub use column::Column;
pub use pulp::{Arch, Scalar, Simd, WithSimd};
pub use triple::{Linear, Triple};
pub use vector::{Lanes, Mask};
