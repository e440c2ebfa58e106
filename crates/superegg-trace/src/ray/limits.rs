//! Bounds on the work of rays through scenes whose parts overlap.

use thiserror::Error;

use super::footprint::Footprint;

/// The bounds on the work for one exact ray. Only a deep fractal whose parts overlap reaches them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct RayLimits {
    /// The most boxes and shapes that are tested.
    pub boxes: u64,
}

impl Default for RayLimits {
    /// 4,000,000 boxes: less than a second.
    fn default() -> Self {
        Self { boxes: 4_000_000 }
    }
}

impl RayLimits {
    /// The same limits with this number of boxes.
    #[must_use]
    pub fn with_boxes(self, boxes: u64) -> Self {
        Self { boxes }
    }
}

/// A ray needs more work than its limits allow.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
#[error("the ray passes through more overlapping parts than {boxes} boxes show; a smaller depth has fewer")]
#[non_exhaustive]
pub struct LimitReached {
    /// [`RayLimits::boxes`].
    pub boxes: u64,
}

/// Counts the rays whose work was bounded: some parts that overlap were hit as their proxies, although the ray is narrow
/// enough to open them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Coarsened {
    /// The number of rays.
    pub rays: u64,
}

/// The part of the scene's size that is added to the width of rays at the first doubling.
const LEAST_PART: f64 = 1.0 / (1 << 16) as f64;

impl Footprint {
    /// The footprint that decides about proxies after a ray's width was doubled so often, in a scene of this size. Rays
    /// without width get one too, so that every traversal ends.
    pub(crate) fn doubled(&self, times: u32, scene_size: f64) -> Self {
        if times == 0 {
            return *self;
        }
        let factor = f64::from(times).exp2();
        let Self { width, spread } = *self;
        Self { width: width * factor + scene_size * LEAST_PART * factor, spread: spread * factor }
    }
}
