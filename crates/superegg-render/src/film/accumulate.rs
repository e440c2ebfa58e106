//! The samples of a tile's pixels, as they come together to their values.

use superegg_geom::glam::DVec3;
use superegg_geom::unit_vector;

use crate::camera::filter::FilterMass;
use crate::film::buffer::Film;
use crate::film::develop::Development;
use crate::film::first::FirstHit;
use crate::film::pixel::Layers;

/// What the samples of a tile's pixels come to so far, each pixel by its place.
#[derive(Debug)]
pub(crate) struct TileAccumulator {
    mass: FilterMass,
    /// Samples at places where the filter is positive, and where it is negative; the latter only of filters that are so anywhere.
    positive: SignedSums,
    negative: SignedSums,
    /// Only where they are kept.
    layers: Vec<LayerSums>,
}

/// What is gathered beside light.
#[derive(Clone, Copy, Debug)]
pub(crate) struct AccumulatorLayout {
    /// What errors are told from.
    pub(crate) squares: bool,
    /// What first surfaces tell.
    pub(crate) layers: bool,
}

/// Sums over samples of one sign, by pixels.
#[derive(Debug, Default)]
struct SignedSums {
    sums: Vec<PixelSum>,
    /// Of the squares of each channel; none where they are not kept.
    squares: Vec<DVec3>,
}

#[derive(Clone, Copy, Debug, Default)]
struct PixelSum {
    color: DVec3,
    count: u32,
    /// How many meet a surface.
    covered: u32,
}

impl PixelSum {
    fn color(&self) -> DVec3 {
        self.color / f64::from(self.count)
    }

    fn covered(&self) -> f64 {
        f64::from(self.covered) / f64::from(self.count)
    }
}

impl SignedSums {
    fn start(&mut self, pixels: usize, keeps_squares: bool) {
        self.sums.clear();
        self.sums.resize(pixels, PixelSum::default());
        self.squares.clear();
        self.squares.resize(if keeps_squares { pixels } else { 0 }, DVec3::ZERO);
    }

    fn add(&mut self, place: usize, color: DVec3, is_covered: bool) {
        let sum = &mut self.sums[place];
        sum.color += color;
        sum.count += 1;
        sum.covered += u32::from(is_covered);
        if let Some(squares) = self.squares.get_mut(place) {
            *squares += color * color;
        }
    }

    fn count(&self, place: usize) -> u32 {
        self.sums.get(place).map_or(0, |sum| sum.count)
    }

    /// The variance of the mean colour and of the mean coverage, estimated from the samples; at least two.
    fn variance(&self, place: usize) -> (DVec3, f64) {
        let sum = &self.sums[place];
        let count = f64::from(sum.count);
        let (mean, covered) = (sum.color(), sum.covered());
        let squares = self.squares.get(place).copied().unwrap_or(DVec3::INFINITY);
        let spread = (squares / count - mean * mean).max(DVec3::ZERO);
        (spread / (count - 1.0), covered * (1.0 - covered) / (count - 1.0))
    }
}

/// Sums over the samples that meet a surface where the filter is positive.
#[derive(Clone, Copy, Debug, Default)]
struct LayerSums {
    count: u32,
    depth: f64,
    normal: DVec3,
    albedo: DVec3,
    most_seen: MajorityVote,
}

impl LayerSums {
    fn add(&mut self, first: Option<&FirstHit>) {
        if let Some(FirstHit { depth, normal, albedo, .. }) = first {
            self.count += 1;
            self.depth += f64::from(*depth);
            self.normal += normal.as_dvec3();
            self.albedo += albedo.as_dvec3();
        }
        self.most_seen.add(first.map_or(0, |first| first.id));
    }

    /// What they come to.
    fn layers(&self) -> Layers {
        let id = self.most_seen.winner;
        if self.count == 0 {
            return Layers { id, ..Layers::EMPTY };
        }
        let count = f64::from(self.count);
        Layers {
            depth: (self.depth / count) as f32,
            normal: unit_vector(self.normal).unwrap_or(DVec3::ZERO).as_vec3().to_array(),
            albedo: (self.albedo / count).as_vec3().to_array(),
            id,
        }
    }
}

impl TileAccumulator {
    /// Of no pixels yet.
    pub(crate) fn new(mass: FilterMass) -> Self {
        Self { mass, positive: SignedSums::default(), negative: SignedSums::default(), layers: Vec::new() }
    }

