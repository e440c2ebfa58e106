//! The sums of samples of a tile.

use superegg_geom::glam::DVec3;
use superegg_geom::unit_vector;

use crate::camera::filter::FilterMass;
use crate::film::buffer::Film;
use crate::film::develop::Development;
use crate::film::first::FirstHit;
use crate::film::pixel::Layers;

/// The sums of samples of a tile, by pixel index.
#[derive(Debug)]
pub(crate) struct TileAccumulator {
    mass: FilterMass,
    /// The samples where the filter is positive.
    positive: SignedSums,
    /// The samples where the filter is negative; empty if it is positive everywhere.
    negative: SignedSums,
    /// Empty unless requested.
    layers: Vec<LayerSums>,
}

/// The sums to keep besides light.
#[derive(Clone, Copy, Debug)]
pub(crate) struct AccumulatorLayout {
    /// Squares, for standard errors.
    pub(crate) squares: bool,
    /// Depth, normal, albedo and instance id of first hits.
    pub(crate) layers: bool,
}

/// The sums over samples of one sign, by pixel.
#[derive(Debug, Default)]
struct SignedSums {
    sums: Vec<PixelSum>,
    /// The sums of squares of each channel; empty unless requested.
    squares: Vec<DVec3>,
}

#[derive(Clone, Copy, Debug, Default)]
struct PixelSum {
    color: DVec3,
    count: u32,
    /// The number of samples with a hit.
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

    fn add(&mut self, pixel: usize, color: DVec3, is_covered: bool) {
        let sum = &mut self.sums[pixel];
        sum.color += color;
        sum.count += 1;
        sum.covered += u32::from(is_covered);
        if let Some(squares) = self.squares.get_mut(pixel) {
            *squares += color * color;
        }
    }

    fn count(&self, pixel: usize) -> u32 {
        self.sums.get(pixel).map_or(0, |sum| sum.count)
    }

    /// The estimated variance of the mean colour and of the mean coverage. There are at least two
    /// samples.
    fn variance(&self, pixel: usize) -> (DVec3, f64) {
        let sum = &self.sums[pixel];
        let count = f64::from(sum.count);
        let (mean, covered) = (sum.color(), sum.covered());
        let squares = self.squares.get(pixel).copied().unwrap_or(DVec3::INFINITY);
        let spread = (squares / count - mean * mean).max(DVec3::ZERO);
        (spread / (count - 1.0), covered * (1.0 - covered) / (count - 1.0))
    }
}

/// The sums over samples with a hit where the filter is positive.
#[derive(Clone, Copy, Debug, Default)]
struct LayerSums {
    count: u32,
    depth: f64,
    normal: DVec3,
    albedo: DVec3,
    id: MajorityVote,
}

impl LayerSums {
    fn add(&mut self, first: Option<&FirstHit>) {
        if let Some(FirstHit { depth, normal, albedo, .. }) = first {
            self.count += 1;
            self.depth += f64::from(*depth);
            self.normal += normal.as_dvec3();
            self.albedo += albedo.as_dvec3();
        }
        self.id.add(first.map_or(0, |first| first.id));
    }

