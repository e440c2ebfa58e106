//! The distances of points to the tangent planes of a shape, and their derivatives.

use std::f64::consts::LN_2;

use superegg_simd::power::{exp2, log2};
use superegg_simd::{Arch, Simd, WithSimd};

use crate::parameters::{COUNT, Parameters};
use crate::rows::{Row, WIDTH};

/// Distances of points to a shape, and their derivatives by its parameters.
#[derive(Clone, Debug, Default)]
pub(crate) struct Linearization {
    pub(crate) distances: Vec<Row>,
    pub(crate) slopes: Vec<[Row; COUNT]>,
}

impl Linearization {
    /// The signed distance of each point to the plane that touches the surface where the line from
    /// the centre to the point meets it, and its derivatives by the parameters, exact on the surface:
    ///
    /// ```text
    /// d = (1 - 1/N) / |G|,   G = grad ln N
    /// ```
    ///
    /// with the norm form N. Outside of a convex shape d is not above the true distance, near its
    /// surface it differs in second order. With s_k, the share of coordinate k in N (they add up to
    /// 1), G_k = s_k / x_k, and the derivatives of ln N are -G by the centre, -x cross G by the
    /// rotation, and -s_k by the logarithms of the semi-axes.
    pub(crate) fn set(&mut self, points: &[[Row; 3]], shape: &Parameters) {
        self.distances.resize(points.len(), [0.0; WIDTH]);
        self.slopes.resize(points.len(), [[0.0; WIDTH]; COUNT]);
        Arch::new().dispatch(Kernel { points, shape: Prepared::of(shape), to: self });
    }
}

/// Coordinates below this part of a semi-axis count as this far from the plane.
const LEAST: f64 = 1e-12;

/// A shape prepared for many points.
#[derive(Clone, Copy)]
struct Prepared {
    /// The shape's axes, one after the other.
    axes: [[f64; 3]; 3],
    center: [f64; 3],
    inverse_radii: [f64; 3],
    /// p and q, and their reciprocals.
    powers: [(f64, f64); 2],
}

impl Prepared {
    fn of(shape: &Parameters) -> Self {
        Self {
            axes: shape.axes.to_cols_array_2d(),
            center: shape.center.to_array(),
            inverse_radii: shape.radii.recip().to_array(),
            powers: shape.exponents.map(|exponent| (2.0 / exponent, 0.5 * exponent)),
        }
    }
}

struct Kernel<'a> {
    points: &'a [[Row; 3]],
    shape: Prepared,
    to: &'a mut Linearization,
}

impl WithSimd for Kernel<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let outputs = self.to.distances.iter_mut().zip(&mut self.to.slopes);
        for (row, (distances, slopes)) in self.points.iter().zip(outputs) {
            if S::IS_SCALAR {
                linearize::<false>(row, &self.shape, distances, slopes);
            } else {
                linearize::<true>(row, &self.shape, distances, slopes);
            }
        }
    }
}

#[inline(always)]
fn linearize<const FUSED: bool>(
    row: &[Row; 3],
    shape: &Prepared,
    distances: &mut Row,
    slopes: &mut [Row; COUNT],
) {
    let [ax, ay, az] = shape.axes;
    let [ix, iy, iz] = shape.inverse_radii;
    for lane in 0..WIDTH {
        let x = row[0][lane] - shape.center[0];
        let y = row[1][lane] - shape.center[1];
        let z = row[2][lane] - shape.center[2];
        let (own_x, own_y, own_z) = (
            ax[0] * x + ax[1] * y + ax[2] * z,
            ay[0] * x + ay[1] * y + ay[2] * z,
            az[0] * x + az[1] * y + az[2] * z,
        );
        let (unit_x, unit_y, unit_z) =
            (at_least((own_x * ix).abs()), at_least((own_y * iy).abs()), at_least((own_z * iz).abs()));
        let (log_x, log_y, log_z) = (log2::<FUSED>(unit_x), log2::<FUSED>(unit_y), log2::<FUSED>(unit_z));
        let around = join::<FUSED>(log_x, log_y, shape.powers[0]);
        let profile = join::<FUSED>(around.log, log_z, shape.powers[1]);
        let (share_x, share_y, share_z) =
            (profile.of_a * around.of_a, profile.of_a * around.of_b, profile.of_b);
        let slope_x = (share_x / unit_x * ix).copysign(own_x);
        let slope_y = (share_y / unit_y * iy).copysign(own_y);
        let slope_z = (share_z / unit_z * iz).copysign(own_z);
        let inverse_length = 1.0 / (slope_x * slope_x + slope_y * slope_y + slope_z * slope_z).sqrt();
        let inverse_norm = exp2::<FUSED>(-profile.log);
        distances[lane] = (1.0 - inverse_norm) * inverse_length;
        let scale = inverse_norm * inverse_length;
        slopes[0][lane] = -slope_x * scale;
        slopes[1][lane] = -slope_y * scale;
        slopes[2][lane] = -slope_z * scale;
        slopes[3][lane] = (own_z * slope_y - own_y * slope_z) * scale;
        slopes[4][lane] = (own_x * slope_z - own_z * slope_x) * scale;
        slopes[5][lane] = (own_y * slope_x - own_x * slope_y) * scale;
        slopes[6][lane] = -share_x * scale;
        slopes[7][lane] = -share_y * scale;
        slopes[8][lane] = -share_z * scale;
        slopes[9][lane] = profile.of_a * around.by_exponent * scale;
        slopes[10][lane] = profile.by_exponent * scale;
    }
}

