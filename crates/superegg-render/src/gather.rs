//! The samples of a pixel, as they come together to its values.

use superegg_geom::glam::DVec3;
use superegg_geom::unit_vector;

use crate::develop::Development;
use crate::film::Pixel;
use crate::filter::Shares;
use crate::tile::{FirstSurface, Sighting};

/// What the samples of a pixel come to so far.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Gathered {
    /// Those at places where the filter is positive, and where it is negative.
    positive: Part,
    negative: Part,
    surfaces: Surfaces,
    most_seen: Vote,
}

/// Sums over samples.
#[derive(Clone, Copy, Debug, Default)]
struct Part {
    count: u32,
    color: DVec3,
    /// Of the squares of each channel.
    squares: DVec3,
    /// How many meet a surface.
    met: u32,
}

impl Part {
    fn color(&self) -> DVec3 {
        self.color / f64::from(self.count)
    }

    fn met(&self) -> f64 {
        f64::from(self.met) / f64::from(self.count)
    }

    /// The variance of the mean colour and of the mean coverage, estimated from the samples; at least two.
    fn variance(&self) -> (DVec3, f64) {
        let count = f64::from(self.count);
        let (mean, met) = (self.color(), self.met());
        let spread = (self.squares / count - mean * mean).max(DVec3::ZERO);
        (spread / (count - 1.0), met * (1.0 - met) / (count - 1.0))
    }
}

/// Sums over the samples that meet a surface where the filter is positive.
#[derive(Clone, Copy, Debug, Default)]
struct Surfaces {
    count: u32,
    depth: f64,
    normal: DVec3,
    albedo: DVec3,
}

impl Gathered {
    /// Takes a sample, from a place where the filter is positive or negative.
    pub(crate) fn add(&mut self, seen: &Sighting, is_negative: bool) {
        let part = if is_negative { &mut self.negative } else { &mut self.positive };
        part.count += 1;
        part.color += seen.color;
        part.squares += seen.color * seen.color;
        part.met += u32::from(seen.first.is_some());
        if is_negative {
            return;
        }
        if let Some(FirstSurface { depth, normal, albedo, .. }) = seen.first {
            self.surfaces.count += 1;
            self.surfaces.depth += f64::from(depth);
            self.surfaces.normal += normal.as_dvec3();
            self.surfaces.albedo += albedo.as_dvec3();
        }
        self.most_seen.add(seen.first.map_or(0, |first| first.id));
    }

    /// How many samples there are.
    pub(crate) fn count(&self) -> u32 {
        self.positive.count + self.negative.count
    }

    /// The filter's value, from the means of either sign. Where there are samples of one sign only, those of the other are taken for the same.
    fn filtered<T>(&self, shares: Shares, of: impl Fn(&Part) -> T) -> T
    where
        T: std::ops::Mul<f64, Output = T> + std::ops::Sub<Output = T>,
    {
        match (self.positive.count, self.negative.count) {
            (_, 0) => of(&self.positive),
            (0, _) => of(&self.negative),
            _ => of(&self.positive) * shares.positive - of(&self.negative) * shares.negative,
        }
    }

    /// The pixel that they make; at least one sample.
    pub(crate) fn pixel(&self, shares: Shares, is_transparent: bool) -> Pixel {
        let count = f64::from(self.surfaces.count);
        let is_met = self.surfaces.count > 0;
        let mean = |sum: DVec3| if is_met { (sum / count).as_vec3().to_array() } else { [0.0; 3] };
        let alpha = if is_transparent { self.filtered(shares, Part::met).clamp(0.0, 1.0) } else { 1.0 };
        Pixel {
            color: self.filtered(shares, Part::color).as_vec3().to_array(),
            alpha: alpha as f32,
            depth: if is_met { (self.surfaces.depth / count) as f32 } else { f32::INFINITY },
            normal: unit_vector(self.surfaces.normal).unwrap_or(DVec3::ZERO).as_vec3().to_array(),
            albedo: mean(self.surfaces.albedo),
            id: self.most_seen.winner,
            samples: self.count(),
        }
    }

