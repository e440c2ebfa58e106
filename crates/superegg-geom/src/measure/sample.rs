//! Points spread evenly over the surface by area.

use std::sync::Arc;

use glam::DVec3;

use super::area::{AreaElement, ProfileFactors};
use crate::math::random::SplitMix;
use crate::superquadric::Superquadric;

/// A point of the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct SurfacePoint {
    /// The point, in the shape's own space.
    pub point: DVec3,
    /// The outward unit normal there, as [`Superquadric::normal`] returns it.
    pub normal: DVec3,
}

/// An endless sequence of independent points of a surface, each part of which gets points in
/// proportion to its area. The same shape and seed give the same points on every machine with the
/// same library functions.
///
/// The density is exact, by rejection: the parameter plane of the surface (see
/// [`Superquadric::surface_area_with_error`]) is cut into cells, on each of which the area element
/// has a proven upper bound. A cell is drawn in proportion to its bound, a point of it evenly, and
/// the point is accepted with the ratio of area element to bound. The bounds are products of
/// monotone factors, so they hold for spikes, creases and boxes too.
///
/// ```
/// use superegg_geom::{Exponents, Superquadric, SurfaceSampler};
/// let star = Superquadric::unit(Exponents::new(3.0, 2.5)?);
/// let points: Vec<_> = SurfaceSampler::new(&star, 7).take(100).collect();
/// assert!(points.iter().all(|p| (star.norm().value(p.point) - 1.0).abs() < 1e-12));
/// assert!(SurfaceSampler::new(&star, 7).take(100).eq(points));
/// # Ok::<(), superegg_geom::ShapeError>(())
/// ```
#[derive(Clone, Debug)]
pub struct SurfaceSampler {
    shape: Superquadric,
    element: AreaElement,
    /// The sides of a cell.
    steps: [f64; 2],
    /// The sum of the bounds of all cells up to and with each one.
    cumulative: Arc<[f64]>,
    random: SplitMix,
}

/// The cells along each half of an arc's parameter.
const HALF_CELLS: usize = 80;
const CELLS: usize = 2 * HALF_CELLS;

impl SurfaceSampler {
    /// The sequence of a shape and a seed. Making it takes about a millisecond, a point less than a
    /// microsecond.
    pub fn new(shape: &Superquadric, seed: u64) -> Self {
        let element = AreaElement::of(shape);
        let steps = element.ends().map(|end| end / HALF_CELLS as f64);
        let mut sum = 0.0;
        let mut cumulative = Vec::with_capacity(CELLS * CELLS);
        let bounds = CellBounds::of(&element, steps);
        for j in 0..CELLS {
            for i in 0..CELLS {
                sum += bounds.of_cell(i, j);
                cumulative.push(sum);
            }
        }
        Self { shape: *shape, element, steps, cumulative: cumulative.into(), random: SplitMix::new(seed) }
    }

    /// The sequence of the same shape and another seed. It shares the tables of this one.
    #[must_use]
    pub fn with_seed(&self, seed: u64) -> Self {
        Self { random: SplitMix::new(seed), ..self.clone() }
    }

    /// The next point.
    pub fn sample(&mut self) -> SurfacePoint {
        let total = self.cumulative[self.cumulative.len() - 1];
        loop {
            let target = self.random.unit() * total;
            let cell = self.cumulative.partition_point(|&sum| sum <= target).min(CELLS * CELLS - 1);
            let before = if cell == 0 { 0.0 } else { self.cumulative[cell - 1] };
            let bound = self.cumulative[cell] - before;
            let [i, j] = [cell % CELLS, cell / CELLS];
            let s = (i as f64 - HALF_CELLS as f64 + self.random.unit()) * self.steps[0];
            let sigma = (j as f64 - HALF_CELLS as f64 + self.random.unit()) * self.steps[1];
            let around = self.element.around.at(s.sinh());
            let profile = self.element.profile.at(sigma.sinh());
            let factors = AreaElement::profile_factors(&profile);
            let value = AreaElement::value(&self.element.around_factors(&around), &factors);
            if self.random.unit() * bound < value * s.cosh() * sigma.cosh() {
                let eighth = DVec3::new(profile.x * around.x, profile.x * around.y, profile.y);
                let point = self.random.signs() * eighth * self.shape.radii();
                return SurfacePoint { point, normal: self.shape.normal(point) };
            }
        }
    }
}

impl Iterator for SurfaceSampler {
    type Item = SurfacePoint;

    fn next(&mut self) -> Option<SurfacePoint> {
        Some(self.sample())
    }
}

impl Superquadric {
    /// `count` independent points spread evenly over the surface by area: the first ones of
    /// [`SurfaceSampler`].
    ///
    /// ```
    /// use superegg_geom::Superquadric;
    /// let points = Superquadric::unit_sphere().sample_surface(1000, 42);
    /// let mean_height = points.iter().map(|p| p.point.z.abs()).sum::<f64>() / 1000.0;
    /// assert!((mean_height - 0.5).abs() < 0.05);
    /// ```
    pub fn sample_surface(&self, count: usize, seed: u64) -> Vec<SurfacePoint> {
        SurfaceSampler::new(self, seed).take(count).collect()
    }
}

/// Upper bounds of the factors of the area element in each column and row of cells.
struct CellBounds {
    around: Vec<super::area::AroundFactors>,
    profile: Vec<(ProfileFactors, f64)>,
    around_cosh: Vec<f64>,
}

impl CellBounds {
    fn of(element: &AreaElement, steps: [f64; 2]) -> Self {
        let edge = |i: usize, step: f64| (i as f64 - HALF_CELLS as f64) * step;
        let largest_cosh = |i: usize, step: f64| edge(i, step).cosh().max(edge(i + 1, step).cosh());
        // X falls and Y rises along an arc, and so do the factors S(-t) and S(t) of their speeds.
        let bounds = |arc: super::arc::Arc, i: usize, step: f64| {
            let (low, high) = (arc.at(edge(i, step).sinh()), arc.at(edge(i + 1, step).sinh()));
            let x_fall = arc.speed(low.x, high.share);
            let y_rise = arc.speed(high.y, low.rest);
            // The bounds are exceeded by rounding alone.
            [low.x, high.y, x_fall, y_rise].map(|bound| bound * (1.0 + 1e-12))
        };
        let around = (0..CELLS).map(|i| {
            let [x, y, x_fall, y_rise] = bounds(element.around, i, steps[0]);
            element.around_factors_of(x, y, x_fall, y_rise)
        });
        let profile = (0..CELLS).map(|j| {
            let [rho, _, rho_fall, zeta_rise] = bounds(element.profile, j, steps[1]);
            (ProfileFactors { rho, rho_fall, zeta_rise }, largest_cosh(j, steps[1]))
        });
        Self {
            around: around.collect(),
            profile: profile.collect(),
            around_cosh: (0..CELLS).map(|i| largest_cosh(i, steps[0])).collect(),
        }
    }

    fn of_cell(&self, i: usize, j: usize) -> f64 {
        let (factors, cosh) = &self.profile[j];
        AreaElement::value(&self.around[i], factors) * cosh * self.around_cosh[i]
    }
}
