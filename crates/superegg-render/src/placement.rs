//! Where the samples of a pixel lie on the film.

use superegg_geom::glam::DVec2;
use superegg_scene::{Filter, Picture};

use crate::filter::{FilterSampler, Shares};
use crate::sampler::Sampler;
use crate::sequence::{SampleKey, sobol};

/// A place for a sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Place {
    /// In pixels from the top left corner of the picture.
    pub(crate) film_px: DVec2,
    /// Whether the filter is negative there.
    pub(crate) is_negative: bool,
}

/// The choice of a [`SampleKey`] for the place on the film.
const FILM: u32 = 4;

/// The places of a picture's samples.
#[derive(Clone, Debug)]
pub(crate) struct Placement {
    /// The same pattern in each pixel, for a number of samples that is known before ([`Sampler`]).
    pattern: Option<Vec<DVec2>>,
    filter: FilterSampler,
    /// Whether pixels have sequences of their own.
    is_own: bool,
}

impl Placement {
    /// For a picture: a fixed pattern for the box filter with a fixed number of samples, else a sequence of which any first part is well
    /// distributed, drawn from the filter.
    pub(crate) fn of(picture: &Picture) -> Self {
        let is_fixed = picture.filter == Filter::Box && picture.noise <= 0.0;
        Self {
            pattern: is_fixed.then(|| Sampler::new(picture.samples).places().collect()),
            filter: FilterSampler::new(picture.filter),
            is_own: picture.noise > 0.0,
        }
    }

    /// What samples of either sign count for.
    pub(crate) fn shares(&self) -> Shares {
        self.filter.shares
    }

    /// The place of a pixel's sample, by its index from 0.
    pub(crate) fn place(&self, (x, y): (u32, u32), index: u32) -> Place {
        let corner = DVec2::new(f64::from(x), f64::from(y));
        if let Some(within) = self.pattern.as_ref().and_then(|places| places.get(index as usize)) {
            return Place { film_px: corner + *within, is_negative: false };
        }
        let unit = if self.is_own {
            SampleKey::new((x, y), index).branch(FILM).point(0, 1)
        } else {
            sobol(index, FILM)
        };
        let (offset, is_negative) = self.filter.place(unit);
        Place { film_px: corner + 0.5 + offset, is_negative }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_box_with_a_fixed_count_keeps_its_pattern() {
        let picture = Picture { samples: 4, ..Picture::default() };
        let placement = Placement::of(&picture);
        let places: Vec<DVec2> = (0..4).map(|index| placement.place((3, 5), index).film_px).collect();
        let expected: Vec<DVec2> = Sampler::new(4).places().map(|p| p + DVec2::new(3.0, 5.0)).collect();
        assert_eq!(places, expected);
    }

    #[test]
    fn pixels_that_stop_by_themselves_have_sequences_of_their_own() {
        let placement = Placement::of(&Picture { noise: 0.01, ..Picture::default() });
        let within = |x, y| placement.place((x, y), 0).film_px - DVec2::new(f64::from(x), f64::from(y));
        assert!(within(0, 0) != within(1, 0) && within(0, 0) != within(0, 1));
        assert!(within(5, 9).cmpge(DVec2::ZERO).all() && within(5, 9).cmple(DVec2::ONE).all());
    }
}