    /// The standard error of the pixel's value on the screen, the largest of its channels (alpha among them where the background is transparent):
    /// half the way from a standard error of linear light below the mean to one above it, developed. Infinite for less than two samples.
    pub(crate) fn error(&self, shares: Shares, development: &Development) -> f64 {
        if self.positive.count < 2 {
            return f64::INFINITY;
        }
        let (mut color, mut met) = self.positive.variance();
        if shares.negative > 0.0 {
            let below = if self.negative.count < 2 { &self.positive } else { &self.negative };
            let (below_color, below_met) = below.variance();
            let (above, below) = (shares.positive.powi(2), shares.negative.powi(2));
            color = above * color + below * below_color;
            met = above * met + below * below_met;
        }
        let (mean, deviation) = (self.filtered(shares, Part::color), color.map(f64::sqrt));
        let developed = |color: DVec3| development.value(color.as_vec3().to_array());
        let (low, high) = (developed(mean - deviation), developed(mean + deviation));
        let error = (0..3).map(|i| 0.5 * f64::from(high[i] - low[i])).fold(0.0, f64::max);
        if development.transparent { error.max(met.sqrt()) } else { error }
    }
}

/// The vote of Boyer and Moore (1981): what has more than half of the votes wins, found without counting each.
#[derive(Clone, Copy, Debug, Default)]
struct Vote {
    winner: u32,
    lead: u32,
}

impl Vote {
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
    use crate::filter::FilterSampler;

    const BOX: Shares = Shares { positive: 1.0, negative: 0.0 };

    fn grey(value: f64) -> Sighting {
        Sighting { color: DVec3::splat(value), first: None }
    }

    #[test]
    fn more_than_half_of_the_votes_win_in_any_order() {
        for votes in [[7, 7, 7, 0, 3], [0, 7, 3, 7, 7], [7, 0, 7, 3, 7]] {
            let mut vote = Vote::default();
            votes.into_iter().for_each(|id| vote.add(id));
            assert_eq!(vote.winner, 7);
        }
    }

    #[test]
    fn surfaces_count_alone_where_some_samples_meet_nothing() {
        let first = FirstSurface { depth: 3.0, normal: Vec3::Z, albedo: Vec3::X, id: 9 };
        let mut gathered = Gathered::default();
        gathered.add(&Sighting { color: DVec3::ONE, first: None }, false);
        assert_eq!(gathered.pixel(BOX, false).depth, f32::INFINITY);
        gathered.add(&Sighting { color: DVec3::ZERO, first: Some(first) }, false);
        let other = FirstSurface { depth: 5.0, ..first };
        gathered.add(&Sighting { color: DVec3::ZERO, first: Some(other) }, false);
        let pixel = gathered.pixel(BOX, false);
        assert_eq!((pixel.depth, pixel.normal, pixel.albedo), (4.0, [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]));
        assert_eq!((pixel.color, pixel.id, pixel.samples), ([1.0 / 3.0; 3], 9, 3));
        assert_eq!((pixel.alpha, gathered.pixel(BOX, true).alpha), (1.0, 2.0 / 3.0));
    }

    #[test]
    fn white_stays_white_whatever_signs_the_samples_have() {
        let shares = FilterSampler::new(Filter::Mitchell).shares;
        for signs in 0..64u32 {
            for count in 1..=6 {
                let mut gathered = Gathered::default();
                (0..count).for_each(|i| gathered.add(&grey(1.0), signs >> i & 1 == 1));
                let [r, g, b] = gathered.pixel(shares, false).color;
                assert!([r, g, b].into_iter().all(|value| (value - 1.0).abs() < 1e-6), "{r}");
            }
        }
    }

    #[test]
    fn the_error_is_that_of_the_mean_on_the_screen() {
        let linear = Picture { encoding: superegg_scene::Encoding::Linear, ..Picture::default() };
        let linear = Development::of(&linear);
        let mut gathered = Gathered::default();
        assert_eq!(gathered.error(BOX, &linear), f64::INFINITY);
        (0..100).for_each(|i| gathered.add(&grey(f64::from(i % 2)), false));
        // The deviation of a coin is 1/2.
        assert!((gathered.error(BOX, &linear) - 0.5 / 99f64.sqrt()).abs() < 1e-6);
        // What is white beyond doubt has no error left, however it flickers.
        let mut bright = Gathered::default();
        (0..100).for_each(|i| bright.add(&grey(50.0 + f64::from(i % 2)), false));
        assert_eq!(bright.error(BOX, &linear), 0.0);
        // Half a stop more is more error.
        let brighter = Development { exposure: 0.5, ..linear };
        assert!(gathered.error(BOX, &brighter) > gathered.error(BOX, &linear));
    }
}
