//! The course text's method: Newton's method on `io` from the bounding sphere (sections 5.1.1 to
//! 5.1.4).
//!
//! It is the baseline of benchmarks and the method of lectures; the renderer does not use it. Its
//! failures are known: `io` and its gradient leave the range of f64 a few per cent outside of a
//! shape with small exponents, so at e = n = 0.0001 nearly every hit is lost; where g' changes sign
//! away from a minimum (shapes with e or n > 2) it takes hits for misses; and near a graze it
//! converges slowly.

use glam::DVec3;

use crate::math::ray::Ray;
use crate::shape::Exponents;

/// The answer of the textbook method and its cost.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TextbookAnswer {
    /// The `t` it found, or `None` for "no hit", which may be wrong.
    pub t: Option<f64>,
    /// The Newton steps it took.
    pub steps: u32,
}

/// How close to 0 `io` counts as the surface.
const CLOSE_ENOUGH: f64 = 1e-9;
const MAX_STEPS: u32 = 200;

/// `sq_io` as the course text prints it, for the unit shape.
pub fn inside_outside(v: DVec3, exponents: Exponents) -> f64 {
    let (e, n) = (exponents.e(), exponents.n());
    let s = v * v;
    (s.x.powf(1.0 / e) + s.y.powf(1.0 / e)).powf(e / n) + s.z.powf(1.0 / n) - 1.0
}

/// The gradient of `sq_io` as the course text prints it (its third row, missing there, is 2z
/// (z^2)^(1/n - 1) / n).
pub fn gradient(v: DVec3, exponents: Exponents) -> DVec3 {
    let (e, n) = (exponents.e(), exponents.n());
    let s = v * v;
    let around = (s.x.powf(1.0 / e) + s.y.powf(1.0 / e)).powf(e / n - 1.0);
    DVec3::new(
        2.0 * v.x * s.x.powf(1.0 / e - 1.0) * around / n,
        2.0 * v.y * s.y.powf(1.0 / e - 1.0) * around / n,
        2.0 * v.z * s.z.powf(1.0 / n - 1.0) / n,
    )
}

/// The ray, in the space of the unit shape, against the surface, as the course text does it.
pub fn intersect(ray: &Ray, exponents: Exponents) -> TextbookAnswer {
    let Some((near, far)) = bounding_sphere(ray) else {
        return TextbookAnswer { t: None, steps: 0 };
    };
    if far < 0.0 {
        return TextbookAnswer { t: None, steps: 0 };
    }
    let entry = newton(ray, exponents, near, 1.0);
    if near >= 0.0 {
        return entry;
    }
    // The start is within the sphere: both guesses are tried, and the smallest positive solution
    // counts.
    let exit = newton(ray, exponents, far, -1.0);
    let positive = |answer: TextbookAnswer| answer.t.filter(|&t| t >= 0.0);
    let t = match (positive(entry), positive(exit)) {
        (Some(a), Some(b)) => Some(a.min(b)),
        (a, b) => a.or(b),
    };
    TextbookAnswer { t, steps: entry.steps + exit.steps }
}

/// The intersection of the line with the sphere of radius sqrt 3: the quadratic of 5.1.2 with the
/// stable form of 5.1.3.
fn bounding_sphere(ray: &Ray) -> Option<(f64, f64)> {
    let a = ray.direction.dot(ray.direction);
    let b = 2.0 * ray.direction.dot(ray.origin);
    let c = ray.origin.dot(ray.origin) - 3.0;
    let discriminant = b * b - 4.0 * a * c;
    if discriminant < 0.0 {
        return None;
    }
    let sum = -b - discriminant.sqrt().copysign(b);
    let (t1, t2) = (sum / (2.0 * a), 2.0 * c / sum);
    Some((t1.min(t2), t1.max(t2)))
}

/// Newton's method along the ray from a guess; `towards` is 1 going forward and -1 going backward.
/// A slope of the wrong sign ends it: the surface has been missed.
fn newton(ray: &Ray, exponents: Exponents, guess: f64, towards: f64) -> TextbookAnswer {
    let mut t = guess;
    for steps in 0..MAX_STEPS {
        let point = ray.point_at(t);
        let value = inside_outside(point, exponents);
        if value.abs() <= CLOSE_ENOUGH {
            return TextbookAnswer { t: Some(t), steps };
        }
        let slope = ray.direction.dot(gradient(point, exponents));
        if slope == 0.0 || !slope.is_finite() || slope * towards > 0.0 {
            return TextbookAnswer { t: None, steps };
        }
        t -= value / slope;
    }
    TextbookAnswer { t: None, steps: MAX_STEPS }
}
