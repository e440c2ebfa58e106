//! Stochastic opacity: which rays hit a proxy.
//!
//! A proxy stops only a part of the light, its opacity. Each ray draws a number in [0, 1) and hits the proxy if the number
//! is below the opacity. The number is a hash of the ray's direction and the proxy's path, so that scalar queries, streams
//! and packets decide alike and a picture is reproducible.

use superegg_geom::glam::DVec3;
use superegg_geom::scale_to_unit;

/// Mixes a word into a hash.
fn mix(hash: u64, word: u64) -> u64 {
    let hash = (hash ^ word).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    hash ^ (hash >> 29)
}

/// A hash of a path, made from that of the path above.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct PathHash(u64);

impl PathHash {
    /// The hash of the empty path.
    pub(crate) const ROOT: Self = Self(0x9e37_79b9_7f4a_7c15);

    /// The hash of the path to a child.
    pub(crate) fn child(self, index: u32) -> Self {
        Self(mix(self.0, u64::from(index)))
    }

    pub(crate) fn of(indices: &[u32]) -> Self {
        indices.iter().fold(Self::ROOT, |hash, &index| hash.child(index))
    }
}

/// The numbers that one ray draws.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Lottery(u64);

impl Lottery {
    /// For a ray of this direction. Directions of other lengths draw other numbers.
    pub(crate) fn of(direction: DVec3) -> Self {
        Self(direction.to_array().into_iter().fold(0, |hash, coordinate| mix(hash, coordinate.to_bits())))
    }

    /// For a ray of this direction, scaled to the order of 1 by a power of two.
    pub(crate) fn of_scaled(direction: DVec3) -> Self {
        Self::of(scale_to_unit(direction).map_or(DVec3::ZERO, |(direction, _)| direction))
    }

    /// Whether the ray hits the proxy at a path, which has this opacity.
    pub(crate) fn hits(self, path: PathHash, opacity: f64) -> bool {
        self.draw(path) < opacity
    }

    /// A number in [0, 1) that depends on all bits of the direction and the path.
    pub(crate) fn draw(self, PathHash(path): PathHash) -> f64 {
        let hash = mix(mix(self.0, path), path.rotate_left(32));
        (hash >> 11) as f64 / (1u64 << 53) as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn draws_are_even_for_paths_and_for_directions() {
        let direction = |i: u32| DVec3::new(f64::from(i).sin(), f64::from(i).cos(), 0.3);
        for opacity in [0.1, 0.5, 0.9] {
            let count = 40_000;
            let rays = (0..count).filter(|&i| Lottery::of(direction(i)).hits(PathHash::of(&[3, 7]), opacity));
            let paths = (0..count).filter(|&i| {
                Lottery::of(direction(1)).hits(PathHash::of(&[i % 3, i % 5, i, i / 7]), opacity)
            });
            for hits in [rays.count(), paths.count()] {
                let share = hits as f64 / f64::from(count);
                // Four standard deviations.
                assert!((share - opacity).abs() < 0.01, "{share} {opacity}");
            }
        }
    }
}
