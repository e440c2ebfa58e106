//! The positions of a pixel's samples on the film.

use superegg_geom::glam::DVec2;
use superegg_scene::Picture;

use crate::camera::filter::{FilterMass, FilterSampler};
use crate::camera::sobol::SampleKey;
use crate::camera::stratified::StratifiedPattern;

/// The position of a sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SamplePosition {
    /// In pixels from the top left corner of the picture.
    pub(crate) film_px: DVec2,
    /// Whether the filter is negative there.
    pub(crate) is_negative: bool,
}

impl SamplePosition {
    /// The position with the same offset in another pixel; `self` is in the first.
    pub(crate) fn in_pixel(self, (x, y): (u32, u32)) -> Self {
        Self { film_px: self.film_px + DVec2::new(f64::from(x), f64::from(y)), ..self }
    }
}

/// The choice of a [`SampleKey`] for the position on the film.
const FILM: u32 = 4;

/// Positions for all samples of a picture.
#[derive(Clone, Debug)]
pub(crate) struct SamplePlacement {
    filter: FilterSampler,
    /// Points of the unit square, the same in each pixel ([`StratifiedPattern`]), so that
    /// neighbours have the same noise. Empty for adaptive sampling, where the number of samples is
    /// not known: each pixel then has its own Sobol sequence, whose prefixes are all well
    /// distributed.
    pattern: Vec<DVec2>,
}

impl SamplePlacement {
    pub(crate) fn of(picture: &Picture) -> Self {
        let is_fixed = picture.noise <= 0.0;
        let pattern = if is_fixed {
            StratifiedPattern::new(picture.samples.max(1)).points().collect()
        } else {
            Vec::new()
        };
        Self { filter: FilterSampler::new(picture.filter), pattern }
    }

    /// The mass of the filter's positive and negative parts.
    pub(crate) fn mass(&self) -> FilterMass {
        self.filter.mass
    }

    /// The position of sample `index`, counted from 0, of a pixel.
    pub(crate) fn position(&self, (x, y): (u32, u32), index: u32) -> SamplePosition {
        let within = self.shared_position(index).unwrap_or_else(|| {
            let (film_px, is_negative) =
                self.filter.sample(SampleKey::new((x, y), index).branch(FILM).point(0, 1));
            SamplePosition { film_px, is_negative }
        });
        within.in_pixel((x, y))
    }

    /// The position of sample `index` in the first pixel, if it is the same in every pixel.
    pub(crate) fn shared_position(&self, index: u32) -> Option<SamplePosition> {
        let (film_px, is_negative) = self.filter.sample(*self.pattern.get(index as usize)?);
        Some(SamplePosition { film_px, is_negative })
    }
}

#[cfg(test)]
mod tests {
    use superegg_scene::Filter;

    use super::*;

    #[test]
    fn the_box_with_a_fixed_count_keeps_its_pattern() {
        let placement = SamplePlacement::of(&Picture { samples: 4, ..Picture::default() });
        let positions: Vec<DVec2> = (0..4).map(|index| placement.position((3, 5), index).film_px).collect();
        let expected: Vec<DVec2> =
            StratifiedPattern::new(4).points().map(|p| p + DVec2::new(3.0, 5.0)).collect();
        assert_eq!(positions, expected);
    }

    #[test]
    fn a_fixed_count_lies_around_the_centre_with_the_width_of_its_filter() {
        for (filter, variance) in [(Filter::Tent, 1.0 / 6.0), (Filter::Gaussian, 0.25)] {
            let placement = SamplePlacement::of(&Picture { samples: 64, filter, ..Picture::default() });
            let offsets: Vec<DVec2> = (0..64)
                .map(|index| placement.position((7, 9), index).film_px - DVec2::new(7.5, 9.5))
                .collect();
            let mean = offsets.iter().sum::<DVec2>() / 64.0;
            let spread = offsets.iter().map(|offset| offset * offset).sum::<DVec2>() / 64.0;
            assert!(mean.abs().max_element() < 0.02, "{filter:?}: {mean}");
            assert!((spread - variance).abs().max_element() < 0.04 * variance, "{filter:?}: {spread}");
        }
    }

    #[test]
    fn pixels_that_stop_by_themselves_have_sequences_of_their_own() {
        let placement = SamplePlacement::of(&Picture { noise: 0.01, ..Picture::default() });
        let within = |x, y| placement.position((x, y), 0).film_px - DVec2::new(f64::from(x), f64::from(y));
        assert!(within(0, 0) != within(1, 0) && within(0, 0) != within(0, 1));
        assert!(within(5, 9).cmpge(DVec2::ZERO).all() && within(5, 9).cmple(DVec2::ONE).all());
    }
}