#[inline(always)]
fn at_least(x: f64) -> f64 {
    if x > LEAST { x } else { LEAST }
}

/// The power norm of two numbers, with derivatives of its logarithm.
struct Joined {
    /// log2 of the norm.
    log: f64,
    /// The shares of the two numbers.
    of_a: f64,
    of_b: f64,
    /// The derivative of the natural logarithm of the norm by w, where p = 2/w.
    by_exponent: f64,
}

/// `(a^p + b^p)^(1/p)`, from log2 a and log2 b.
#[inline(always)]
fn join<const FUSED: bool>(log_a: f64, log_b: f64, (p, inverse_p): (f64, f64)) -> Joined {
    let is_first = log_a >= log_b;
    let (larger, smaller) = if is_first { (log_a, log_b) } else { (log_b, log_a) };
    let log_power = p * (smaller - larger);
    let power = exp2::<FUSED>(log_power);
    let sum = 1.0 + power;
    let log_sum = log2::<FUSED>(sum);
    let of_larger = 1.0 / sum;
    let of_smaller = power * of_larger;
    Joined {
        log: larger + log_sum * inverse_p,
        of_a: if is_first { of_larger } else { of_smaller },
        of_b: if is_first { of_smaller } else { of_larger },
        by_exponent: 0.5 * LN_2 * (log_sum - of_smaller * log_power),
    }
}

#[cfg(test)]
mod tests {
    use superegg_geom::SplitMix;
    use superegg_geom::glam::{DMat3, DQuat, DVec3};

    use super::*;
    use crate::parameters::{Bounds, Step};
    use crate::rows::Points;

    #[test]
    fn slopes_on_the_surface_are_those_of_finite_differences() {
        let mut random = SplitMix::new(2);
        let bounds = Bounds { least: 0.01, most: 8.0 };
        for _ in 0..200 {
            let mut unit = || random.unit();
            let turn = DQuat::from_xyzw(unit() - 0.5, unit() - 0.5, unit() - 0.5, unit()).normalize();
            let shape = Parameters {
                center: DVec3::new(unit(), unit(), unit()),
                axes: DMat3::from_quat(turn),
                radii: DVec3::new(0.5 + unit(), 0.5 + unit(), 0.5 + unit()),
                exponents: [0.2 + 1.8 * unit(), 0.2 + 1.8 * unit()],
            };
            // A point on the surface: along any direction, by the distance in the norm form.
            let direction = DVec3::new(unit() - 0.5, unit() - 0.5, unit() - 0.5);
            let own = shape.axes.transpose() * direction / shape.radii;
            let exponents = superegg_geom::Exponents::new(shape.exponents[0], shape.exponents[1]).unwrap();
            let norm = superegg_geom::NormForm::new(exponents).value(own);
            let points = Points::new(&[shape.center + direction / norm]);
            let distance = |shape: &Parameters| {
                let mut found = Linearization::default();
                found.set(&points.rows, shape);
                (found.distances[0][0], found.slopes[0].map(|row| row[0]))
            };
            let (on_surface, slopes) = distance(&shape);
            assert!(on_surface.abs() < 1e-13);
            for (index, slope) in slopes.iter().enumerate() {
                let moved = |by: f64| {
                    let mut step: Step = [0.0; COUNT];
                    step[index] = by;
                    distance(&shape.after(&step, bounds)).0
                };
                let expected = (moved(1e-6) - moved(-1e-6)) / 2e-6;
                assert!((slope - expected).abs() < 1e-6, "{index}: {slope} {expected} {shape:?}");
            }
        }
    }
}
