//! Stochastic opacity: which rays hit a proxy.
//!
//! A proxy stops only a part of the light, its opacity. Each ray draws a number in [0, 1) and hits the proxy if the number
//! is below the opacity. The number is a hash of the ray's direction and the proxy's path, so that scalar queries, streams
//! and packets decide alike and a picture is reproducible.

use superegg_geom::glam::DVec3;
use superegg_geom::scale_to_unit;

/// The numbers that one ray draws.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Lottery {
    direction_bits: [u64; 3],
}

impl Lottery {
    /// For a ray of this direction. Directions of other lengths draw other numbers.
    pub(crate) fn of(direction: DVec3) -> Self {
        Self { direction_bits: direction.to_array().map(f64::to_bits) }
    }

    /// For a ray of this direction, scaled to the order of 1 by a power of two.
    pub(crate) fn of_scaled(direction: DVec3) -> Self {
        Self::of(scale_to_unit(direction).map_or(DVec3::ZERO, |(direction, _)| direction))
    }

    /// Whether the ray hits the proxy at `path`, which has this opacity.
    pub(crate) fn hits(&self, path: &[u32], opacity: f64) -> bool {
        self.draw(path) < opacity
    }

    /// A number in [0, 1) that depends on all bits of the direction and the path.
    fn draw(&self, path: &[u32]) -> f64 {
        let mut hash = 0x9e37_79b9_7f4a_7c15u64;
        let mut mix = |word: u64| {
            hash = (hash ^ word).wrapping_mul(0xbf58_476d_1ce4_e5b9);
            hash ^= hash >> 29;
        };
        self.direction_bits.into_iter().for_each(&mut mix);
        path.iter().for_each(|&index| mix(u64::from(index)));
        (hash >> 11) as f64 / (1u64 << 53) as f64
    }
}
