//! The points of a surface that are closest to given points: Newton's method, eight points at a time.

use superegg_simd::power::{exp2, log2};
use superegg_simd::{Arch, Simd, WithSimd};

use crate::parameters::Parameters;
use crate::rows::{Points, Row, WIDTH};

/// Steps from the point on the line to the centre.
const STEPS: usize = 5;
/// Coordinates below this part of a semi-axis count as this far from the plane.
const LEAST: f64 = 1e-12;

/// The closest points of a surface, and the signed distances there.
#[derive(Clone, Debug, Default)]
pub(crate) struct Projection {
    pub(crate) feet: Vec<[Row; 3]>,
    pub(crate) distances: Vec<Row>,
}

impl Projection {
    /// Projects points onto a surface. The closest point is sought from the one on the line to the
    /// centre, in the parameters of superegg-geom's arcs:
    ///
    /// ```text
    /// (a rho X, b rho Y, c zeta),  X = S(-t)^(e/2), Y = S(t)^(e/2), rho and zeta likewise with n and tau
    /// ```
    ///
    /// So points near the surface have their closest point; far inside or outside another one may be
    /// closer.
    pub(crate) fn set(&mut self, points: &Points, shape: &Parameters) {
        self.feet.resize(points.rows.len(), [[0.0; WIDTH]; 3]);
        self.distances.resize(points.rows.len(), [0.0; WIDTH]);
        Arch::new().dispatch(Kernel { points, shape: Prepared::of(shape), to: self });
    }
}

#[derive(Clone, Copy)]
struct Prepared {
    /// The shape's axes, one after the other.
    axes: [[f64; 3]; 3],
    center: [f64; 3],
    radii: [f64; 3],
    /// The arcs around and of the profile.
    arcs: [Arc; 2],
}

/// An arc of a superellipse.
#[derive(Clone, Copy)]
struct Arc {
    half_exponent: f64,
    power: f64,
}

impl Prepared {
    fn of(shape: &Parameters) -> Self {
        Self {
            axes: shape.axes.to_cols_array_2d(),
            center: shape.center.to_array(),
            radii: shape.radii.to_array(),
            arcs: shape.exponents.map(|w| Arc { half_exponent: 0.5 * w, power: 2.0 / w }),
        }
    }
}

struct Kernel<'a> {
    points: &'a Points,
    shape: Prepared,
    to: &'a mut Projection,
}

impl WithSimd for Kernel<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let outputs = self.to.feet.iter_mut().zip(&mut self.to.distances);
        for (row, (feet, distances)) in self.points.rows.iter().zip(outputs) {
            project(row, &self.shape, feet, distances);
        }
    }
}

/// A point of an arc, with its first and second derivatives by t.
#[derive(Clone, Copy)]
struct ArcPoint {
    x: f64,
    y: f64,
    x_t: f64,
    y_t: f64,
    x_tt: f64,
    y_tt: f64,
}

impl Arc {
    /// The point at t = `log_t` ln 2.
    #[inline(always)]
    fn at(self, log_t: f64) -> ArcPoint {
        let h = self.half_exponent;
        let decay = exp2::<false>(-log_t.abs());
        let larger = 1.0 / (1.0 + decay);
        let smaller = decay * larger;
        let (share, rest) = if log_t >= 0.0 { (larger, smaller) } else { (smaller, larger) };
        let tail = log2::<false>(1.0 + decay);
        let (above, below) = if log_t >= 0.0 { (log_t, 0.0) } else { (0.0, -log_t) };
        let x = exp2::<false>(-h * (above + tail));
        let y = exp2::<false>(-h * (below + tail));
        let x_t = -h * x * share;
        let y_t = h * y * rest;
        ArcPoint { x, y, x_t, y_t, x_tt: x_t * (rest - h * share), y_tt: y_t * (h * rest - share) }
    }
}

