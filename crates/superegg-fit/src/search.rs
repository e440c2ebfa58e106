//! The search for the shape of a cloud: from many starts on few points to one on all.

use superegg_geom::SplitMix;
use superegg_geom::glam::DVec3;

use crate::alike::alike;
use crate::dense::{DensePoints, dense_points};
use crate::mixture::Mixture;
use crate::parameters::{Bounds, Parameters};
use crate::refine::{Candidate, Limits, Residual, refine};
use crate::rows::Points;
use crate::starts::{is_round, random_starts, robust_ellipsoid, starts};

/// The points of the first stage, and of the second.
const FEW: usize = 200;
const SOME: usize = 600;
/// The starts that the first stage keeps after a few iterations.
const KEPT: usize = 5;
/// The candidates that reach the second stage.
const FINALISTS: usize = 2;
/// Starts in random directions: besides others, where no direction stands out, and where the first
/// search fails.
const RANDOM_STARTS: [usize; 3] = [4, 10, 30];
/// The noise, as a part of the size, from which on more starts are tried.
const POOR: f64 = 0.03;
/// Costs that differ by less are of the same shape.
const SAME_COST: f64 = 1e-3;
/// The most rounds in which similar shapes are tried.
const ROUNDS: usize = 3;
/// The most iterations on the true distance.
const LAST: usize = 5;
/// The cost by which few points may differ from many.
const DOUBT: f64 = 0.02;
/// The standard deviation to begin with, where the points are at a distance of about 1 from their middle.
const FIRST_SIGMA: f64 = 0.3;
/// The share of outliers among dense points to begin with.
const DENSE_OUTLIERS: f64 = 0.1;

/// What is asked of a search.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Question {
    pub(crate) bounds: Bounds,
    /// The share of outliers that is expected.
    pub(crate) outliers: f64,
    pub(crate) seed: u64,
}

/// The best shape for points in random order, at a distance of about 1 from their middle.
pub(crate) fn search(points: &[DVec3], question: &Question) -> Candidate {
    let DensePoints { points: dense, share } = dense_points(points);
    let stages = Stages::new(points, &dense, question.bounds);
    let mut random = SplitMix::new(question.seed);
    let ellipsoid = &stages.ellipsoid;
    let mut shapes = starts(ellipsoid, question.bounds);
    let more = if is_round(ellipsoid) { RANDOM_STARTS[1] } else { RANDOM_STARTS[0] };
    shapes.extend(random_starts(ellipsoid, question.bounds, more, &mut random));
    let mut best = stages.best_from(&shapes);
    if best.mixture.sigma > POOR * best.shape.size() {
        let shapes = random_starts(ellipsoid, question.bounds, RANDOM_STARTS[2], &mut random);
        let other = stages.best_from(&shapes);
        if other.cost < best.cost {
            best = other;
        }
    }
    best.mixture.outliers = question.outliers.max(1.0 - share).clamp(0.01, 0.9);
    let all = Points::new(points);
    let near = refine(&all, &best, &stages.limits(40, 1e-5));
    refine(&all, &near, &Limits { residual: Residual::Closest, ..stages.limits(LAST, 1e-6) })
}

/// The stages before the last one.
struct Stages {
    few: Points,
    some: Points,
    /// The middle of the dense points.
    middle: DVec3,
    ellipsoid: Parameters,
    mixture: Mixture,
    bounds: Bounds,
}

impl Stages {
    fn new(points: &[DVec3], dense: &[DVec3], bounds: Bounds) -> Self {
        let prefix = |count: usize| &dense[..dense.len().min(count)];
        let ellipsoid = robust_ellipsoid(prefix(SOME));
        let volume = volume_of(&points[..points.len().min(SOME)], &ellipsoid);
        let area = ellipsoid.rough_area();
        Self {
            few: Points::new(prefix(FEW)),
            some: Points::new(prefix(SOME)),
            middle: dense.iter().sum::<DVec3>() / dense.len() as f64,
            ellipsoid,
            mixture: Mixture { sigma: FIRST_SIGMA, outliers: DENSE_OUTLIERS, area, volume },
            bounds,
        }
    }

    fn limits(&self, iterations: usize, tolerance: f64) -> Limits {
        Limits { residual: Residual::Tangent, bounds: self.bounds, iterations, tolerance }
    }

    /// The best candidate that any of the starts leads to.
    fn best_from(&self, shapes: &[Parameters]) -> Candidate {
        let begin =
            |shape: &Parameters| Candidate { shape: *shape, mixture: self.mixture, cost: f64::INFINITY };
        let few = |candidate: &Candidate, iterations, tolerance| {
            refine(&self.few, candidate, &self.limits(iterations, tolerance))
        };
        let first = shapes.iter().map(|shape| few(&begin(shape), 4, 1e-3));
        let kept = best_of(first.collect(), KEPT);
        let finalists = best_of(kept.iter().map(|candidate| few(candidate, 8, 1e-4)).collect(), FINALISTS);
        let mut best = self.best_on_some(&finalists);
        for _ in 0..ROUNDS {
            match self.better_alike(&best) {
                Some(better) => best = better,
                None => break,
            }
        }
        best
    }

    /// The best of some candidates after they are refined on the points of the second stage.
    fn best_on_some(&self, candidates: &[Candidate]) -> Candidate {
        let limits = self.limits(12, 1e-5);
        best_of(candidates.iter().map(|candidate| refine(&self.some, candidate, &limits)).collect(), 1)[0]
    }

    /// A better candidate that begins at a shape similar to this one.
    fn better_alike(&self, best: &Candidate) -> Option<Candidate> {
        let sigma = (3.0 * best.mixture.sigma).clamp(0.05, FIRST_SIGMA);
        let mixture = Mixture { sigma, ..best.mixture };
        let found = alike(&best.shape, self.middle, self.bounds).into_iter().map(|shape| {
            refine(&self.few, &Candidate { shape, mixture, cost: f64::INFINITY }, &self.limits(8, 1e-4))
        });
        let enough = refine(&self.few, best, &self.limits(4, 1e-4)).cost + DOUBT;
        let promising = best_of(found.filter(|found| found.cost < enough).collect(), FINALISTS);
        if promising.is_empty() {
            return None;
        }
        Some(self.best_on_some(&promising)).filter(|found| found.cost < best.cost - SAME_COST)
    }
}

/// The candidates of the lowest costs, the lowest first, without repetitions; at least one of some.
fn best_of(mut candidates: Vec<Candidate>, count: usize) -> Vec<Candidate> {
    candidates.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    candidates.dedup_by(|a, b| (a.cost - b.cost).abs() < SAME_COST);
    candidates.truncate(count);
    candidates
}

/// The volume that outliers may be in: the box along the axes of the ellipsoid that holds nearly
/// all points.
fn volume_of(points: &[DVec3], ellipsoid: &Parameters) -> f64 {
    let to_own = ellipsoid.axes.transpose();
    let mut volume = 1.0;
    for axis in 0..3 {
        let mut along: Vec<f64> = points.iter().map(|point| (to_own * *point)[axis]).collect();
        along.sort_by(f64::total_cmp);
        let rank = |part: f64| along[(part * (along.len() - 1) as f64) as usize];
        volume *= (rank(0.99) - rank(0.01)).max(1e-3);
    }
    volume
}