    /// The means, with the instance id of the majority.
    fn layers(&self) -> Layers {
        let id = self.id.winner;
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
    /// Without pixels.
    pub(crate) fn new(mass: FilterMass) -> Self {
        Self { mass, positive: SignedSums::default(), negative: SignedSums::default(), layers: Vec::new() }
    }

    /// Starts with `pixels` empty pixels.
    pub(crate) fn start(&mut self, pixels: usize, keeps: AccumulatorLayout) {
        self.positive.start(pixels, keeps.squares);
        self.negative.start(if self.mass.negative > 0.0 { pixels } else { 0 }, keeps.squares);
        self.layers.clear();
        self.layers.resize(if keeps.layers { pixels } else { 0 }, LayerSums::default());
    }

    /// Adds a sample of a pixel: its light, and its first hit if that is requested. `is_negative`
    /// is the sign of the filter at the sample.
    pub(crate) fn add(&mut self, pixel: usize, color: DVec3, first: Option<&FirstHit>, is_negative: bool) {
        if is_negative {
            self.negative.add(pixel, color, first.is_some());
            return;
        }
        self.positive.add(pixel, color, first.is_some());
        if let Some(layers) = self.layers.get_mut(pixel) {
            layers.add(first);
        }
    }

    /// The number of pixels.
    pub(crate) fn pixels(&self) -> usize {
        self.positive.sums.len()
    }

    /// The number of samples of a pixel.
    pub(crate) fn count(&self, pixel: usize) -> u32 {
        self.positive.count(pixel) + self.negative.count(pixel)
    }

    /// The filtered value, from the means of both signs. A sign without samples is assumed to have
    /// the mean of the other.
    #[inline]
    fn filtered<T>(&self, pixel: usize, of: impl Fn(&PixelSum) -> T) -> T
    where
        T: std::ops::Mul<f64, Output = T> + std::ops::Sub<Output = T>,
    {
        let positive = &self.positive.sums[pixel];
        match self.negative.sums.get(pixel) {
            None | Some(PixelSum { count: 0, .. }) => of(positive),
            Some(negative) if positive.count == 0 => of(negative),
            Some(negative) => of(positive) * self.mass.positive - of(negative) * self.mass.negative,
        }
    }

    /// The film of the tile, of width and height `size`. Each pixel has at least one sample.
    pub(crate) fn film(&self, size: (u32, u32), is_transparent: bool) -> Film {
        let pixels = 0..self.pixels();
        let color = |pixel| self.filtered(pixel, PixelSum::color).as_vec3().to_array();
        let alpha = |pixel| self.filtered(pixel, PixelSum::covered).clamp(0.0, 1.0) as f32;
        let alphas = if is_transparent { pixels.clone().map(alpha).collect() } else { Vec::new() };
        let samples = pixels.clone().map(|pixel| self.count(pixel)).collect();
        let layers = self.layers.iter().map(LayerSums::layers).collect();
        Film::of_parts(size, pixels.map(color).collect(), alphas, samples, layers)
    }

    /// The standard error of the encoded value of a pixel: the largest over the channels, and over
    /// alpha if the background is transparent. It is half the difference between the developed
    /// values of the mean plus and minus one standard error of linear light. Infinite for less than
    /// two samples or without squares.
    pub(crate) fn error(&self, pixel: usize, development: &Development) -> f64 {
        if self.positive.count(pixel) < 2 {
            return f64::INFINITY;
        }
        let FilterMass { positive, negative } = self.mass;
        let (mut color, mut covered) = self.positive.variance(pixel);
        if negative > 0.0 {
            let below = if self.negative.count(pixel) < 2 { &self.positive } else { &self.negative };
            let (below_color, below_covered) = below.variance(pixel);
            let (above, below) = (positive.powi(2), negative.powi(2));
            color = above * color + below * below_color;
            covered = above * covered + below * below_covered;
        }
        let (mean, deviation) = (self.filtered(pixel, PixelSum::color), color.map(f64::sqrt));
        let developed = |color: DVec3| development.value(color.as_vec3().to_array());
        let (low, high) = (developed(mean - deviation), developed(mean + deviation));
        let error = (0..3).map(|i| 0.5 * f64::from(high[i] - low[i])).fold(0.0, f64::max);
        if development.transparent { error.max(covered.sqrt()) } else { error }
    }
}

/// The majority vote of Boyer and Moore (1981): finds the value with more than half of the votes
/// without counting each value.
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

    /// One pixel without samples.
    fn one(mass: FilterMass) -> TileAccumulator {
        let mut accumulator = TileAccumulator::new(mass);
        accumulator.start(1, ALL);
        accumulator
    }

    fn pixel(accumulator: &TileAccumulator, x: u32, is_transparent: bool) -> Pixel {
        accumulator.film((accumulator.pixels() as u32, 1), is_transparent).pixel(x, 0).unwrap()
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
    fn light_is_the_same_with_and_without_layers() {
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
            for x in 0..3 {
                let (all, light) = (pixel(&all, x, true), pixel(&light, x, true));
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
        // All samples are clipped to white, so their variance does not matter.
        let mut bright = one(BOX);
        (0..100).for_each(|i| grey(&mut bright, 50.0 + f64::from(i % 2), false));
        assert_eq!(bright.error(0, &linear), 0.0);
        // Half a stop of exposure increases the error.
        let brighter = Development { exposure: 0.5, ..linear };
        assert!(accumulator.error(0, &brighter) > accumulator.error(0, &linear));
    }
}