#[inline(always)]
fn project(row: &[Row; 3], shape: &Prepared, feet: &mut [Row; 3], distances: &mut Row) {
    let [a, b, c] = shape.radii;
    let [around, profile] = shape.arcs;
    let mut own = [[0.0; WIDTH]; 3];
    let mut size = [[0.0; WIDTH]; 3];
    let mut side = [0.0; WIDTH];
    let (mut t, mut tau) = ([0.0; WIDTH], [0.0; WIDTH]);
    for lane in 0..WIDTH {
        let x = row[0][lane] - shape.center[0];
        let y = row[1][lane] - shape.center[1];
        let z = row[2][lane] - shape.center[2];
        for axis in 0..3 {
            let [ux, uy, uz] = shape.axes[axis];
            own[axis][lane] = ux * x + uy * y + uz * z;
            size[axis][lane] = own[axis][lane].abs();
        }
        let at_least = |x: f64| if x > LEAST { x } else { LEAST };
        let log_x = log2::<false>(at_least(size[0][lane] / a));
        let log_y = log2::<false>(at_least(size[1][lane] / b));
        let log_z = log2::<false>(at_least(size[2][lane] / c));
        t[lane] = around.power * (log_y - log_x);
        let log_r = log_norm(log_x, log_y, around);
        tau[lane] = profile.power * (log_z - log_r);
        side[lane] = log_norm(log_r, log_z, profile);
    }
    let mut best = [f64::INFINITY; WIDTH];
    let mut damping = [0.0; WIDTH];
    let (mut step_t, mut step_tau) = ([0.0; WIDTH], [0.0; WIDTH]);
    let mut foot = [[0.0; WIDTH]; 3];
    // The derivatives at the best point: gradient and Hessian of half the squared distance.
    let mut slopes = [[0.0; WIDTH]; 5];
    let mut stiffness = [[0.0; WIDTH]; 2];
    for _ in 0..=STEPS {
        for lane in 0..WIDTH {
            let next_t = t[lane] + step_t[lane];
            let next_tau = tau[lane] + step_tau[lane];
            let (section, arc) = (around.at(next_t), profile.at(next_tau));
            let (x, y, z) = (a * arc.x * section.x, b * arc.x * section.y, c * arc.y);
            let (off_x, off_y, off_z) = (x - size[0][lane], y - size[1][lane], z - size[2][lane]);
            let square = off_x * off_x + off_y * off_y + off_z * off_z;
            let is_better = square < best[lane];
            let (t_x, t_y) = (a * arc.x * section.x_t, b * arc.x * section.y_t);
            let (tau_x, tau_y, tau_z) = (a * arc.x_t * section.x, b * arc.x_t * section.y, c * arc.y_t);
            let tt = t_x * t_x + t_y * t_y;
            let ss = tau_x * tau_x + tau_y * tau_y + tau_z * tau_z;
            let bend_tt = off_x * a * arc.x * section.x_tt + off_y * b * arc.x * section.y_tt;
            let bend_ts = off_x * a * arc.x_t * section.x_t + off_y * b * arc.x_t * section.y_t;
            let bend_ss =
                off_x * a * arc.x_tt * section.x + off_y * b * arc.x_tt * section.y + off_z * c * arc.y_tt;
            let found = [
                off_x * t_x + off_y * t_y,
                off_x * tau_x + off_y * tau_y + off_z * tau_z,
                tt + bend_tt,
                t_x * tau_x + t_y * tau_y + bend_ts,
                ss + bend_ss,
            ];
            for k in 0..5 {
                slopes[k][lane] = if is_better { found[k] } else { slopes[k][lane] };
            }
            stiffness[0][lane] = if is_better { tt + bend_tt.abs() } else { stiffness[0][lane] };
            stiffness[1][lane] = if is_better { ss + bend_ss.abs() } else { stiffness[1][lane] };
            foot[0][lane] = if is_better { x } else { foot[0][lane] };
            foot[1][lane] = if is_better { y } else { foot[1][lane] };
            foot[2][lane] = if is_better { z } else { foot[2][lane] };
            t[lane] = if is_better { next_t } else { t[lane] };
            tau[lane] = if is_better { next_tau } else { tau[lane] };
            best[lane] = if is_better { square } else { best[lane] };
            let harder = if damping[lane] * 10.0 > 1e-3 { damping[lane] * 10.0 } else { 1e-3 };
            damping[lane] = if is_better { 0.1 * damping[lane] } else { harder };
            let first = slopes[2][lane] + damping[lane] * stiffness[0][lane];
            let last = slopes[4][lane] + damping[lane] * stiffness[1][lane];
            let mixed = slopes[3][lane];
            let determinant = first * last - mixed * mixed;
            let is_convex = determinant > 0.0 && first > 0.0;
            let newton_t = (mixed * slopes[1][lane] - last * slopes[0][lane]) / determinant;
            let newton_tau = (mixed * slopes[0][lane] - first * slopes[1][lane]) / determinant;
            // Downhill in each parameter on its own, where the Hessian is not positive.
            let down_t = -slopes[0][lane] / (1e-300 + stiffness[0][lane] * (1.0 + damping[lane]));
            let down_tau = -slopes[1][lane] / (1e-300 + stiffness[1][lane] * (1.0 + damping[lane]));
            let to_log2 = std::f64::consts::LOG2_E;
            step_t[lane] = to_log2 * if is_convex { newton_t } else { down_t };
            step_tau[lane] = to_log2 * if is_convex { newton_tau } else { down_tau };
        }
    }
    for lane in 0..WIDTH {
        let length = best[lane].sqrt();
        distances[lane] = if side[lane] < 0.0 { -length } else { length };
        let mut point = [0.0; 3];
        for axis in 0..3 {
            point[axis] = foot[axis][lane].copysign(own[axis][lane]);
        }
        for axis in 0..3 {
            feet[axis][lane] = shape.center[axis]
                + shape.axes[0][axis] * point[0]
                + shape.axes[1][axis] * point[1]
                + shape.axes[2][axis] * point[2];
        }
    }
}

