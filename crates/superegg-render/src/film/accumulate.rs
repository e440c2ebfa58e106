//! The sums of samples of a tile.

use superegg_geom::glam::DVec3;
use superegg_geom::unit_vector;

use crate::camera::filter::FilterMass;
use crate::film::buffer::Film;
use crate::film::develop::Development;
use crate::film::first::{FirstHit, FirstLight, SurfaceIds};
use crate::film::matte::{Coverage, Mattes};
use crate::film::pixel::{Layers, LightPasses};

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
    /// For each pixel what its samples hit, instances and objects. Empty unless requested.
    mattes: Vec<[Vec<IdCount>; 2]>,
}

/// The samples of a pixel with an id, where the filter is positive and where it is negative.
#[derive(Clone, Copy, Debug)]
struct IdCount {
    id: u32,
    positive: u32,
    negative: u32,
}

/// Samples that hit more different things in a pixel than this do not count for its mattes.
const MOST_IDS: usize = 256;

/// The sums to keep besides light.
#[derive(Clone, Copy, Debug)]
pub(crate) struct AccumulatorLayout {
    /// Squares, for standard errors.
    pub(crate) squares: bool,
    /// Depth, normal, albedo and ids of first hits.
    pub(crate) layers: bool,
    /// The light of first surfaces apart from the rest.
    pub(crate) passes: bool,
    /// The things that cover each pixel.
    pub(crate) mattes: bool,
}

/// The sums over samples of one sign, by pixel.
#[derive(Debug, Default)]
struct SignedSums {
    sums: Vec<PixelSum>,
    /// The sums of squares of each channel; empty unless requested.
    squares: Vec<DVec3>,
    /// The sums of the light of first surfaces; empty unless requested.
    passes: Vec<FirstLight>,
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
    fn start(&mut self, pixels: usize, keeps: AccumulatorLayout) {
        let Self { sums, squares, passes } = self;
        sums.clear();
        sums.resize(pixels, PixelSum::default());
        squares.clear();
        squares.resize(if keeps.squares { pixels } else { 0 }, DVec3::ZERO);
        passes.clear();
        passes.resize(if keeps.passes { pixels } else { 0 }, FirstLight::default());
    }

    fn add_pass(&mut self, pixel: usize, light: &FirstLight) {
        if let Some(sum) = self.passes.get_mut(pixel) {
            sum.emission += light.emission;
            sum.direct += light.direct;
        }
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
    /// The hash and the number of the instance.
    instance: MajorityVote<[u32; 2]>,
    object: MajorityVote<u32>,
}

impl LayerSums {
    fn add(&mut self, first: Option<&FirstHit>) {
        if let Some(FirstHit { depth, normal, albedo, .. }) = first {
            self.count += 1;
            self.depth += f64::from(*depth);
            self.normal += normal.as_dvec3();
            self.albedo += albedo.as_dvec3();
        }
        let SurfaceIds { id, instance, object, .. } = first.map(|first| first.ids).unwrap_or_default();
        self.instance.add([id, instance]);
        self.object.add(object);
    }

    /// The means, with the instance id of the majority.
    fn layers(&self) -> Layers {
        let ([id, instance], object) = (self.instance.winner, self.object.winner);
        if self.count == 0 {
            return Layers::EMPTY;
        }
        let count = f64::from(self.count);
        Layers {
            depth: (self.depth / count) as f32,
            normal: unit_vector(self.normal).unwrap_or(DVec3::ZERO).as_vec3().to_array(),
            albedo: (self.albedo / count).as_vec3().to_array(),
            id,
            instance,
            object,
        }
    }
}

impl TileAccumulator {
    /// Without pixels.
    pub(crate) fn new(mass: FilterMass) -> Self {
        Self {
            mass,
            positive: SignedSums::default(),
            negative: SignedSums::default(),
            layers: Vec::new(),
            mattes: Vec::new(),
        }
    }

