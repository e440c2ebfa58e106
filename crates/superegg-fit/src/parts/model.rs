//! A set of shapes as one density, and how well it describes points.

use superegg_geom::glam::DVec3;

use crate::parameters::{COUNT, Parameters};
use crate::refine::{Candidate, Limits, Residual, refine};
use crate::rows::{Points, WIDTH};
use crate::search::{Question, search};
use crate::surface::inscribed_area;
use crate::tangent::Linearization;

/// The fewest points of a part.
pub(super) const LEAST_MEMBERS: usize = 40;
/// The noise of a part is less than this part of its size.
const MOST_NOISE: f64 = 0.5;
/// The share of outliers of a part to begin with.
const OUTLIERS: f64 = 0.05;

/// The best shape for the points of a group; `None` for too few points, for points that are all one, and for
/// points that show no surface.
pub(super) fn fitted(points: &[DVec3], members: &[usize], question: &Question) -> Option<Candidate> {
    if members.len() < LEAST_MEMBERS {
        return None;
    }
    let group: Vec<DVec3> = members.iter().map(|&index| points[index]).collect();
    let middle = group.iter().sum::<DVec3>() / group.len() as f64;
    let mut distances: Vec<f64> = group.iter().map(|point| point.distance(middle)).collect();
    let rank = distances.len() / 2;
    let unit = *distances.select_nth_unstable_by(rank, f64::total_cmp).1;
    if unit < 1e-6 {
        return None;
    }
    let own: Vec<DVec3> = group.iter().map(|point| (*point - middle) / unit).collect();
    let mut found = search(&own, &Question { outliers: OUTLIERS, ..*question }).best;
    found.shape.center = middle + unit * found.shape.center;
    found.shape.radii *= unit;
    found.mixture.sigma *= unit;
    found.mixture.area *= unit * unit;
    found.mixture.volume *= unit.powi(3);
    Some(found).filter(is_surface)
}

/// Whether a shape is larger than its noise. One that is smaller stands for a swarm of points.
pub(super) fn is_surface(found: &Candidate) -> bool {
    found.mixture.sigma < MOST_NOISE * found.shape.size()
}

/// Improves a shape on some points.
pub(super) fn improved(
    points: &[DVec3],
    members: &[usize],
    start: &Candidate,
    question: &Question,
) -> Candidate {
    let group: Vec<DVec3> = members.iter().map(|&index| points[index]).collect();
    let limits =
        Limits { residual: Residual::Tangent, bounds: question.bounds, iterations: 12, tolerance: 1e-5 };
    refine(&Points::new(&group), start, &limits)
}

/// Points described by shapes and uniform outliers.
pub(super) struct Description {
    /// The part that each point belongs to; `None` for outliers.
    pub(super) part_of: Vec<Option<usize>>,
    /// The length of the description in nats: the negative log-likelihood of the points, and half the
    /// logarithm of their number for each parameter.
    pub(super) length: f64,
}

/// Describes points. `volume` is that of the outliers.
pub(super) fn described(
    points: &[DVec3],
    members: &[usize],
    shapes: &[Candidate],
    volume: f64,
) -> Description {
    let group: Vec<DVec3> = members.iter().map(|&index| points[index]).collect();
    let rows = Points::new(&group);
    // The logarithm of the density of each part, without its share.
    let densities: Vec<Vec<f64>> = shapes
        .iter()
        .map(|Candidate { shape, mixture, .. }| {
            let mut linear = Linearization::default();
            linear.set(&rows.rows, shape);
            let area = inscribed_area(shape);
            let peak = -mixture.with_area(area).log_layer(area);
            let rate = -0.5 / (mixture.sigma * mixture.sigma);
            let distance = |index: usize| linear.distances[index / WIDTH][index % WIDTH];
            (0..group.len()).map(|index| peak + rate * distance(index).powi(2)).collect()
        })
        .collect();
    let count = group.len() as f64;
    let mut shares = vec![1.0 / (shapes.len() + 1) as f64; shapes.len() + 1];
    let mut part_of = vec![None; group.len()];
    let mut log_likelihood = 0.0;
    // The shares of the parts: a few steps of expectation and maximization.
    for _ in 0..5 {
        let mut sums = vec![0.0; shares.len()];
        log_likelihood = 0.0;
        for (index, part) in part_of.iter_mut().enumerate() {
            let mut logs: Vec<f64> =
                densities.iter().zip(&shares).map(|(density, share)| density[index] + share.ln()).collect();
            logs.push(shares[shapes.len()].ln() - volume.ln());
            let (best, largest) =
                logs.iter().enumerate().fold((0, f64::NEG_INFINITY), |best, (part, log)| {
                    if *log > best.1 { (part, *log) } else { best }
                });
            let total: f64 = logs.iter().map(|log| (log - largest).exp()).sum();
            for (sum, log) in sums.iter_mut().zip(&logs) {
                *sum += (log - largest).exp() / total;
            }
            log_likelihood += largest + total.ln();
            *part = (best < shapes.len()).then_some(best);
        }
        shares = sums.iter().map(|sum| ((sum + 0.5) / (count + 0.5 * sums.len() as f64)).max(1e-9)).collect();
    }
    let parameters = (COUNT + 1) as f64 * shapes.len() as f64;
    Description { part_of, length: -log_likelihood + 0.5 * parameters * count.ln() }
}

/// Whether the balls around two shapes come near each other.
pub(super) fn are_close(a: &Parameters, b: &Parameters) -> bool {
    a.center.distance(b.center) < 1.1 * (a.radii.length() + b.radii.length())
}