/// log2 of the power norm of two numbers, from their log2.
#[inline(always)]
fn log_norm(log_a: f64, log_b: f64, arc: Arc) -> f64 {
    let (larger, smaller) = if log_a >= log_b { (log_a, log_b) } else { (log_b, log_a) };
    larger + arc.half_exponent * log2::<false>(1.0 + exp2::<false>(arc.power * (smaller - larger)))
}

#[cfg(test)]
mod tests {
    use superegg_geom::glam::{DMat3, DVec3};
    use superegg_geom::{Exponents, SplitMix, Superquadric};

    use super::*;

    #[test]
    fn distances_near_the_surface_are_those_of_the_proven_search() {
        let mut random = SplitMix::new(4);
        let (mut exact_ones, mut count) = (0, 0);
        for trial in 0..40 {
            let exponents = [(); 2].map(|()| 0.1 + 1.9 * random.unit());
            let radii = DVec3::new(1.0, 1.0 + random.unit(), 1.0 + random.unit());
            let [e, n] = exponents;
            let shape = Superquadric::new(radii, Exponents::new(e, n).unwrap()).unwrap();
            let parameters = Parameters { center: DVec3::ZERO, axes: DMat3::IDENTITY, radii, exponents };
            let mut offset = || 0.05 * (2.0 * random.unit() - 1.0);
            let surface = shape.sample_surface(77, trial);
            let moved = surface.iter().map(|at| at.point + DVec3::new(offset(), offset(), offset()));
            let points: Vec<DVec3> = moved.collect();
            let mut projection = Projection::default();
            projection.set(&Points::new(&points), &parameters);
            for (index, &point) in points.iter().enumerate() {
                let expected = shape.closest_point(point).unwrap().distance;
                let found = projection.distances[index / WIDTH][index % WIDTH];
                let off = (found - expected).abs();
                assert!(off < 0.02 && found.abs() > expected.abs() - 1e-8, "{found} {expected}");
                exact_ones += usize::from(off < 1e-6);
                count += 1;
            }
        }
        assert!(exact_ones as f64 > 0.97 * f64::from(count), "{exact_ones} of {count}");
    }
}
