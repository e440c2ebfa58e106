//! The search for the shape of a cloud: from many starts on few points to one on all.

use superegg_geom::SplitMix;
use superegg_geom::glam::DVec3;

use crate::alike::{alike, is_one_sided, stretched};
use crate::dense::{DensePoints, dense_points};
use crate::mixture::Mixture;
use crate::parameters::{Bounds, Parameters};
use crate::refine::{Candidate, Limits, Residual, refine};
use crate::rows::Points;
use crate::starts::{is_round, random_starts, robust_ellipsoid, starts};
use crate::surface::{distance, inscribed_area};

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
/// The noise, as a part of the size, below which points are exact: no other shape has them, and distances to
/// tangent planes are the true ones.
const EXACT: f64 = 1e-3;
/// The difference of log-likelihoods below which two shapes explain points equally well: likelihoods differ
/// by a factor of less than 150.
const EVIDENCE: f64 = 5.0;
/// The distance between the surfaces of two different shapes, as a part of the size.
const OTHER: f64 = 0.02;
/// The most rivals of the best shape that are refined on all points.
const RIVALS: usize = 3;
/// The standard deviation to begin with, where the points are at a distance of about 1 from their middle.
const FIRST_SIGMA: f64 = 0.3;
/// The share of outliers among dense points to begin with.
const DENSE_OUTLIERS: f64 = 0.1;

/// The task of a search.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Question {
    pub(crate) bounds: Bounds,
    /// The share of outliers that is expected.
    pub(crate) outliers: f64,
    pub(crate) seed: u64,
}

/// The result of a search.
pub(crate) struct Found {
    pub(crate) best: Candidate,
    /// Another shape that the points show as well.
    pub(crate) rival: Option<Candidate>,
}

/// The best shape for points in random order, at a distance of about 1 from their middle.
pub(crate) fn search(points: &[DVec3], question: &Question) -> Found {
    let DensePoints { points: dense, share } = dense_points(points);
    let stages = Stages::new(points, &dense, question.bounds);
    let mut random = SplitMix::new(question.seed);
    let ellipsoid = &stages.ellipsoid;
    let mut shapes = starts(ellipsoid, question.bounds);
    let more = if is_round(ellipsoid) { RANDOM_STARTS[1] } else { RANDOM_STARTS[0] };
    shapes.extend(random_starts(ellipsoid, question.bounds, more, &mut random));
    let mut ranked = stages.best_from(&shapes);
    if ranked[0].mixture.sigma > POOR * ranked[0].shape.size() {
        let shapes = random_starts(ellipsoid, question.bounds, RANDOM_STARTS[2], &mut random);
        ranked.extend(stages.best_from(&shapes));
        ranked.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    }
    let outliers = question.outliers.max(1.0 - share).clamp(0.01, 0.9);
    let all = Points::new(points);
    let on_all = |candidate: &Candidate| {
        let start = Candidate { mixture: Mixture { outliers, ..candidate.mixture }, ..*candidate };
        refine(&all, &start, &stages.limits(40, 1e-5))
    };
    let (mut best, mut rival) = (on_all(&ranked[0]), None);
    let is_close = |other: &&Candidate| {
        misfit(other) < misfit(&ranked[0]) + EVIDENCE / stages.some.total && are_different(other, &ranked[0])
    };
    for other in ranked[1..].iter().filter(is_close).take(RIVALS) {
        let other = on_all(other);
        let is_as_good = (misfit(&other) - misfit(&best)).abs() < EVIDENCE / all.total;
        let loser = if other.cost < best.cost { std::mem::replace(&mut best, other) } else { other };
        if is_as_good && are_different(&loser, &best) {
            rival = Some(loser);
        }
    }
    if best.mixture.sigma > EXACT * best.shape.size() {
        let limits = Limits { residual: Residual::Closest, ..stages.limits(LAST, 1e-5) };
        best = refine(&all, &best, &limits);
    }
    Found { best, rival }
}

/// The cost without the part of the surface's area: how badly the points fit, however large the shape is where
/// there are none.
fn misfit(candidate: &Candidate) -> f64 {
    candidate.cost - (1.0 - candidate.mixture.outliers) * inscribed_area(&candidate.shape).ln()
}

/// Whether two surfaces are apart.
fn are_different(a: &Candidate, b: &Candidate) -> bool {
    distance(&a.shape, &b.shape) > OTHER * a.shape.size()
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

    /// The best candidate that any of the starts leads to, and then others that were refined as far.
    fn best_from(&self, shapes: &[Parameters]) -> Vec<Candidate> {
        let begin =
            |shape: &Parameters| Candidate { shape: *shape, mixture: self.mixture, cost: f64::INFINITY };
        let few = |candidate: &Candidate, iterations, tolerance| {
            refine(&self.few, candidate, &self.limits(iterations, tolerance))
        };
        let first = shapes.iter().map(|shape| few(&begin(shape), 4, 1e-3));
        let kept = best_of(first.collect(), KEPT);
        let finalists = best_of(kept.iter().map(|candidate| few(candidate, 8, 1e-4)).collect(), FINALISTS);
        let mut ranked = self.on_some(&finalists);
        let is_one_sided = is_one_sided(&ranked[0].shape, self.middle);
        if ranked[0].mixture.sigma < EXACT * ranked[0].shape.size() && !is_one_sided {
            return ranked;
        }
        self.improve(&mut ranked, Self::alike);
        if is_one_sided {
            self.improve(&mut ranked, Self::stretched);
        }
        ranked
    }

    /// Adds candidates that begin at shapes made from the best one, while they become better.
    fn improve(&self, ranked: &mut Vec<Candidate>, made: impl Fn(&Self, &Candidate) -> Vec<Candidate>) {
        for _ in 0..ROUNDS {
            let before = ranked[0].cost;
            ranked.extend(made(self, &ranked[0]));
            ranked.sort_by(|a, b| a.cost.total_cmp(&b.cost));
            if ranked[0].cost > before - SAME_COST {
                break;
            }
        }
    }

    /// Candidates after they are refined on the points of the second stage, the best first.
    fn on_some(&self, candidates: &[Candidate]) -> Vec<Candidate> {
        let limits = self.limits(12, 1e-5);
        let mut refined: Vec<Candidate> =
            candidates.iter().map(|candidate| refine(&self.some, candidate, &limits)).collect();
        refined.sort_by(|a, b| a.cost.total_cmp(&b.cost));
        refined
    }

    /// Candidates that begin at shapes similar to this one, those that few points leave in doubt.
    fn alike(&self, best: &Candidate) -> Vec<Candidate> {
        let sigma = (3.0 * best.mixture.sigma).clamp(0.05, FIRST_SIGMA);
        let mixture = Mixture { sigma, ..best.mixture };
        let found = alike(&best.shape, self.middle, self.bounds).into_iter().map(|shape| {
            refine(&self.few, &Candidate { shape, mixture, cost: f64::INFINITY }, &self.limits(8, 1e-4))
        });
        let enough = refine(&self.few, best, &self.limits(4, 1e-4)).cost + DOUBT;
        self.on_some(&best_of(found.filter(|found| found.cost < enough).collect(), FINALISTS))
    }

    /// Candidates of other extents along one axis.
    fn stretched(&self, best: &Candidate) -> Vec<Candidate> {
        let mixture = Mixture { sigma: 2.0 * best.mixture.sigma, ..best.mixture };
        let start = |shape| Candidate { shape, mixture, cost: f64::INFINITY };
        let starts: Vec<Candidate> = stretched(&best.shape, self.middle).into_iter().map(start).collect();
        self.on_some(&starts)
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
