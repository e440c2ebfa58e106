//! f32 lane kernels for rays against convex superquadrics (e, n <= 2): AVX-512, AVX2, NEON or one lane, selected when the
//! program runs. Not a stable interface.
//!
//! - [`packet`]: packets of 16 rays with a common origin, against the boxes of a tree and against one shape.
//! - [`stream`]: incoherent rays, each against a box or a shape of its own.
//! - [`batch`]: many rays against one shape, by streams and refinement.
//! - [`refine`]: the f64 refinement of the crossings that f32 found.
//! - [`verify`]: f64 proofs of facts that f32 found about shapes that are not convex.
//!
//! Kernels return candidates. Each answer carries a bound on its error or is marked unresolved; the caller refines it in
//! f64, or traces the ray by the exact path of [`crate::Superquadric::intersect`]. No kernel misses a shape.
//!
//! `norm` evaluates N and its derivatives, `root` searches along a ray; packets and streams share both.

pub mod batch;
mod norm;
pub mod packet;
mod powers;
pub mod refine;
mod root;
pub mod stream;
pub mod verify;

pub use powers::LanePowers;

use superegg_simd::{Arch, Simd, WithSimd};

/// The number of f32 lanes of this machine.
pub fn lane_count() -> usize {
    struct Count;
    impl WithSimd for Count {
        type Output = usize;
        fn with_simd<S: Simd>(self, _: S) -> usize {
            S::F32_LANES
        }
    }
    Arch::new().dispatch(Count)
}
