//! Points spread evenly over the inside.

use glam::DVec3;

use crate::math::random::SplitMix;
use crate::superquadric::Superquadric;

/// An endless sequence of independent points of the inside of a shape, spread evenly by volume. The
/// same shape and seed give the same points on every machine with the same library functions.
///
/// No point is rejected. In the unit shape with `N = rho`, `R = rho u^(n/2)`, `|z| = rho (1 - u)^(n/2)`
/// and `|x| = R v^(e/2)`, `|y| = R (1 - v)^(e/2)`, an even density is
///
/// ```text
/// rho = U^(1/3),   u ~ Beta(n, n/2),   v ~ Beta(e/2, e/2)
/// ```
///
/// because the volume element is rho^2 drho times those densities (the integrals of
/// [`Superquadric::volume`]).
///
/// ```
/// use superegg_geom::{InteriorSampler, Superquadric};
/// let points: Vec<_> = InteriorSampler::new(&Superquadric::unit_sphere(), 7).take(1000).collect();
/// assert!(points.iter().all(|p| p.length() <= 1.0));
/// ```
#[derive(Clone, Debug)]
pub struct InteriorSampler {
    radii: DVec3,
    e: f64,
    n: f64,
    random: SplitMix,
}

impl InteriorSampler {
    /// The sequence of a shape and a seed.
    pub fn new(shape: &Superquadric, seed: u64) -> Self {
        let limited = |exponent: f64| exponent.clamp(1e-300, 1e6);
        let (e, n) = (limited(shape.exponents().e()), limited(shape.exponents().n()));
        Self { radii: shape.radii(), e, n, random: SplitMix::new(seed) }
    }

    /// The next point.
    pub fn sample(&mut self) -> DVec3 {
        let rho = self.random.unit().cbrt();
        let [around, along] = self.beta_powers(self.n, 0.5 * self.n, 0.5 * self.n);
        let [x, y] = self.beta_powers(0.5 * self.e, 0.5 * self.e, 0.5 * self.e);
        let radius = rho * around;
        self.random.signs() * DVec3::new(radius * x, radius * y, rho * along) * self.radii
    }

    /// (v^power, (1 - v)^power) for v ~ Beta(a, b), by logarithms: for small exponents v itself is
    /// 0 or 1 to the last digit where its power is not.
    fn beta_powers(&mut self, a: f64, b: f64, power: f64) -> [f64; 2] {
        let (log_a, log_b) = (self.log_gamma_variate(a), self.log_gamma_variate(b));
        let larger = log_a.max(log_b);
        let log_sum = larger + (-(log_a - log_b).abs()).exp().ln_1p();
        [log_a, log_b].map(|log| (power * (log - log_sum)).exp())
    }

    /// The logarithm of a number of the Gamma distribution, of any shape: G(a) = G(a + 1) U^(1/a).
    fn log_gamma_variate(&mut self, shape: f64) -> f64 {
        self.random.gamma(shape + 1.0).ln() + self.random.positive().ln() / shape
    }
}

impl Iterator for InteriorSampler {
    type Item = DVec3;

    fn next(&mut self) -> Option<DVec3> {
        Some(self.sample())
    }
}
