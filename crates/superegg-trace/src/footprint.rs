//! How wide a ray is, so that what is much smaller need not be opened.

/// A group is not opened where its box is smaller than this part of the ray's width: it stands in as a whole.
pub const LEAST_FOOTPRINT: f64 = 0.5;

/// The width of a ray in world units: that of the pixel, or the part of it, that the ray stands for.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Footprint {
    /// At the ray's origin.
    pub width: f64,
    /// By which it grows for each unit of the ray's t.
    pub spread: f64,
}

impl Footprint {
    /// A ray without width: everything is opened.
    pub const NONE: Self = Self { width: 0.0, spread: 0.0 };

    /// The width at a place on the ray.
    pub fn at(&self, t: f64) -> f64 {
        self.width + self.spread * t
    }

    /// Whether something of this size, from `t` on along the ray, is too small to be opened.
    pub(crate) fn hides(&self, size: f64, t: f64) -> bool {
        size < LEAST_FOOTPRINT * self.at(t)
    }
}

/// A number in [0, 1) that depends on all bits of its arguments and on nothing else: whether a ray meets a stand-in that stops a part of the light.
pub(crate) fn chance(ray: [u64; 3], path: &[u32]) -> f64 {
    let mut hash = 0x9e37_79b9_7f4a_7c15u64;
    let mut mix = |word: u64| {
        hash = (hash ^ word).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        hash ^= hash >> 29;
    };
    ray.into_iter().for_each(&mut mix);
    path.iter().for_each(|&place| mix(u64::from(place)));
    (hash >> 11) as f64 / (1u64 << 53) as f64
}
