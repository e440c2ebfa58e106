//! The fixed pattern of the samples of a pixel.

use superegg_geom::glam::DVec2;

/// Stratified samples of a pixel: rows of cells of equal area, with one sample in each. The offset
/// in the cell is chosen so that no two samples have the same column or row of the pixel; four
/// samples are a rotated grid. So nearly horizontal and vertical edges get one shade per sample.
/// The pattern is the same in each pixel, so there is no noise. A single sample is at the centre of
/// the pixel.
#[derive(Clone, Copy, Debug)]
pub(crate) struct StratifiedPattern {
    count: u32,
}

impl StratifiedPattern {
    pub(crate) fn new(count: u32) -> Self {
        Self { count: count.max(1) }
    }

    /// The points within a pixel, in pixels from its top left corner, in (0, 1).
    pub(crate) fn points(self) -> impl Iterator<Item = DVec2> {
        // The numbers of cells per row differ by at most 1. The height of a row is proportional to
        // its number of cells, so that all cells have the same area.
        let rows = (f64::from(self.count).sqrt().round() as u32).max(1);
        let mut cells_above = 0;
        (0..rows).flat_map(move |row| {
            let cells = self.count / rows + u32::from(row < self.count % rows);
            let first = cells_above;
            cells_above += cells;
            (0..cells).map(move |cell| {
                let offset = (f64::from(row) + 0.5) / f64::from(rows);
                DVec2::new(
                    (f64::from(cell) + offset) / f64::from(cells),
                    (f64::from(first + cell) + 0.5) / f64::from(self.count),
                )
            })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_sample_is_the_centre() {
        assert_eq!(StratifiedPattern::new(1).points().collect::<Vec<_>>(), [DVec2::splat(0.5)]);
    }

    #[test]
    fn four_samples_are_the_rotated_square() {
        let expected = [(0.125, 0.125), (0.625, 0.375), (0.375, 0.625), (0.875, 0.875)].map(DVec2::from);
        assert_eq!(StratifiedPattern::new(4).points().collect::<Vec<_>>(), expected);
    }

    #[test]
    fn every_count_has_its_samples_around_the_centre_each_in_a_row_of_its_own() {
        for count in [2, 3, 5, 7, 9, 16, 31, 64] {
            let points: Vec<DVec2> = StratifiedPattern::new(count).points().collect();
            assert_eq!(points.len(), count as usize);
            assert!(points.iter().all(|p| p.cmpgt(DVec2::ZERO).all() && p.cmplt(DVec2::ONE).all()));
            let mean = points.iter().sum::<DVec2>() / f64::from(count);
            assert!((mean - 0.5).abs().max_element() < 0.05, "{count}: {mean}");
            assert!(points.windows(2).all(|pair| pair[0].y < pair[1].y));
        }
    }
}
