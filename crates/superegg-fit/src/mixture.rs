//! The noise of a cloud: distances of the surface's points are normal, other points are uniform.

use std::f64::consts::{LN_2, LOG2_E, PI};

use superegg_simd::power::{exp2, log2};
use superegg_simd::{Arch, Simd, WithSimd};

use crate::rows::{Points, Row, WIDTH};

/// Points of a surface with normal distances, and outliers that are uniform in a volume:
///
/// ```text
/// density = (1 - outliers) / layer * exp(-d^2 / (2 sigma^2)) + outliers / volume
/// layer = sqrt(2 pi) sigma (area + 4 pi sigma^2)
/// ```
///
/// While the shape is improved, only the power k of the area varies with it, which draws the shape
/// inwards by k sigma^2 d ln(area). Normal noise moves points of a curved surface outwards by sigma^2
/// times the mean curvature on average. k = 1/2 takes exactly that back where points are all around;
/// where one half is hidden the other one bears the pull of the whole area, and k = 1/4 would. Less is
/// better there, because the pull meets no resistance at hidden sides, but some keeps them from
/// drifting away.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Mixture {
    /// The standard deviation of the distances.
    pub(crate) sigma: f64,
    /// The share of outliers.
    pub(crate) outliers: f64,
    /// The area of the surface before the shape is improved.
    pub(crate) area: f64,
    /// The volume of the outliers.
    pub(crate) volume: f64,
}

/// The power k of the area.
const AREA_POWER: f64 = 0.15;
/// The square root of 2 pi.
const ROOT_TWO_PI: f64 = 2.506_628_274_631_000_5;
/// The range of the share of outliers.
const LEAST_OUTLIERS: f64 = 1e-3;
const MOST_OUTLIERS: f64 = 0.9;
/// The smallest standard deviation, where the points are at a distance of about 1 from their middle.
const LEAST_SIGMA: f64 = 1e-7;

impl Mixture {
    /// The volume of the layer around the surface.
    fn layer(&self, area: f64) -> f64 {
        let (now, before) = (self.thick_area(area), self.thick_area(self.area));
        ROOT_TWO_PI * self.sigma * before * (now / before).powf(AREA_POWER)
    }

    /// The logarithm of the volume of the layer around the surface.
    pub(crate) fn log_layer(&self, area: f64) -> f64 {
        self.layer(area).ln()
    }

    /// The second term, of Steiner's formula, keeps a shape from shrinking to a point.
    fn thick_area(&self, area: f64) -> f64 {
        area + 4.0 * PI * self.sigma * self.sigma
    }

    /// The derivative of the logarithm of the layer by that of the area.
    pub(crate) fn area_part(&self, area: f64) -> f64 {
        AREA_POWER * area / self.thick_area(area)
    }

    /// The density of outliers over the largest density on the surface.
    pub(crate) fn background(&self, area: f64) -> f64 {
        self.outliers / self.volume * self.layer(area) / (1.0 - self.outliers)
    }

    /// The factor on the square of a distance, in the power of two that is its density.
    fn rate(&self) -> f64 {
        -0.5 * LOG2_E / (self.sigma * self.sigma)
    }

    /// The probabilities that points at these distances are of the surface, times their presence.
    pub(crate) fn weights(&self, points: &Points, distances: &[Row], area: f64, to: &mut Vec<Row>) {
        to.resize(distances.len(), [0.0; WIDTH]);
        let (background, rate) = (self.background(area), self.rate());
        Arch::new().dispatch(Weights { presence: &points.presence, distances, background, rate, to });
    }

    /// The negative logarithm of the density, its mean over points at these distances.
    pub(crate) fn cost(&self, points: &Points, distances: &[Row], area: f64) -> f64 {
        let (background, rate) = (self.background(area), self.rate());
        let sum = Arch::new().dispatch(Cost { presence: &points.presence, distances, background, rate });
        let peak = (1.0 - self.outliers) / self.layer(area);
        -sum * LN_2 / points.total - peak.ln()
    }

    /// The mixture of another shape of this area.
    pub(crate) fn with_area(&self, area: f64) -> Self {
        Self { area, ..*self }
    }

    /// The mixture that fits these distances best, given the weights. The standard deviation falls
    /// to no less than `most_fall` of what it is.
    pub(crate) fn updated(
        &self,
        points: &Points,
        distances: &[Row],
        weights: &[Row],
        area: f64,
        most_fall: f64,
    ) -> Self {
        let (mut totals, mut squares) = ([0.0; WIDTH], [0.0; WIDTH]);
        for (distance, weight) in distances.iter().zip(weights) {
            for lane in 0..WIDTH {
                totals[lane] += weight[lane];
                squares[lane] += weight[lane] * distance[lane] * distance[lane];
            }
        }
        let (total, squares) = (totals.iter().sum::<f64>(), squares.iter().sum::<f64>());
        // The derivative of the layer's logarithm by that of sigma.
        let freedom = 3.0 - 2.0 * area / self.thick_area(area);
        let sigma = (squares / (freedom * total).max(1e-300)).sqrt();
        Self {
            sigma: sigma.max(most_fall * self.sigma).max(LEAST_SIGMA),
            area,
            outliers: (1.0 - total / points.total).clamp(LEAST_OUTLIERS, MOST_OUTLIERS),
            ..*self
        }
    }
}

struct Weights<'a> {
    presence: &'a [Row],
    distances: &'a [Row],
    background: f64,
    rate: f64,
    to: &'a mut [Row],
}

impl WithSimd for Weights<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        for ((to, distance), presence) in self.to.iter_mut().zip(self.distances).zip(self.presence) {
            for lane in 0..WIDTH {
                let density = exp2::<false>(self.rate * distance[lane] * distance[lane]);
                to[lane] = presence[lane] * density / (density + self.background);
            }
        }
    }
}

struct Cost<'a> {
    presence: &'a [Row],
    distances: &'a [Row],
    background: f64,
    rate: f64,
}

impl WithSimd for Cost<'_> {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> f64 {
        let mut sums = [0.0; WIDTH];
        for (distance, presence) in self.distances.iter().zip(self.presence) {
            for lane in 0..WIDTH {
                let density = exp2::<false>(self.rate * distance[lane] * distance[lane]);
                sums[lane] += presence[lane] * log2::<false>(density + self.background);
            }
        }
        sums.iter().sum()
    }
}
