//! Reconstruction filters by importance sampling (Ernst, Stamminger and Greiner, "Filter Importance
//! Sampling", 2006).
//!
//! The density of sample positions is proportional to the filter, and a sample adds to its own
//! pixel only. So tiles are independent of their neighbours, and the division into tiles does not
//! change a picture.
//!
//! Where the filter is negative, the density is its magnitude and samples are subtracted. The value
//! of a pixel combines the means of positive and negative samples by their known masses
//! ([`FilterMass`]): white stays white for any number of samples, and no divisor is near 0.

use superegg_geom::glam::DVec2;
use superegg_scene::Filter;

/// The number of table cells over the width of a filter. The zeros of the Mitchell filter are at
/// borders of cells.
const CELLS: usize = 1024;

/// The weights of the mean of positive and of negative samples: the integrals of the positive part
/// of the filter and of the magnitude of its negative part. Their difference is 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct FilterMass {
    pub(crate) positive: f64,
    pub(crate) negative: f64,
}

/// A filter with its table for importance sampling.
#[derive(Clone, Debug)]
pub(crate) struct FilterSampler {
    /// Half of the filter's width, in pixels.
    radius: f64,
    /// The cumulative distribution of the magnitude along one axis, at the borders of cells.
    cdf: Vec<f64>,
    pub(crate) mass: FilterMass,
    filter: Filter,
}

impl FilterSampler {
    pub(crate) fn new(filter: Filter) -> Self {
        let radius = radius(filter);
        let width = 2.0 * radius / CELLS as f64;
        // Simpson's rule in each cell.
        let integral = |cell: usize| {
            let left = cell as f64 * width - radius;
            let at = |x: f64| along_axis(filter, x);
            (at(left) + 4.0 * at(left + 0.5 * width) + at(left + width)) * width / 6.0
        };
        let cells: Vec<f64> = (0..CELLS).map(integral).collect();
        let magnitude: f64 = cells.iter().map(|cell| cell.abs()).sum();
        let mut cdf = vec![0.0];
        let mut sum = 0.0;
        for cell in &cells {
            sum += cell.abs() / magnitude;
            cdf.push(sum);
        }
        let minus = cells.iter().filter(|cell| **cell < 0.0).map(|cell| -cell).sum::<f64>() / magnitude;
        let plus = 1.0 - minus;
        // The filter is the product of both axes.
        let (positive, negative) = (plus * plus + minus * minus, 2.0 * plus * minus);
        let total = positive - negative;
        let mass = FilterMass { positive: positive / total, negative: negative / total };
        Self { radius, cdf, mass, filter }
    }

    /// Maps a uniform point of the unit square to a position with the density of the filter's
    /// magnitude, in pixels from the top left corner of the pixel. Also returns whether the filter
    /// is negative there.
    pub(crate) fn sample(&self, unit: DVec2) -> (DVec2, bool) {
        if self.filter == Filter::Box {
            return (unit, false);
        }
        let offset = DVec2::new(self.along(unit.x), self.along(unit.y));
        let is_negative = |x: f64| along_axis(self.filter, x) < 0.0;
        (offset + 0.5, is_negative(offset.x) != is_negative(offset.y))
    }

    /// Inverts the cumulative distribution along one axis.
    fn along(&self, unit: f64) -> f64 {
        let cell = self.cdf.partition_point(|&sum| sum <= unit).clamp(1, CELLS) - 1;
        let (left, right) = (self.cdf[cell], self.cdf[cell + 1]);
        let within = if right > left { ((unit - left) / (right - left)).clamp(0.0, 1.0) } else { 0.5 };
        (cell as f64 + within) * 2.0 * self.radius / CELLS as f64 - self.radius
    }
}

fn radius(filter: Filter) -> f64 {
    match filter {
        Filter::Box => 0.5,
        Filter::Tent => 1.0,
        Filter::Gaussian | Filter::Blackman | Filter::Mitchell => 2.0,
    }
}

