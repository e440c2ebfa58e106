//! When a pixel has samples enough.

use superegg_scene::Picture;

use crate::develop::Development;
use crate::filter::Shares;
use crate::gather::Gathered;

/// When the pixels of a tile stop.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Stopping {
    /// A pixel goes on while its standard error, or that of a pixel beside it in its tile, is not below this. 0: none goes on.
    noise: f64,
    /// Samples in the first round, and the least of any later one.
    pub(crate) first: u32,
    /// The most samples of a pixel.
    most: u32,
    development: Development,
    shares: Shares,
}

impl Stopping {
    pub(crate) fn of(picture: &Picture, development: Development, shares: Shares) -> Self {
        let first = picture.samples.max(1);
        Self { noise: picture.noise, first, most: picture.most_samples.max(first), development, shares }
    }

    /// How many samples each pixel of a tile of so many columns takes in the next round; all 0 at the end. The pixels are in rows.
    ///
    /// A few samples may agree by chance, so a pixel is not believed as long as one of the eight around it has too much error.
    pub(crate) fn next_round(&self, columns: usize, pixels: &[Gathered]) -> Vec<u32> {
        if self.noise <= 0.0 {
            return vec![0; pixels.len()];
        }
        let is_noisy: Vec<bool> =
            pixels.iter().map(|pixel| pixel.error(self.shares, &self.development) >= self.noise).collect();
        let rows = pixels.len() / columns.max(1);
        let around = |at: usize, end: usize| at.saturating_sub(1)..(at + 2).min(end);
        let goes_on = |x: usize, y: usize| {
            around(y, rows).any(|y| around(x, columns).any(|x| is_noisy[y * columns + x]))
        };
        let next = |(place, pixel): (usize, &Gathered)| {
            let left = self.most.saturating_sub(pixel.count());
            // A quarter more each time: few rounds, and little beyond what is needed.
            let wanted = self.first.max(pixel.count() / 4);
            if goes_on(place % columns, place / columns) { wanted.min(left) } else { 0 }
        };
        pixels.iter().enumerate().map(next).collect()
    }
}

#[cfg(test)]
mod tests {
    use superegg_geom::glam::DVec3;

    use super::*;
    use crate::tile::Sighting;

    fn pixel(values: &[f64]) -> Gathered {
        let mut gathered = Gathered::default();
        for &value in values {
            gathered.add(&Sighting { color: DVec3::splat(value), first: None }, false);
        }
        gathered
    }

    fn stopping(noise: f64, most_samples: u32) -> Stopping {
        let picture = Picture { noise, most_samples, ..Picture::default() };
        let shares = Shares { positive: 1.0, negative: 0.0 };
        Stopping::of(&picture, Development::of(&picture), shares)
    }

    #[test]
    fn a_noisy_pixel_keeps_those_beside_it_going() {
        let mut tile = vec![pixel(&[0.5; 4]); 5 * 4];
        let stopping = stopping(0.01, 1024);
        assert_eq!(stopping.next_round(5, &tile), [0; 20]);
        tile[0] = pixel(&[0.0, 1.0, 0.0, 1.0]);
        let expected = [4, 4, 0, 0, 0, 4, 4, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0];
        assert_eq!(stopping.next_round(5, &tile), expected);
    }

    #[test]
    fn rounds_grow_and_end_at_the_most() {
        let noisy = |count: usize| pixel(&[0.0, 1.0].repeat(count / 2));
        assert_eq!(stopping(0.01, 1024).next_round(1, &[noisy(100)]), [25]);
        assert_eq!(stopping(0.01, 102).next_round(1, &[noisy(100)]), [2]);
        assert_eq!(stopping(0.01, 100).next_round(1, &[noisy(100)]), [0]);
        assert_eq!(stopping(0.0, 100).next_round(1, &[noisy(10)]), [0]);
        assert_eq!(stopping(0.06, 1024).next_round(1, &[noisy(1000)]), [0]);
    }
}