    /// Starts with `pixels` empty pixels.
    pub(crate) fn start(&mut self, pixels: usize, keeps: AccumulatorLayout) {
        self.positive.start(pixels, keeps);
        self.negative.start(if self.mass.negative > 0.0 { pixels } else { 0 }, keeps);
        self.layers.clear();
        self.layers.resize(if keeps.layers { pixels } else { 0 }, LayerSums::default());
        self.mattes.resize_with(if keeps.mattes { pixels } else { 0 }, Default::default);
        self.mattes.as_flattened_mut().iter_mut().for_each(Vec::clear);
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

    /// Adds the light of first surfaces of a sample.
    pub(crate) fn add_pass(&mut self, pixel: usize, light: &FirstLight, is_negative: bool) {
        let sums = if is_negative { &mut self.negative } else { &mut self.positive };
        sums.add_pass(pixel, light);
    }

    /// Adds what a sample hits to the mattes.
    pub(crate) fn add_ids(&mut self, pixel: usize, ids: &SurfaceIds, is_negative: bool) {
        let Some(levels) = self.mattes.get_mut(pixel) else { return };
        for (counts, id) in levels.iter_mut().zip(ids.names) {
            let found = counts.iter().position(|count| count.id == id);
            let index = found.unwrap_or(counts.len());
            if found.is_none() {
                if counts.len() == MOST_IDS {
                    continue;
                }
                counts.push(IdCount { id, positive: 0, negative: 0 });
            }
            let count = &mut counts[index];
            *(if is_negative { &mut count.negative } else { &mut count.positive }) += 1;
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

    /// The weights of the positive and the negative samples of a pixel in its filtered value.
    fn sample_weights(&self, pixel: usize) -> [f64; 2] {
        let positive = f64::from(self.positive.sums[pixel].count);
        let negative = self.negative.sums.get(pixel).map_or(0.0, |sum| f64::from(sum.count));
        if negative == 0.0 {
            [1.0 / positive, 0.0]
        } else if positive == 0.0 {
            [0.0, 1.0 / negative]
        } else {
            [self.mass.positive / positive, -self.mass.negative / negative]
        }
    }

    /// The light of a pixel by the number of surfaces on its way.
    fn passes(&self, pixel: usize) -> LightPasses {
        let [above, below] = self.sample_weights(pixel);
        let sum = |of: &dyn Fn(&FirstLight) -> DVec3| {
            let positive = of(&self.positive.passes[pixel]) * above;
            self.negative.passes.get(pixel).map_or(positive, |negative| positive + of(negative) * below)
        };
        let (emission, direct) = (sum(&|light| light.emission), sum(&|light| light.direct));
        let indirect = self.filtered(pixel, PixelSum::color) - emission - direct;
        let [emission, direct, indirect] =
            [emission, direct, indirect].map(|light| light.as_vec3().to_array());
        LightPasses { emission, direct, indirect }
    }

    /// The things that cover a pixel, the largest share first. Equal shares are ordered by their ids.
    fn coverage(&self, pixel: usize, counts: &[IdCount]) -> Vec<Coverage> {
        let [above, below] = self.sample_weights(pixel);
        let share = |count: &IdCount| f64::from(count.positive) * above + f64::from(count.negative) * below;
        let all = counts.iter().map(|count| Coverage { id: count.id, share: share(count).min(1.0) as f32 });
        let mut all: Vec<Coverage> = all.filter(|coverage| coverage.share > 0.0).collect();
        all.sort_unstable_by(|a, b| b.share.total_cmp(&a.share).then(a.id.cmp(&b.id)));
        all
    }

    /// The mattes of the tile, without names.
    fn mattes(&self) -> Mattes {
        let mut mattes = Mattes::new(self.mattes.len());
        for (pixel, levels) in self.mattes.iter().enumerate() {
            let [instances, objects] = levels.each_ref().map(|counts| self.coverage(pixel, counts));
            mattes.set(pixel, [&instances, &objects]);
        }
        mattes
    }

    /// The film of the tile, of width and height `size`. Each pixel has at least one sample.
    pub(crate) fn film(&self, size: (u32, u32), is_transparent: bool) -> Film {
        let pixels = 0..self.pixels();
        let color = |pixel| self.filtered(pixel, PixelSum::color).as_vec3().to_array();
        let alpha = |pixel| self.filtered(pixel, PixelSum::covered).clamp(0.0, 1.0) as f32;
        let alphas = if is_transparent { pixels.clone().map(alpha).collect() } else { Vec::new() };
        let samples = if self.negative.sums.is_empty() {
            self.positive.sums.iter().map(|sum| sum.count).collect()
        } else {
            pixels.clone().map(|pixel| self.count(pixel)).collect()
        };
        let layers = self.layers.iter().map(LayerSums::layers).collect();
        let passes = (0..self.positive.passes.len()).map(|pixel| self.passes(pixel)).collect();
        Film::of_parts(size, pixels.map(color).collect(), alphas, samples, layers)
            .with_passes(passes)
            .with_mattes(self.mattes())
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
struct MajorityVote<T> {
    winner: T,
    lead: u32,
}

impl<T: PartialEq> MajorityVote<T> {
    fn add(&mut self, id: T) {
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
    use crate::film::matte::MatteLevel;
    use crate::film::pixel::Pixel;

    const BOX: FilterMass = FilterMass { positive: 1.0, negative: 0.0 };

    const ALL: AccumulatorLayout =
        AccumulatorLayout { squares: true, layers: true, passes: true, mattes: true };

    const IDS: SurfaceIds = SurfaceIds { id: 9, instance: 5, object: 3, names: [21, 22] };

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
        let first = FirstHit { depth: 3.0, normal: Vec3::Z, albedo: Vec3::X, ids: IDS };
        let mut accumulator = one(BOX);
        grey(&mut accumulator, 1.0, false);
        assert_eq!(pixel(&accumulator, 0, false).depth, f32::INFINITY);
        accumulator.add(0, DVec3::ZERO, Some(&first), false);
        accumulator.add(0, DVec3::ZERO, Some(&FirstHit { depth: 5.0, ..first }), false);
        let two = pixel(&accumulator, 0, false);
        assert_eq!((two.depth, two.normal, two.albedo), (4.0, [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]));
        assert_eq!((two.color, two.id, two.samples), ([1.0 / 3.0; 3], 9, 3));
        assert_eq!((two.instance, two.object), (5, 3));
        assert_eq!((two.alpha, pixel(&accumulator, 0, true).alpha), (1.0, 2.0 / 3.0));
    }

    #[test]
    fn light_is_the_same_with_and_without_layers() {
        let first = FirstHit { depth: 3.0, normal: Vec3::Z, albedo: Vec3::X, ids: IDS };
        for mass in [BOX, FilterSampler::new(Filter::Mitchell).mass] {
            let mut all = TileAccumulator::new(mass);
            let mut light = TileAccumulator::new(mass);
            all.start(3, ALL);
            light.start(3, AccumulatorLayout { squares: false, layers: false, passes: false, mattes: false });
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
    fn shares_of_mattes_are_those_of_samples_and_add_up_to_the_alpha() {
        for mass in [BOX, FilterSampler::new(Filter::Mitchell).mass] {
            let mut accumulator = one(mass);
            let mut expected = [[0.0f64; 2]; 3];
            for i in 0..72u32 {
                let is_negative = mass.negative > 0.0 && i % 4 == 0;
                // One of six samples hits nothing, two hit one thing and three another.
                let thing = [0, 1, 1, 2, 2, 2][i as usize / 4 % 6];
                expected[thing][usize::from(is_negative)] += 1.0;
                let ids = SurfaceIds { names: [thing as u32, 7], ..IDS };
                let first = FirstHit { depth: 1.0, normal: Vec3::Z, albedo: Vec3::X, ids };
                let first = (thing > 0).then_some(&first);
                accumulator.add(0, DVec3::ONE, first, is_negative);
                if let Some(first) = first {
                    accumulator.add_ids(0, &first.ids, is_negative);
                }
            }
            let film = accumulator.film((1, 1), true);
            let shares = |level| film.matte(level, 0, 0).to_vec();
            let instances = shares(MatteLevel::Instance);
            assert_eq!(instances.iter().map(|thing| thing.id).collect::<Vec<u32>>(), [2, 1]);
            let share = |[positive, negative]: [f64; 2]| {
                let (all, below) = if mass.negative > 0.0 { (54.0, 18.0) } else { (72.0, 1.0) };
                mass.positive * positive / all - mass.negative * negative / below
            };
            assert!((f64::from(instances[0].share) - share(expected[2])).abs() < 1e-6);
            let alpha = film.pixel(0, 0).unwrap().alpha;
            let sum: f32 = instances.iter().map(|thing| thing.share).sum();
            assert!((sum - alpha).abs() < 1e-6 && (shares(MatteLevel::Object)[0].share - alpha).abs() < 1e-6);
        }
    }

    #[test]
    fn passes_add_up_to_the_colour() {
        for mass in [BOX, FilterSampler::new(Filter::Mitchell).mass] {
            let mut accumulator = one(mass);
            for i in 0..20u32 {
                let is_negative = mass.negative > 0.0 && i % 5 == 0;
                let part = |k: u32| DVec3::splat(f64::from(i * k % 7));
                let light = FirstLight { emission: part(2), direct: part(3) };
                accumulator.add(0, part(2) + part(3) + part(5), None, is_negative);
                accumulator.add_pass(0, &light, is_negative);
            }
            let film = accumulator.film((1, 1), false);
            let LightPasses { emission, direct, indirect } = film.passes(0, 0).unwrap();
            let color = film.pixel(0, 0).unwrap().color;
            for i in 0..3 {
                assert!((emission[i] + direct[i] + indirect[i] - color[i]).abs() < 1e-5);
            }
            assert!(emission != direct && direct != indirect);
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
