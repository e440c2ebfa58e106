//! The norm form of the superquadric: a function with the zero set of `io` that scales like a
//! distance.

use glam::DVec3;

use crate::shape::Exponents;

/// The two-term norm `|(a, b)|_p = (a^p + b^p)^(1/p)` of non-negative numbers, p > 0. A norm for p
/// >= 1; for p < 1 it is homogeneous too, but concave along lines of the quadrant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PowerNorm {
    pub(crate) p: f64,
    inverse_p: f64,
}

impl PowerNorm {
    pub(crate) fn new(p: f64) -> Self {
        // Exponents below 1e-300 are boxes like that of 1e-300; an infinite power would make 0
        // times infinity.
        let p = p.min(1e300);
        Self { p, inverse_p: 1.0 / p }
    }

    /// The norm. Divides by the larger argument first, so that nothing overflows: `m (1 +
    /// r^p)^(1/p)`, `r = min / m` in [0, 1].
    pub(crate) fn value(&self, a: f64, b: f64) -> f64 {
        let larger = a.max(b);
        let smaller = a.min(b);
        if smaller == 0.0 {
            return larger;
        }
        let ratio = smaller / larger;
        if self.p == 2.0 {
            return larger * ratio.mul_add(ratio, 1.0).sqrt();
        }
        larger * (1.0 + ratio.powf(self.p)).powf(self.inverse_p)
    }

    /// The logarithm of the norm, from those of its arguments: for norms beyond the range of f64.
    fn log_value(&self, log_a: f64, log_b: f64) -> f64 {
        let (larger, smaller) = (log_a.max(log_b), log_a.min(log_b));
        if larger == f64::NEG_INFINITY {
            larger
        } else {
            larger + (self.p * (smaller - larger)).exp().ln_1p() / self.p
        }
    }

    /// The norm and its partial derivatives by `a` and `b`. At (0, 0) the derivatives are 0, one of
    /// its subgradients for p >= 1. For p < 1 the derivative by an argument that is 0 is infinite.
    pub(crate) fn value_and_gradient(&self, a: f64, b: f64) -> (f64, f64, f64) {
        let (larger, smaller) = (a.max(b), a.min(b));
        if larger == 0.0 {
            return (0.0, 0.0, 0.0);
        }
        let ratio = smaller / larger;
        let (growth, by_larger, by_smaller) = if self.p == 2.0 {
            let growth = ratio.mul_add(ratio, 1.0).sqrt();
            (growth, 1.0 / growth, ratio / growth)
        } else if ratio > 0.0 {
            let power = ratio.powf(self.p);
            let sum = 1.0 + power;
            let growth = sum.powf(self.inverse_p);
            let by_larger = growth / sum;
            (growth, by_larger, by_larger * (power / ratio))
        } else {
            // The limit of r^(p-1) at r = 0.
            let at_zero = match self.p.partial_cmp(&1.0) {
                Some(std::cmp::Ordering::Less) => f64::INFINITY,
                Some(std::cmp::Ordering::Equal) => 1.0,
                _ => 0.0,
            };
            (1.0, 1.0, at_zero)
        };
        let (by_a, by_b) = if a >= b { (by_larger, by_smaller) } else { (by_smaller, by_larger) };
        (larger * growth, by_a, by_b)
    }

    /// The norm whose unit ball's support function is this one's dual: p' with 1/p + 1/p' = 1, and
    /// infinity for p <= 1, where the convex hull of the ball is that of its corners.
    pub(crate) fn dual(&self) -> Self {
        Self::new(if self.p > 1.0 { self.p / (self.p - 1.0) } else { f64::INFINITY })
    }
}

/// The norm form of the unit superquadric,
///
/// ```text
/// R(x, y) = (|x|^p + |y|^p)^(1/p),   N(x, y, z) = (R^q + |z|^q)^(1/q),   p = 2/e, q = 2/n,
/// ```
///
/// with `io = N^q - 1`: N is below 1 inside, 1 on the surface, above 1 outside, and homogeneous of
/// degree one. For e, n <= 2 it is a norm in the strict sense, hence convex.
///
/// ```
/// use superegg_geom::{Exponents, NormForm, glam::DVec3};
/// let octahedron = NormForm::new(Exponents::new(2.0, 2.0)?);
/// assert_eq!(octahedron.value(DVec3::new(0.5, -0.25, 1.0)), 1.75);
/// // The farthest point of the shape along a direction, and how far it is.
/// assert_eq!(octahedron.support(DVec3::new(1.0, 2.0, 0.0)), 2.0);
/// # Ok::<(), superegg_geom::ShapeError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NormForm {
    /// Joins |x| and |y| to R.
    pub(crate) xy: PowerNorm,
    /// Joins R and |z| to N.
    pub(crate) rz: PowerNorm,
}

