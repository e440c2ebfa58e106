//! The part of a ray in the box of the unit shape, found to the last digits from any distance.

use glam::DVec3;

use crate::math::numeric::difference_of_products;

/// The part of the line `origin + t direction`, t >= 0, in the box [-1, 1]^3 (outside of it a unit
/// shape has no point). The points where it begins and ends are exact to rounding of their own
/// size, not of the distance to the origin: a crossing is computed as `(o_j d_k - o_k d_j + f d_j)
/// / d_k` with the products taken exactly.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BoxSpan {
    pub(crate) origin: DVec3,
    /// The direction; its largest component is in [1, 2).
    pub(crate) direction: DVec3,
    pub(crate) t_in: f64,
    pub(crate) point_in: DVec3,
    pub(crate) t_out: f64,
    pub(crate) point_out: DVec3,
    /// t from `point_in` to `point_out`: not `t_out - t_in`, which far away is nothing but
    /// rounding.
    pub(crate) length: f64,
    /// Whether the span begins at the ray's origin, which then lies in the box.
    pub(crate) starts_inside_box: bool,
}

/// How far outside of the box a crossing of a face may be computed and still count: the rounding of
/// the crossing.
const ON_FACE: f64 = 1.0 + 4.0 * f64::EPSILON;

impl BoxSpan {
    /// The span, or `None` where the ray misses the box. `origin` is finite, the largest component
    /// of `direction` in [1, 2).
    pub(crate) fn of(origin: DVec3, direction: DVec3) -> Option<Self> {
        let starts_inside_box = origin.abs().max_element() <= 1.0;
        let (t_out, point_out) = face_crossing(origin, direction, 1.0)?;
        if t_out < 0.0 {
            return None;
        }
        let (t_in, point_in) =
            if starts_inside_box { (0.0, origin) } else { face_crossing(origin, direction, -1.0)? };
        if t_in < 0.0 {
            return None;
        }
        let length = t_between(point_in, point_out, direction).max(0.0);
        let t_out = t_out.max(t_in);
        Some(Self { origin, direction, t_in, point_in, t_out, point_out, length, starts_inside_box })
    }
}

/// The t from one point of the line to another, measured where it moves most.
pub(crate) fn t_between(from: DVec3, to: DVec3, direction: DVec3) -> f64 {
    let axis = direction.abs().max_position();
    (to[axis] - from[axis]) / direction[axis]
}

/// Where the line crosses a face of the box whose outward normal points along the direction (`side`
/// = 1: the exit) or against it (-1: the entry).
fn face_crossing(origin: DVec3, direction: DVec3, side: f64) -> Option<(f64, DVec3)> {
    let mut found: Option<(f64, DVec3)> = None;
    for axis in 0..3 {
        let d = direction[axis];
        if d == 0.0 {
            if origin[axis].abs() > 1.0 {
                return None;
            }
            continue;
        }
        let face = side.copysign(side * d);
        let t = (face - origin[axis]) / d;
        // The line enters the box through the last of the three faces, and leaves it through the first.
        if found.is_none_or(|(best, _)| side * t < side * best) {
            let point = point_on_plane(origin, direction, axis, face);
            // Coordinates that overflowed to infinity or NaN are on no face.
            if t.is_finite() && point.abs().cmple(DVec3::splat(ON_FACE)).all() {
                found = Some((t, point.clamp(DVec3::NEG_ONE, DVec3::ONE)));
            }
        }
    }
    found
}

/// The point where the line crosses the plane on which coordinate `axis` is `value`.
pub(crate) fn point_on_plane(origin: DVec3, direction: DVec3, axis: usize, value: f64) -> DVec3 {
    let coordinate = |j: usize| {
        if j == axis {
            value
        } else if direction[j] == 0.0 {
            origin[j]
        } else {
            let moment = difference_of_products(origin[j], direction[axis], origin[axis], direction[j]);
            (moment + value * direction[j]) / direction[axis]
        }
    };
    DVec3::new(coordinate(0), coordinate(1), coordinate(2))
}
