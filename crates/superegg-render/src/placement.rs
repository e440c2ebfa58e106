//! Where the samples of a pixel lie on the film.

use superegg_geom::glam::DVec2;
use superegg_scene::Picture;

use crate::filter::{FilterSampler, Shares};
use crate::sampler::Sampler;
use crate::sequence::SampleKey;

/// A place for a sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Place {
    /// In pixels from the top left corner of the picture.
    pub(crate) film_px: DVec2,
    /// Whether the filter is negative there.
    pub(crate) is_negative: bool,
}

impl Place {
    /// The same place in another pixel than the first.
    pub(crate) fn in_pixel(self, (x, y): (u32, u32)) -> Self {
        Self { film_px: self.film_px + DVec2::new(f64::from(x), f64::from(y)), ..self }
    }
}

/// The choice of a [`SampleKey`] for the place on the film.
const FILM: u32 = 4;

/// The places of a picture's samples.
#[derive(Clone, Debug)]
pub(crate) struct Placement {
    filter: FilterSampler,
    /// Points of the unit square for a number of samples that is known before, the same for each pixel ([`Sampler`]): no pixel has another
    /// noise than the one beside it. Empty where pixels stop by themselves: each then has a sequence of its own, of which any first part is well
    /// distributed.
    pattern: Vec<DVec2>,
}

impl Placement {
    pub(crate) fn of(picture: &Picture) -> Self {
        let is_fixed = picture.noise <= 0.0;
        let pattern =
            if is_fixed { Sampler::new(picture.samples.max(1)).places().collect() } else { Vec::new() };
        Self { filter: FilterSampler::new(picture.filter), pattern }
    }

    /// What samples of either sign count for.
    pub(crate) fn shares(&self) -> Shares {
        self.filter.shares
    }

    /// The place of a pixel's sample, by its index from 0.
    pub(crate) fn place(&self, (x, y): (u32, u32), index: u32) -> Place {
        let within = self.same_place(index).unwrap_or_else(|| {
            let (film_px, is_negative) =
                self.filter.place(SampleKey::new((x, y), index).branch(FILM).point(0, 1));
            Place { film_px, is_negative }
        });
        within.in_pixel((x, y))
    }

    /// The place of a sample in the first pixel, by its index from 0, where it is the same in every pixel.
    pub(crate) fn same_place(&self, index: u32) -> Option<Place> {
        let (film_px, is_negative) = self.filter.place(*self.pattern.get(index as usize)?);
        Some(Place { film_px, is_negative })
    }
}

#[cfg(test)]
mod tests {
    use superegg_scene::Filter;

    use super::*;

    #[test]
    fn the_box_with_a_fixed_count_keeps_its_pattern() {
        let placement = Placement::of(&Picture { samples: 4, ..Picture::default() });
        let places: Vec<DVec2> = (0..4).map(|index| placement.place((3, 5), index).film_px).collect();
        let expected: Vec<DVec2> = Sampler::new(4).places().map(|p| p + DVec2::new(3.0, 5.0)).collect();
        assert_eq!(places, expected);
    }

    #[test]
    fn a_fixed_count_lies_around_the_centre_with_the_width_of_its_filter() {
        for (filter, variance) in [(Filter::Tent, 1.0 / 6.0), (Filter::Gaussian, 0.25)] {
            let placement = Placement::of(&Picture { samples: 64, filter, ..Picture::default() });
            let offsets: Vec<DVec2> =
                (0..64).map(|index| placement.place((7, 9), index).film_px - DVec2::new(7.5, 9.5)).collect();
            let mean = offsets.iter().sum::<DVec2>() / 64.0;
            let spread = offsets.iter().map(|offset| offset * offset).sum::<DVec2>() / 64.0;
            assert!(mean.abs().max_element() < 0.02, "{filter:?}: {mean}");
            assert!((spread - variance).abs().max_element() < 0.04 * variance, "{filter:?}: {spread}");
        }
    }

    #[test]
    fn pixels_that_stop_by_themselves_have_sequences_of_their_own() {
        let placement = Placement::of(&Picture { noise: 0.01, ..Picture::default() });
        let within = |x, y| placement.place((x, y), 0).film_px - DVec2::new(f64::from(x), f64::from(y));
        assert!(within(0, 0) != within(1, 0) && within(0, 0) != within(0, 1));
        assert!(within(5, 9).cmpge(DVec2::ZERO).all() && within(5, 9).cmple(DVec2::ONE).all());
    }
}