impl NormForm {
    /// The norm form for these exponents.
    pub fn new(exponents: Exponents) -> Self {
        Self { xy: PowerNorm::new(2.0 / exponents.e()), rz: PowerNorm::new(2.0 / exponents.n()) }
    }

    /// `N(v)` >= 0, with an error of a few ulps. Infinite only where the true value leaves the
    /// range of f64.
    pub fn value(&self, v: DVec3) -> f64 {
        let v = v.abs();
        self.rz.value(self.xy.value(v.x, v.y), v.z)
    }

    /// `N(v)` and its gradient. Where the gradient is not unique (edges, poles, the coordinate
    /// planes of shapes with e or n >= 2) a fixed finite choice: the component of a coordinate that
    /// is 0 is 0.
    pub fn value_and_gradient(&self, v: DVec3) -> (f64, DVec3) {
        let m = v.abs();
        let (r, r_by_x, r_by_y) = self.xy.value_and_gradient(m.x, m.y);
        let (norm, by_r, by_z) = self.rz.value_and_gradient(r, m.z);
        let component = |coordinate: f64, derivative: f64| {
            if coordinate == 0.0 { 0.0 } else { derivative.min(f64::MAX).copysign(coordinate) }
        };
        let gradient =
            DVec3::new(component(v.x, by_r * r_by_x), component(v.y, by_r * r_by_y), component(v.z, by_z));
        (norm, gradient)
    }

    /// The inside-outside function `io(v) = N^q - 1`, computed from N, so that intermediate powers
    /// do not underflow. Infinite where the true value leaves the range of f64: for e = n = 0.0001,
    /// four per cent outside the surface.
    pub fn inside_outside(&self, v: DVec3) -> f64 {
        let norm = self.value(v);
        if norm.is_finite() {
            return (self.rz.p * norm.ln()).exp_m1();
        }
        // N itself overflows for exponents in the thousands, where its power need not.
        let v = v.abs();
        let log_r = self.xy.log_value(v.x.ln(), v.y.ln());
        (self.rz.p * self.rz.log_value(log_r, v.z.ln())).exp_m1()
    }

    /// The support function of the unit shape: the largest `u . v` over its points v. It is the
    /// dual norm of u.
    pub fn support(&self, u: DVec3) -> f64 {
        let u = u.abs();
        self.rz.dual().value(self.xy.dual().value(u.x, u.y), u.z)
    }
}

/// The number of shapes whose bounds are computed at once. Those of one shape alone take as long:
/// each step waits for the one before.
pub const BOUND_SHAPES: usize = 4;

/// Each shape has three directions.
const LANES: usize = 3 * BOUND_SHAPES;

/// Upper bounds of the support functions of four unit shapes for three directions each, at most
/// [`BOUND_EXCESS`] of them too large. The directions are the rows of matrices with these columns.
/// They take a tenth of the time of [`NormForm::support`].
pub(crate) fn support_bounds(
    exponents: &[Exponents; BOUND_SHAPES],
    columns: [[&DVec3; 3]; BOUND_SHAPES],
) -> [DVec3; BOUND_SHAPES] {
    let (mut xy, mut rz) = ([0.0; BOUND_SHAPES], [0.0; BOUND_SHAPES]);
    let mut components = [[0.0; LANES]; 3];
    for shape in 0..BOUND_SHAPES {
        let norm = NormForm::new(exponents[shape]);
        (xy[shape], rz[shape]) = (norm.xy.dual().p, norm.rz.dual().p);
        for (component, column) in components.iter_mut().zip(columns[shape]) {
            for (direction, x) in column.to_array().into_iter().enumerate() {
                component[direction * BOUND_SHAPES + shape] = x.abs();
            }
        }
    }
    let around = norm_bounds(&xy, &components[0], &components[1]);
    let bounds = norm_bounds(&rz, &around, &components[2]);
    std::array::from_fn(|shape| {
        let [x, y, z] = [0, 1, 2].map(|direction| bounds[direction * BOUND_SHAPES + shape]);
        DVec3::new(x, y, z)
    })
}

/// Upper bounds of [`PowerNorm::value`] for powers `p` >= 1, one for each shape.
///
/// The factor on the larger argument, (1 + r^p)^(1/p), is computed in f32 without any call, step by
/// step for all, so that the compiler keeps the norms side by side in registers.
#[inline]
fn norm_bounds(p: &[f64; BOUND_SHAPES], a: &[f64; LANES], b: &[f64; LANES]) -> [f64; LANES] {
    /// Above this power the factor is 1 in f32, and a smaller power has a larger factor.
    const MOST_POWER: f64 = 1e9;
    /// More than the error of the factor.
    const EXCESS: f64 = 1.0 + 1e-6;
    /// Below this ratio the factor is 1 in f32, and a larger ratio has a larger factor.
    const LEAST_RATIO: f32 = 1e-20;
    let mut powers = [0.0; LANES];
    for lane in 0..LANES {
        powers[lane] = p[lane % BOUND_SHAPES].min(MOST_POWER) as f32;
    }
    let (mut bounds, mut growth) = ([0.0; LANES], [0.0; LANES]);
    for lane in 0..LANES {
        bounds[lane] = a[lane].max(b[lane]);
        let ratio = a[lane].min(b[lane]) / bounds[lane].max(f64::MIN_POSITIVE);
        growth[lane] = (ratio as f32).max(LEAST_RATIO);
    }
    for lane in 0..LANES {
        // 2^-100 vanishes beside 1.
        let power = exp2((powers[lane] * log2(growth[lane])).max(-100.0));
        growth[lane] = exp2(log2(1.0 + power) / powers[lane]);
    }
    for lane in 0..LANES {
        bounds[lane] = bounds[lane] * f64::from(growth[lane]) * EXCESS;
    }
    bounds
}

