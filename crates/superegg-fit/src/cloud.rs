//! Points made ready for a search: checked, in an order that is their own, and of size 1.

use std::cmp::Ordering;

use rayon::prelude::*;
use superegg_geom::glam::{DMat3, DVec3};
use superegg_geom::{SplitMix, symmetric_eigen};

use crate::error::{FitError, LEAST_POINTS};
use crate::options::FitOptions;

/// Points at a distance of about 1 from their middle, in random order.
pub(crate) struct Cloud {
    pub(crate) points: Vec<DVec3>,
    /// The point `p` of the caller is `origin + scale * p`.
    pub(crate) origin: DVec3,
    pub(crate) scale: f64,
    /// The share of points so far away that they are left out.
    pub(crate) left_out: f64,
}

/// The range of extents of a cloud: squares and cubes of lengths stay in the range of f64.
const UNITS: std::ops::Range<f64> = 1e-95..1e95;
/// Points farther from the middle one than this many units are left out.
const FAR_AWAY: f64 = 1e4;

/// From this many points on it pays to use all cores.
const MANY: usize = 1 << 15;
/// Rounds in which points far from the middle are left out.
const ROUNDS: usize = 3;
/// Points farther from the middle than this many medians are left out.
const FAR: f64 = 3.0;
/// Points are on a plane whose thickness is less than this part of their extent.
const THIN: f64 = 1e-9;

impl Cloud {
    /// Checks and orders points.
    ///
    /// The result depends on the set of points, not on their order; and it is the same under shifts,
    /// rotations and scales, but for rounding: points are sorted by coordinates, so that sums are
    /// always the same, then by their distance from the mean, then mixed by the seed. The first ones
    /// are an even random choice, to which large clouds are thinned.
    pub(crate) fn new(points: &[DVec3], options: &FitOptions) -> Result<Self, FitError> {
        if let Some(index) = points.iter().position(|point| !point.is_finite()) {
            return Err(FitError::NotFinite { index });
        }
        let mut sorted = points.to_vec();
        sort(&mut sorted, by_coordinates);
        let distinct = 1 + sorted.windows(2).filter(|pair| pair[0] != pair[1]).count();
        let distinct = distinct.min(sorted.len());
        if distinct < LEAST_POINTS {
            return Err(FitError::TooFewPoints { count: points.len(), distinct });
        }
        let (origin, unit) = frame_of(&sorted);
        if !UNITS.contains(&unit) {
            return Err(FitError::Scale { extent: unit });
        }
        let count = sorted.len();
        for point in &mut sorted {
            *point = (0.5 * *point - 0.5 * origin) / (0.5 * unit);
        }
        sorted.retain(|point| point.abs().max_element() < FAR_AWAY);
        let left_out = (count - sorted.len()) as f64 / count as f64;
        let mean = sorted.iter().sum::<DVec3>() / sorted.len() as f64;
        let mut keyed: Vec<(f64, DVec3)> =
            sorted.into_iter().map(|point| ((point - mean).length_squared(), point)).collect();
        sort(&mut keyed, |a, b| a.0.total_cmp(&b.0));
        let mut sorted: Vec<DVec3> = keyed.into_iter().map(|(_, point)| point).collect();
        shuffle(&mut sorted, options.seed);
        sorted.truncate(options.most_points);
        let (middle, radius) = middle_of(&sorted);
        check_extent(&sorted, middle, FAR * radius)?;
        for point in &mut sorted {
            *point = (*point - middle) / radius;
        }
        Ok(Self { points: sorted, origin: origin + unit * middle, scale: unit * radius, left_out })
    }
}

/// The middle point of sorted ones, and the median of the distances from it that are not 0.
fn frame_of(sorted: &[DVec3]) -> (DVec3, f64) {
    let origin = sorted[sorted.len() / 2];
    // Halves, so that no difference overflows.
    let distances = sorted.iter().map(|point| (0.5 * *point - 0.5 * origin).abs().max_element());
    let mut distances: Vec<f64> = distances.filter(|distance| *distance > 0.0).collect();
    let middle = distances.len() / 2;
    (origin, 2.0 * *distances.select_nth_unstable_by(middle, f64::total_cmp).1)
}

/// Sorts in parallel where that pays; equal ones keep their order.
fn sort<T: Send>(items: &mut [T], order: impl Fn(&T, &T) -> Ordering + Sync) {
    if items.len() < MANY { items.sort_by(order) } else { items.par_sort_by(order) }
}

fn by_coordinates(a: &DVec3, b: &DVec3) -> Ordering {
    a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)).then(a.z.total_cmp(&b.z))
}

/// Mixes points (the algorithm of Fisher and Yates).
fn shuffle(points: &mut [DVec3], seed: u64) {
    let mut random = SplitMix::new(seed);
    for last in (1..points.len()).rev() {
        points.swap(last, (random.unit() * (last + 1) as f64) as usize);
    }
}

/// The mean of the points that are not far away, and their median distance from it.
fn middle_of(points: &[DVec3]) -> (DVec3, f64) {
    let mut middle = points.iter().sum::<DVec3>() / points.len() as f64;
    let mut radius = median_distance(points, middle);
    for _ in 0..ROUNDS {
        let near = points.iter().filter(|point| point.distance(middle) <= FAR * radius);
        let (sum, count) = near.fold((DVec3::ZERO, 0), |(sum, count), point| (sum + *point, count + 1));
        middle = sum / f64::from(count.max(1));
        radius = median_distance(points, middle);
    }
    (middle, radius)
}

fn median_distance(points: &[DVec3], from: DVec3) -> f64 {
    let mut distances: Vec<f64> = points.iter().map(|point| point.distance(from)).collect();
    let middle = distances.len() / 2;
    // The median of points of which most are one and the same would be 0.
    distances.select_nth_unstable_by(middle, f64::total_cmp).1.max(f64::MIN_POSITIVE)
}

/// Checks that the points near the middle are on no plane and no line.
fn check_extent(points: &[DVec3], middle: DVec3, reach: f64) -> Result<(), FitError> {
    let mut scatter = DMat3::ZERO;
    for point in points {
        let off = *point - middle;
        if off.length() <= reach {
            scatter += DMat3::from_cols(off * off.x, off * off.y, off * off.z);
        }
    }
    let (values, axes) = symmetric_eigen(scatter.to_cols_array_2d());
    let mut order = [0, 1, 2];
    order.sort_by(|&i, &j| values[j].total_cmp(&values[i]));
    // Eigenvalues are squares, of which rounding leaves half of the digits: extents are measured again.
    let extent = |index: usize| {
        let along = DVec3::from_array(axes[order[index]]);
        points
            .iter()
            .map(|point| *point - middle)
            .filter(|off| off.length() <= reach)
            .map(|off| off.dot(along).abs())
            .fold(0.0, f64::max)
    };
    let least = THIN * extent(0);
    if extent(1) <= least {
        Err(FitError::OnLine)
    } else if extent(2) <= least {
        Err(FitError::OnPlane)
    } else {
        Ok(())
    }
}
