//! Where in a pixel its samples lie.

use superegg_geom::glam::DVec2;

/// Stratified samples of a pixel: `count` cells of equal area, one jittered sample in each. Depends on nothing but the pixel and the
/// number of the sample, so that a picture is the same in any order. A single sample is the pixel's centre.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sampler {
    count: u32,
}

impl Sampler {
    pub(crate) fn new(count: u32) -> Self {
        Self { count: count.max(1) }
    }

    /// The place of each sample within pixel (x, y), in pixels from its top left corner, in [0, 1).
    pub(crate) fn places(self, x: u32, y: u32) -> impl Iterator<Item = DVec2> {
        // Rows of cells as even as can be; a row's height goes with its number of cells, which makes all areas equal.
        let rows = (f64::from(self.count).sqrt().round() as u32).max(1);
        let per_row = move |row: u32| self.count / rows + u32::from(row < self.count % rows);
        let mut above = 0;
        (0..rows).flat_map(move |row| {
            let cells = per_row(row);
            let first = above;
            above += cells;
            (0..cells).map(move |cell| {
                let jitter = self.jitter(x, y, first + cell);
                DVec2::new(
                    (f64::from(cell) + jitter.x) / f64::from(cells),
                    (f64::from(first) + f64::from(cells) * jitter.y) / f64::from(self.count),
                )
            })
        })
    }

    fn jitter(self, x: u32, y: u32, sample: u32) -> DVec2 {
        if self.count == 1 {
            return DVec2::splat(0.5);
        }
        let bits = mix(u64::from(x) << 32 | u64::from(y)).wrapping_add(u64::from(sample));
        let bits = mix(bits);
        let unit = |half: u32| f64::from(half) / (f64::from(u32::MAX) + 1.0);
        DVec2::new(unit((bits >> 32) as u32), unit(bits as u32))
    }
}

/// A bijection of 64 bits that looks random (the finaliser of SplitMix64; Steele, Lea and Flood 2014).
fn mix(bits: u64) -> u64 {
    let bits = bits.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    bits ^ (bits >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_sample_is_the_centre() {
        assert_eq!(Sampler::new(1).places(3, 4).collect::<Vec<_>>(), [DVec2::splat(0.5)]);
    }

    #[test]
    fn every_count_has_its_samples_in_the_pixel_with_an_unbiased_mean() {
        for count in [2, 3, 4, 5, 7, 16, 31] {
            let mut sum = DVec2::ZERO;
            let pixels = 2000;
            for x in 0..pixels {
                let places: Vec<_> = Sampler::new(count).places(x, 7).collect();
                assert_eq!(places.len(), count as usize);
                assert!(places.iter().all(|p| (0.0..1.0).contains(&p.x) && (0.0..1.0).contains(&p.y)));
                sum += places.iter().sum::<DVec2>() / f64::from(count);
            }
            let mean = sum / f64::from(pixels);
            assert!((mean - 0.5).abs().max_element() < 0.02, "{count}: {mean}");
        }
    }

    #[test]
    fn four_samples_take_a_quarter_each() {
        for x in 0..100 {
            let mut quarters: Vec<_> = Sampler::new(4)
                .places(x, 1)
                .map(|p| (u32::from(p.x >= 0.5), u32::from(p.y >= 0.5)))
                .collect();
            quarters.sort_unstable();
            assert_eq!(quarters, [(0, 0), (0, 1), (1, 0), (1, 1)]);
        }
    }
}
