//! Expectation-maximization of a shape and its noise, with steps of Levenberg and Marquardt.
//!
//! The weights of points are those of the expectation; the maximization is one step, taken where the
//! likelihood rises. The gradient has the term of the surface's area, too: of two shapes that meet the
//! points alike the smaller one is more probable, so hidden sides do not drift away.

use crate::mixture::Mixture;
use crate::normal_equations::NormalEquations;
use crate::parameters::{Bounds, Parameters};
use crate::project::Projection;
use crate::rows::Points;
use crate::surface::inscribed_area;
use crate::tangent::Linearization;

/// A shape, its noise and their cost.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Candidate {
    pub(crate) shape: Parameters,
    pub(crate) mixture: Mixture,
    /// The mean negative log-likelihood of the points; infinite before a refinement.
    pub(crate) cost: f64,
}

/// The distance that is minimized.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Residual {
    /// To a tangent plane: [`Linearization::set`].
    Tangent,
    /// To the closest point: [`Projection::set`].
    Closest,
}

/// Limits of a refinement.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Limits {
    pub(crate) residual: Residual,
    pub(crate) bounds: Bounds,
    pub(crate) iterations: usize,
    /// The refinement ends when the cost falls by less than this.
    pub(crate) tolerance: f64,
}

/// The most that sigma falls in one iteration.
const MOST_FALL: f64 = 0.6;
/// The most steps that are tried in one iteration.
const TRIES: usize = 4;

/// Distances to a shape and their derivatives, of one of the kinds.
#[derive(Default)]
pub(crate) struct Measure {
    pub(crate) linear: Linearization,
    projection: Projection,
}

impl Measure {
    pub(crate) fn set(&mut self, points: &Points, shape: &Parameters, residual: Residual) {
        match residual {
            Residual::Tangent => self.linear.set(&points.rows, shape),
            Residual::Closest => {
                self.projection.set(points, shape);
                // At the closest point the derivatives of the true distance are those of the plane's.
                self.linear.set(&self.projection.feet, shape);
                self.linear.distances.clone_from(&self.projection.distances);
            }
        }
    }
}

/// Improves a candidate on these points.
pub(crate) fn refine(points: &Points, start: &Candidate, limits: &Limits) -> Candidate {
    let (mut current, mut trial) = (Measure::default(), Measure::default());
    let mut weights = Vec::new();
    let Candidate { mut shape, mut mixture, .. } = *start;
    mixture = mixture.with_area(shape.rough_area());
    let mut damping = 1e-3;
    current.set(points, &shape, limits.residual);
    let mut cost = f64::INFINITY;
    for _ in 0..limits.iterations {
        let area = shape.rough_area();
        mixture.weights(points, &current.linear.distances, area, &mut weights);
        mixture = mixture.updated(points, &current.linear.distances, &weights, area, MOST_FALL);
        let before = mixture.cost(points, &current.linear.distances, area);
        if (cost - before).abs() < limits.tolerance {
            break;
        }
        cost = before;
        let mut equations = NormalEquations::of(&current.linear, &weights);
        let shrink =
            mixture.sigma.powi(2) * mixture.area_part(area) * (1.0 - mixture.outliers) * points.total;
        equations.add_gradient(&shape.log_area_slopes(), shrink);
        let mut is_better = false;
        for _ in 0..TRIES {
            if let Some(step) = equations.step(damping, &shape, limits.bounds) {
                let next = shape.after(&step, limits.bounds);
                trial.set(points, &next, limits.residual);
                let after = mixture.cost(points, &trial.linear.distances, next.rough_area());
                if after < before {
                    (shape, is_better) = (next, true);
                    std::mem::swap(&mut current, &mut trial);
                    damping = (damping * 0.2).max(1e-9);
                    break;
                }
            }
            damping = (damping * 8.0).max(1e-4);
        }
        if !is_better {
            break;
        }
    }
    let area = inscribed_area(&shape);
    let cost = mixture.with_area(area).cost(points, &current.linear.distances, area);
    Candidate { shape, mixture, cost }
}
