//! Ray against unit shape for e, n <= 2, where the norm form is convex.
//!
//! Along the ray `g(t) = N - 1` is convex. From a point before the shape, with g >= 0 and g' < 0,
//! Newton's method moves monotonically to the first root and cannot pass it. `g' >= 0` while `g >
//! 0` proves that there is no root. The exit is the first root of the reversed ray from the far
//! side of the box.

use glam::DVec3;

use crate::math::ray::RayStart;
use crate::norm::NormForm;
use crate::shape::ShapeHit;
use crate::solve::span::BoxSpan;

/// Convexity makes each step divide g g' by at least four, so 60 steps reach the last digit of a
/// double root.
const MAX_STEPS: u32 = 100;

/// The first crossing in unit space.
pub(crate) fn intersect(norm: &NormForm, span: &BoxSpan, start: RayStart) -> Option<ShapeHit> {
    solve(norm, span, start).map(|(hit, _)| hit)
}

/// The first crossing in unit space, and the number of Newton steps to it.
pub(crate) fn solve(norm: &NormForm, span: &BoxSpan, start: RayStart) -> Option<(ShapeHit, u32)> {
    let inside = match start {
        // A ray that leaves a convex shape does not hit it again.
        RayStart::SurfaceOutward => return None,
        RayStart::SurfaceInward => true,
        RayStart::Free => span.starts_inside_box && norm.value(span.origin) < 1.0,
    };
    let length = span.length;
    if inside {
        // A start inside has exactly one exit. If the reversed ray finds no root, the start and the
        // exit are on the surface within rounding.
        let back = first_root(norm, span.point_out, -span.direction, length);
        let (back, steps) = back.unwrap_or((length, 0));
        let point = span.point_out - back * span.direction;
        Some((ShapeHit { t: (span.t_out - back).max(0.0), point, leaving: true }, steps))
    } else {
        let (forth, steps) = first_root(norm, span.point_in, span.direction, length)?;
        let point = span.point_in + forth * span.direction;
        Some((ShapeHit { t: span.t_in + forth, point, leaving: false }, steps))
    }
}

/// The smallest s in 0..=length with N(from + s direction) = 1, from a point outside of the shape
/// or on it; and the number of Newton steps.
fn first_root(norm: &NormForm, from: DVec3, direction: DVec3, length: f64) -> Option<(f64, u32)> {
    let mut s = 0.0;
    for steps in 0..MAX_STEPS {
        let (value, gradient) = norm.value_and_gradient(from + s * direction);
        let above = value - 1.0;
        let slope = gradient.dot(direction);
        if above <= 0.0 && (slope < 0.0 || s > 0.0) {
            return Some((s, steps));
        }
        if slope >= 0.0 {
            return None;
        }
        let next = s - above / slope;
        if next > length * (1.0 + 4.0 * f64::EPSILON) {
            return None;
        }
        if next <= s {
            return Some((s, steps));
        }
        s = next;
    }
    Some((s, MAX_STEPS))
}
