//! The width of a ray, which decides the level of detail.

/// A group whose bounding box has a diameter below this multiple of the ray's width is hit as its proxy.
pub const LEAST_FOOTPRINT: f64 = 0.5;

/// The width of a ray along its length: `width + spread * t`, in world units.
///
/// For a camera ray it is the width of the pixel, or of the part of the pixel that the ray samples.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Footprint {
    /// The width at the origin.
    pub width: f64,
    /// The growth of the width for each unit of t.
    pub spread: f64,
}

impl Footprint {
    /// No width: every group is opened.
    pub const NONE: Self = Self { width: 0.0, spread: 0.0 };

    /// The width at `t`.
    pub fn at(&self, t: f64) -> f64 {
        self.width + self.spread * t
    }

    /// Whether a group of diameter `size`, at `t` or beyond, is too small to be opened.
    pub(crate) fn hides(&self, size: f64, t: f64) -> bool {
        size < LEAST_FOOTPRINT * self.at(t)
    }
}