/// The filter along one axis, up to a constant factor. The filter of the picture is the product of
/// both axes.
fn along_axis(filter: Filter, x: f64) -> f64 {
    let x = x.abs();
    if x > radius(filter) {
        return 0.0;
    }
    match filter {
        Filter::Box => 1.0,
        Filter::Tent => 1.0 - x,
        // The standard deviation is 1/2.
        Filter::Gaussian => (-2.0 * x * x).exp(),
        Filter::Blackman => {
            // The four-term Blackman-Harris window (Harris 1978), centred at 0.
            let turn = 0.5 * std::f64::consts::PI * x;
            0.35875 + 0.48829 * turn.cos() + 0.14128 * (2.0 * turn).cos() + 0.01168 * (3.0 * turn).cos()
        }
        // Mitchell and Netravali (1988), with B = C = 1/3.
        Filter::Mitchell if x < 1.0 => (7.0 * x - 12.0) * x * x + 16.0 / 3.0,
        Filter::Mitchell => ((-7.0 / 3.0 * x + 12.0) * x - 20.0) * x + 32.0 / 3.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::sobol::sobol;

    const ALL: [Filter; 5] =
        [Filter::Box, Filter::Tent, Filter::Gaussian, Filter::Blackman, Filter::Mitchell];

    #[test]
    fn samples_have_the_mean_and_the_variance_of_their_filter() {
        for filter in ALL {
            let sampler = FilterSampler::new(filter);
            // The moments of the filter by numerical integration.
            let steps = 200_000;
            let (mut total, mut second) = (0.0, 0.0);
            for i in 0..steps {
                let x = (2.0 * (f64::from(i) + 0.5) / f64::from(steps) - 1.0) * radius(filter);
                total += along_axis(filter, x);
                second += along_axis(filter, x) * x * x;
            }
            let exact = second / total;
            let closed_form = match filter {
                Filter::Box => Some(1.0 / 12.0),
                Filter::Tent => Some(1.0 / 6.0),
                // Truncated at four standard deviations.
                Filter::Gaussian => Some(0.25 * (1.0 - 8.0 * 1.338e-4 / 0.999_937)),
                Filter::Blackman | Filter::Mitchell => None,
            };
            assert!(closed_form.is_none_or(|value| (exact - value).abs() < 1e-5), "{filter:?}: {exact}");

            let count = 1 << 16;
            let mut sums = [(0.0, DVec2::ZERO, DVec2::ZERO); 2];
            for index in 0..count {
                let (point, is_negative) = sampler.sample(sobol(index, 7));
                let offset = point - 0.5;
                let sum = &mut sums[usize::from(is_negative)];
                *sum = (sum.0 + 1.0, sum.1 + offset, sum.2 + offset * offset);
            }
            let [above, below] = sums;
            let joined =
                |above: DVec2, below: DVec2| sampler.mass.positive * above - sampler.mass.negative * below;
            let of = |sum: DVec2, count: f64| if count > 0.0 { sum / count } else { DVec2::ZERO };
            let mean = joined(of(above.1, above.0), of(below.1, below.0));
            let variance = joined(of(above.2, above.0), of(below.2, below.0));
            assert!(mean.abs().max_element() < 1e-3, "{filter:?}: {mean}");
            assert!((variance - exact).abs().max_element() < 1e-3, "{filter:?}: {variance}, not {exact}");
            let fraction = below.0 / f64::from(count);
            let FilterMass { positive, negative } = sampler.mass;
            assert!((fraction - negative / (positive + negative)).abs() < 1e-3, "{filter:?}: {fraction}");
        }
    }

    #[test]
    fn the_masses_are_those_of_a_filter_with_integral_one() {
        for filter in ALL {
            let FilterMass { positive, negative } = FilterSampler::new(filter).mass;
            assert!((positive - negative - 1.0).abs() < 1e-12, "{filter:?}");
            assert_eq!(negative > 0.0, filter == Filter::Mitchell);
        }
    }

    #[test]
    fn positions_stay_within_the_radius_for_any_number() {
        for filter in ALL {
            let sampler = FilterSampler::new(filter);
            for unit in [0.0, 0.5, 1.0, 1.0 - f64::EPSILON, f64::MIN_POSITIVE] {
                let (point, _) = sampler.sample(DVec2::splat(unit));
                assert!((point - 0.5).abs().max_element() <= radius(filter), "{filter:?} {unit}: {point}");
            }
        }
    }
}