    /// Begins with so many pixels.
    pub(crate) fn start(&mut self, pixels: usize, keeps: AccumulatorLayout) {
        self.positive.start(pixels, keeps.squares);
        self.negative.start(if self.mass.negative > 0.0 { pixels } else { 0 }, keeps.squares);
        self.layers.clear();
        self.layers.resize(if keeps.layers { pixels } else { 0 }, LayerSums::default());
    }

    /// Takes a sample of a pixel, from a place where the filter is positive or negative: its light, and the surface that it meets first as far as that
    /// was asked for.
    pub(crate) fn add(&mut self, place: usize, color: DVec3, first: Option<&FirstHit>, is_negative: bool) {
        if is_negative {
            self.negative.add(place, color, first.is_some());
            return;
        }
        self.positive.add(place, color, first.is_some());
        if let Some(layers) = self.layers.get_mut(place) {
            layers.add(first);
        }
    }

    /// How many pixels there are.
    pub(crate) fn pixels(&self) -> usize {
        self.positive.sums.len()
    }

    /// How many samples a pixel has.
    pub(crate) fn count(&self, place: usize) -> u32 {
        self.positive.count(place) + self.negative.count(place)
    }

    /// The filter's value, from the means of either sign. Where there are samples of one sign only, those of the other are taken for the same.
    #[inline]
    fn filtered<T>(&self, place: usize, of: impl Fn(&PixelSum) -> T) -> T
    where
        T: std::ops::Mul<f64, Output = T> + std::ops::Sub<Output = T>,
    {
        let positive = &self.positive.sums[place];
        match self.negative.sums.get(place) {
            None | Some(PixelSum { count: 0, .. }) => of(positive),
            Some(negative) if positive.count == 0 => of(negative),
            Some(negative) => of(positive) * self.mass.positive - of(negative) * self.mass.negative,
        }
    }

    /// The tile that they make, of so many pixels across and down; each has at least one sample.
    pub(crate) fn film(&self, size: (u32, u32), is_transparent: bool) -> Film {
        let places = 0..self.pixels();
        let color = |place| self.filtered(place, PixelSum::color).as_vec3().to_array();
        let alpha = |place| self.filtered(place, PixelSum::covered).clamp(0.0, 1.0) as f32;
        let alphas = if is_transparent { places.clone().map(alpha).collect() } else { Vec::new() };
        let samples = places.clone().map(|place| self.count(place)).collect();
        let layers = self.layers.iter().map(LayerSums::layers).collect();
        Film::of_parts(size, places.map(color).collect(), alphas, samples, layers)
    }

    /// The standard error of a pixel's value on the screen, the largest of its channels (alpha among them where the background is transparent):
    /// half the way from a standard error of linear light below the mean to one above it, developed. Infinite for less than two samples, or where no squares
    /// are kept.
    pub(crate) fn error(&self, place: usize, development: &Development) -> f64 {
        if self.positive.count(place) < 2 {
            return f64::INFINITY;
        }
        let FilterMass { positive, negative } = self.mass;
        let (mut color, mut covered) = self.positive.variance(place);
        if negative > 0.0 {
            let below = if self.negative.count(place) < 2 { &self.positive } else { &self.negative };
            let (below_color, below_met) = below.variance(place);
            let (above, below) = (positive.powi(2), negative.powi(2));
            color = above * color + below * below_color;
            covered = above * covered + below * below_met;
        }
        let (mean, deviation) = (self.filtered(place, PixelSum::color), color.map(f64::sqrt));
        let developed = |color: DVec3| development.value(color.as_vec3().to_array());
        let (low, high) = (developed(mean - deviation), developed(mean + deviation));
        let error = (0..3).map(|i| 0.5 * f64::from(high[i] - low[i])).fold(0.0, f64::max);
        if development.transparent { error.max(covered.sqrt()) } else { error }
    }
}

/// The vote of Boyer and Moore (1981): what has more than half of the votes wins, found without counting each.
#[derive(Clone, Copy, Debug, Default)]
struct MajorityVote {
    winner: u32,
    lead: u32,
}