/// The largest relative excess of [`support_bounds`].
#[cfg(test)]
const BOUND_EXCESS: f64 = 1e-5;

/// The logarithm of a positive normal number, with an absolute error of a few 1e-7 of 1 and of the
/// result.
#[inline(always)]
fn log2(x: f32) -> f32 {
    // The exponent of x * sqrt(2), rounded down, so that the mantissa is in sqrt(1/2)..sqrt(2).
    const SQRT_HALF_BITS: u32 = 0x3f35_04f3;
    let exponent = (x.to_bits().wrapping_sub(SQRT_HALF_BITS) as i32) >> 23;
    let mantissa = f32::from_bits(x.to_bits().wrapping_sub((exponent << 23) as u32));
    // log2 m = 2/ln 2 artanh s.
    let s = (mantissa - 1.0) / (mantissa + 1.0);
    let square = s * s;
    let series = 1.0 + square * (1.0 / 3.0 + square * (1.0 / 5.0 + square * (1.0 / 7.0)));
    exponent as f32 + (2.0 * std::f32::consts::LOG2_E) * s * series
}

/// The power of two of a number in -126..=1, with a relative error of a few 1e-7.
#[inline(always)]
fn exp2(x: f32) -> f32 {
    /// Adding this rounds to an integer, which is in the lowest bits then.
    const ROUNDER: f32 = 1.5 * (1_u32 << 23) as f32;
    let rounded = x + ROUNDER;
    let f = (x - (rounded - ROUNDER)) * std::f32::consts::LN_2;
    // The series of e^f.
    let series = 1.0 / 24.0 + f * (1.0 / 120.0 + f * (1.0 / 720.0));
    let fraction = 1.0 + f * (1.0 + f * (0.5 + f * (1.0 / 6.0 + f * series)));
    fraction * f32::from_bits((rounded.to_bits() << 23).wrapping_add(1.0_f32.to_bits()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::random::SplitMix;

    #[test]
    fn bounds_of_the_support_hold_and_are_tight() {
        let mut random = SplitMix::new(3);
        let special = [0.0, 1e-9, 1e-4, 0.5, 1.0, 1.999_999, 2.0, 2.000_001, 4.0, 1e6];
        let mut exponent = || {
            if random.unit() < 0.3 {
                special[(random.unit() * 10.0) as usize]
            } else {
                10f64.powf(6.0 * random.unit() - 4.0)
            }
        };
        let exponents: Vec<(f64, f64)> = (0..4000).map(|_| (exponent(), exponent())).collect();
        for four in exponents.as_chunks().0 {
            let exponents = four.map(|(e, n)| Exponents::new(e, n).unwrap());
            let norms = exponents.map(NormForm::new);
            let mut component = || match (random.unit() * 8.0) as u32 {
                0 => 0.0,
                1 => 1.0,
                2 => 1.0 - 1e-9 * random.unit(),
                3 => 10f64.powf(600.0 * random.unit() - 300.0),
                _ => 2.0 * random.unit() - 1.0,
            };
            let columns = [(); BOUND_SHAPES]
                .map(|()| [(); 3].map(|()| DVec3::new(component(), component(), component())));
            let bounds = support_bounds(&exponents, columns.each_ref().map(<[DVec3; 3]>::each_ref));
            for (shape, norm) in norms.iter().enumerate() {
                for (index, bound) in bounds[shape].to_array().into_iter().enumerate() {
                    let direction = DVec3::from_array(columns[shape].map(|column| column[index]));
                    let exact = norm.support(direction);
                    assert!(
                        bound >= exact && bound <= exact * (1.0 + BOUND_EXCESS),
                        "{norm:?} {direction}: {bound} {exact}"
                    );
                }
                // Neighbours do not matter.
                let alone = support_bounds(
                    &[exponents[shape]; BOUND_SHAPES],
                    [columns[shape].each_ref(); BOUND_SHAPES],
                );
                assert_eq!(alone, [bounds[shape]; BOUND_SHAPES]);
            }
        }
    }
}
