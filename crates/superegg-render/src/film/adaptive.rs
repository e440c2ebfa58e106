//! Adaptive sampling: the stopping rule of pixels.

use superegg_scene::Picture;

use crate::film::accumulate::TileAccumulator;
use crate::film::develop::Development;

/// The rule by which the pixels of a tile stop.
#[derive(Clone, Copy, Debug)]
pub(crate) struct StoppingRule {
    /// The noise threshold. A pixel continues while its standard error, or that of one of its eight
    /// neighbours in the tile, is not below it. 0 means a fixed number of samples.
    noise: f64,
    /// The number of samples of the first round, and the minimum of later rounds.
    pub(crate) first: u32,
    /// The largest number of samples of a pixel.
    most: u32,
    development: Development,
}

impl StoppingRule {
    pub(crate) fn of(picture: &Picture, development: Development) -> Self {
        let first = picture.samples.max(1);
        Self { noise: picture.noise, first, most: picture.most_samples.max(first), development }
    }

    /// Whether all pixels stop after the first round.
    pub(crate) fn is_fixed(&self) -> bool {
        self.noise <= 0.0
    }

    /// The number of samples of each pixel in the next round; all 0 at the end. Pixels are in rows
    /// of `columns`.
    ///
    /// A few samples may agree by chance. So a pixel continues as long as one of its eight
    /// neighbours has too large an error.
    pub(crate) fn next_round(&self, columns: usize, accumulator: &TileAccumulator) -> Vec<u32> {
        let pixels = accumulator.pixels();
        if self.is_fixed() {
            return vec![0; pixels];
        }
        let is_noisy: Vec<bool> =
            (0..pixels).map(|pixel| accumulator.error(pixel, &self.development) >= self.noise).collect();
        let rows = pixels / columns.max(1);
        let around = |at: usize, end: usize| at.saturating_sub(1)..(at + 2).min(end);
        let is_active = |x: usize, y: usize| {
            around(y, rows).any(|y| around(x, columns).any(|x| is_noisy[y * columns + x]))
        };
        let next = |pixel: usize| {
            let count = accumulator.count(pixel);
            let left = self.most.saturating_sub(count);
            // A quarter more each time: few rounds, and few samples too many.
            let wanted = self.first.max(count / 4);
            if is_active(pixel % columns, pixel / columns) { wanted.min(left) } else { 0 }
        };
        (0..pixels).map(next).collect()
    }
}

#[cfg(test)]
mod tests {
    use superegg_geom::glam::DVec3;

    use super::*;
    use crate::camera::filter::FilterMass;
    use crate::film::accumulate::AccumulatorLayout;

    fn tile(pixels: &[Vec<f64>]) -> TileAccumulator {
        let mut accumulator = TileAccumulator::new(FilterMass { positive: 1.0, negative: 0.0 });
        accumulator.start(
            pixels.len(),
            AccumulatorLayout { squares: true, layers: false, passes: false, mattes: false },
        );
        for (pixel, values) in pixels.iter().enumerate() {
            values.iter().for_each(|&value| accumulator.add(pixel, DVec3::splat(value), None, false));
        }
        accumulator
    }

    fn stopping(noise: f64, most_samples: u32) -> StoppingRule {
        let picture = Picture { noise, most_samples, ..Picture::default() };
        StoppingRule::of(&picture, Development::of(&picture))
    }

    #[test]
    fn a_noisy_pixel_keeps_those_beside_it_going() {
        let mut pixels = vec![vec![0.5; 4]; 5 * 4];
        let stopping = stopping(0.01, 1024);
        assert_eq!(stopping.next_round(5, &tile(&pixels)), [0; 20]);
        pixels[0] = vec![0.0, 1.0, 0.0, 1.0];
        let expected = [4, 4, 0, 0, 0, 4, 4, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0];
        assert_eq!(stopping.next_round(5, &tile(&pixels)), expected);
    }

    #[test]
    fn rounds_grow_and_end_at_the_most() {
        let noisy = |count: usize| tile(&[[0.0, 1.0].repeat(count / 2)]);
        assert_eq!(stopping(0.01, 1024).next_round(1, &noisy(100)), [25]);
        assert_eq!(stopping(0.01, 102).next_round(1, &noisy(100)), [2]);
        assert_eq!(stopping(0.01, 100).next_round(1, &noisy(100)), [0]);
        assert_eq!(stopping(0.0, 100).next_round(1, &noisy(10)), [0]);
        assert_eq!(stopping(0.06, 1024).next_round(1, &noisy(1000)), [0]);
    }
}
