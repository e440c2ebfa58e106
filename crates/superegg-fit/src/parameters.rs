//! The eleven numbers of a superquadric in space, and the steps between two such shapes.

use superegg_geom::glam::{DMat3, DQuat, DVec3};

/// The number of parameters.
pub(crate) const COUNT: usize = 11;
/// The index of the first exponent in a step.
pub(crate) const FIRST_EXPONENT: usize = 9;

/// A step from one shape to another: the centre along the shape's own axes, a rotation vector about
/// them in radians, the logarithms of the semi-axes, and the exponents e and n.
pub(crate) type Step = [f64; COUNT];

/// A superquadric in space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Parameters {
    pub(crate) center: DVec3,
    /// The directions of the shape's axes: a rotation.
    pub(crate) axes: DMat3,
    pub(crate) radii: DVec3,
    /// e and n.
    pub(crate) exponents: [f64; 2],
}

/// The range of both exponents.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Bounds {
    pub(crate) least: f64,
    pub(crate) most: f64,
}

impl Bounds {
    pub(crate) fn clamp(self, exponent: f64) -> f64 {
        exponent.clamp(self.least, self.most)
    }
}

/// The largest change of the logarithm of a semi-axis in one step.
const MOST_GROWTH: f64 = 0.4;
/// The largest rotation in one step, in radians.
const MOST_TURN: f64 = 0.5;
/// The largest change of an exponent in one step.
const MOST_BEND: f64 = 0.5;

impl Parameters {
    /// The shape after a step, which is shortened to what its linear model can be trusted for.
    pub(crate) fn after(&self, step: &Step, bounds: Bounds) -> Self {
        let vector = |from: usize| DVec3::new(step[from], step[from + 1], step[from + 2]);
        let limited = |v: DVec3, most: f64| v * (most / v.length()).min(1.0);
        let growth = vector(6).clamp(DVec3::splat(-MOST_GROWTH), DVec3::splat(MOST_GROWTH));
        let turn = limited(vector(3), MOST_TURN);
        let shift = limited(vector(0), 0.5 * self.radii.max_element());
        let exponent = |index: usize| {
            bounds.clamp(self.exponents[index] + step[FIRST_EXPONENT + index].clamp(-MOST_BEND, MOST_BEND))
        };
        let axes = self.axes * DMat3::from_quat(DQuat::from_scaled_axis(turn));
        Self {
            center: self.center + self.axes * shift,
            axes: orthonormal(&axes),
            radii: (self.radii * DVec3::from_array(growth.to_array().map(f64::exp)))
                .clamp(DVec3::splat(LEAST_RADIUS), DVec3::splat(MOST_RADIUS)),
            exponents: [exponent(0), exponent(1)],
        }
    }

    /// The shape with other exponents.
    pub(crate) fn with_exponents(&self, exponents: [f64; 2], bounds: Bounds) -> Self {
        Self { exponents: exponents.map(|exponent| bounds.clamp(exponent)), ..*self }
    }

    /// The geometric mean of the semi-axes.
    pub(crate) fn size(&self) -> f64 {
        self.radii.element_product().cbrt()
    }

    /// A rough surface area: that of the bounding box times a factor that is right for the box, the
    /// sphere and the octahedron.
    pub(crate) fn rough_area(&self) -> f64 {
        let DVec3 { x, y, z } = self.radii;
        8.0 * (x * y + y * z + z * x) * (-AREA_FALL * (self.exponents[0] + self.exponents[1])).exp()
    }

    /// The derivatives of the logarithm of [`Self::rough_area`].
    pub(crate) fn log_area_slopes(&self) -> Step {
        let DVec3 { x, y, z } = self.radii;
        let whole = x * y + y * z + z * x;
        let mut slopes = [0.0; COUNT];
        slopes[6] = x * (y + z) / whole;
        slopes[7] = y * (x + z) / whole;
        slopes[8] = z * (x + y) / whole;
        slopes[FIRST_EXPONENT] = -AREA_FALL;
        slopes[FIRST_EXPONENT + 1] = -AREA_FALL;
        slopes
    }
}

/// -d ln(area) / d(exponent).
const AREA_FALL: f64 = 0.3235;
/// The smallest and the largest semi-axis, where the points are at a distance of about 1 from their middle.
const LEAST_RADIUS: f64 = 1e-4;
const MOST_RADIUS: f64 = 1e2;

/// The rotation nearest to a matrix that rounding has bent.
fn orthonormal(axes: &DMat3) -> DMat3 {
    let x = axes.x_axis.normalize();
    let z = x.cross(axes.y_axis).normalize();
    DMat3::from_cols(x, z.cross(x), z)
}