impl MajorityVote {
    fn add(&mut self, id: u32) {
        if self.lead == 0 {
            *self = Self { winner: id, lead: 1 };
        } else if self.winner == id {
            self.lead += 1;
        } else {
            self.lead -= 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use superegg_geom::glam::Vec3;
    use superegg_scene::{Filter, Picture};

    use super::*;
    use crate::camera::filter::FilterSampler;
    use crate::film::pixel::Pixel;

    const BOX: FilterMass = FilterMass { positive: 1.0, negative: 0.0 };

    const ALL: AccumulatorLayout = AccumulatorLayout { squares: true, layers: true };

    /// One pixel, nothing gathered.
    fn one(mass: FilterMass) -> TileAccumulator {
        let mut accumulator = TileAccumulator::new(mass);
        accumulator.start(1, ALL);
        accumulator
    }

    fn pixel(accumulator: &TileAccumulator, place: u32, is_transparent: bool) -> Pixel {
        accumulator.film((accumulator.pixels() as u32, 1), is_transparent).pixel(place, 0).unwrap()
    }

    fn grey(accumulator: &mut TileAccumulator, value: f64, is_negative: bool) {
        accumulator.add(0, DVec3::splat(value), None, is_negative);
    }

    #[test]
    fn more_than_half_of_the_votes_win_in_any_order() {
        for votes in [[7, 7, 7, 0, 3], [0, 7, 3, 7, 7], [7, 0, 7, 3, 7]] {
            let mut vote = MajorityVote::default();
            votes.into_iter().for_each(|id| vote.add(id));
            assert_eq!(vote.winner, 7);
        }
    }

    #[test]
    fn surfaces_count_alone_where_some_samples_meet_nothing() {
        let first = FirstHit { depth: 3.0, normal: Vec3::Z, albedo: Vec3::X, id: 9 };
        let mut accumulator = one(BOX);
        grey(&mut accumulator, 1.0, false);
        assert_eq!(pixel(&accumulator, 0, false).depth, f32::INFINITY);
        accumulator.add(0, DVec3::ZERO, Some(&first), false);
        accumulator.add(0, DVec3::ZERO, Some(&FirstHit { depth: 5.0, ..first }), false);
        let two = pixel(&accumulator, 0, false);
        assert_eq!((two.depth, two.normal, two.albedo), (4.0, [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]));
        assert_eq!((two.color, two.id, two.samples), ([1.0 / 3.0; 3], 9, 3));
        assert_eq!((two.alpha, pixel(&accumulator, 0, true).alpha), (1.0, 2.0 / 3.0));
    }

    #[test]
    fn pixels_know_of_their_light_alone_what_they_know_with_layers() {
        let first = FirstHit { depth: 3.0, normal: Vec3::Z, albedo: Vec3::X, id: 9 };
        for mass in [BOX, FilterSampler::new(Filter::Mitchell).mass] {
            let mut all = TileAccumulator::new(mass);
            let mut light = TileAccumulator::new(mass);
            all.start(3, ALL);
            light.start(3, AccumulatorLayout { squares: false, layers: false });
            for accumulator in [&mut all, &mut light] {
                for i in 0..30u32 {
                    let is_negative = mass.negative > 0.0 && i % 5 == 0;
                    accumulator.add(i as usize % 3, DVec3::splat(i.into()), Some(&first), is_negative);
                }
            }
            for place in 0..3 {
                let (all, light) = (pixel(&all, place, true), pixel(&light, place, true));
                let expected = Pixel { color: all.color, alpha: all.alpha, samples: 10, ..Pixel::EMPTY };
                assert_eq!(light, expected);
                assert!(all.depth == 3.0 && all.id == 9);
            }
        }
    }

    #[test]
    fn white_stays_white_whatever_signs_the_samples_have() {
        let mass = FilterSampler::new(Filter::Mitchell).mass;
        for signs in 0..64u32 {
            for count in 1..=6 {
                let mut accumulator = one(mass);
                (0..count).for_each(|i| grey(&mut accumulator, 1.0, signs >> i & 1 == 1));
                let [r, g, b] = pixel(&accumulator, 0, false).color;
                assert!([r, g, b].into_iter().all(|value| (value - 1.0).abs() < 1e-6), "{r}");
            }
        }
    }

    #[test]
    fn the_error_is_that_of_the_mean_on_the_screen() {
        let linear = Picture { encoding: superegg_scene::Encoding::Linear, ..Picture::default() };
        let linear = Development::of(&linear);
        let mut accumulator = one(BOX);
        assert_eq!(accumulator.error(0, &linear), f64::INFINITY);
        (0..100).for_each(|i| grey(&mut accumulator, f64::from(i % 2), false));
        // The deviation of a coin is 1/2.
        assert!((accumulator.error(0, &linear) - 0.5 / 99f64.sqrt()).abs() < 1e-6);
        // What is white beyond doubt has no error left, however it flickers.
        let mut bright = one(BOX);
        (0..100).for_each(|i| grey(&mut bright, 50.0 + f64::from(i % 2), false));
        assert_eq!(bright.error(0, &linear), 0.0);
        // Half a stop more is more error.
        let brighter = Development { exposure: 0.5, ..linear };
        assert!(accumulator.error(0, &brighter) > accumulator.error(0, &linear));
    }
}
