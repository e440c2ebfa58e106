//! A convex shape in the form that packets intersect.

use superegg_simd::{Lanes, Linear, Mask, Simd, Triple};

use super::super::norm::{BOX, TINY};
use super::super::powers::{PowerKind, lane_power};
use crate::superquadric::Convex;

/// A convex shape as the rays of a packet see it.
#[derive(Clone, Copy, Debug)]
pub struct PacketShape {
    /// The linear map from the packet's directions to the unit shape's space, by columns.
    pub columns: [[f32; 3]; 3],
    /// The packet's origin in the unit shape's space.
    pub origin: [f32; 3],
    /// Bound on the error of N at a point on a ray, from the rounding of maps and directions.
    pub tolerance: f32,
    /// Converts t in this space to the packet's t.
    pub t_scale: f32,
    pub(super) xy: PowerKind,
    pub(super) rz: PowerKind,
    /// Upper bound on the distance of a point of the shape from its centre.
    reach: f32,
}

impl PacketShape {
    /// The form of a shape.
    pub fn new(
        shape: &Convex,
        columns: [[f32; 3]; 3],
        origin: [f32; 3],
        tolerance: f32,
        t_scale: f32,
    ) -> Self {
        let norm = shape.norm();
        Self {
            columns,
            origin,
            tolerance,
            t_scale,
            xy: PowerKind::of(norm.xy.p),
            rz: PowerKind::of(norm.rz.p),
            reach: reach(lane_power(norm.xy.p), lane_power(norm.rz.p)),
        }
    }
}

/// Upper bound on the distance of a point of the unit shape from its centre, at most 5 % too large. For p, q >= 2 Hölder's
/// inequality gives `x^2 + y^2 <= 2^(1 - 2/p) R^2` and `r^2 + z^2 <= |(r^2, 1)|` in the norm dual to q/2; each power is below
/// its chord.
fn reach(p: f32, q: f32) -> f32 {
    let beyond = |p: f32| (1.0 - 2.0 / p).max(0.0);
    1.0001 * (1.0 + beyond(p) + beyond(q)).sqrt()
}

/// The rays of a register inside the box of a shape.
#[derive(Clone, Copy)]
pub(super) struct BoxSpan<S: Simd> {
    /// The t where each enters and leaves the box, in the shape's space.
    pub(super) near: Lanes<S>,
    pub(super) far: Lanes<S>,
    /// In the shape's space.
    pub(super) direction: Triple<S>,
    pub(super) active: Mask<S>,
}

/// The data that all rays against one shape share, in registers.
#[derive(Clone, Copy)]
pub(super) struct PreparedShape<S: Simd> {
    pub(super) map: Linear<S>,
    pub(super) origin: Triple<S>,
    /// The lower and upper faces of the box, relative to the origin.
    lower: Triple<S>,
    upper: Triple<S>,
    reach_squared: Lanes<S>,
    pub(super) t_scale: Lanes<S>,
    pub(super) inv_t_scale: Lanes<S>,
}

impl<S: Simd> PreparedShape<S> {
    #[inline(always)]
    pub(super) fn new(simd: S, shape: &PacketShape) -> Self {
        let splat = |x: f32| Lanes::<S>::splat(simd, x);
        let [x, y, z] = shape.origin;
        let half = BOX + shape.tolerance;
        let reach = shape.reach + 2.0 * shape.tolerance;
        Self {
            map: Linear::splat(simd, &shape.columns),
            origin: Triple::splat(simd, [x, y, z]),
            lower: Triple::splat(simd, [-half - x, -half - y, -half - z]),
            upper: Triple::splat(simd, [half - x, half - y, half - z]),
            reach_squared: splat(1.000_01 * reach * reach),
            t_scale: splat(shape.t_scale),
            inv_t_scale: splat(1.0 / shape.t_scale),
        }
    }

    /// The rays that pass through the bounding sphere and the box of the shape before `end`; `None` where no ray does.
    #[inline(always)]
    pub(super) fn box_span(&self, v: Triple<S>, end: impl FnOnce() -> Lanes<S>) -> Option<BoxSpan<S>> {
        let (o, d) = (self.origin, self.map.image(v));
        // The distance of a line from the centre is |o x d| / |d|.
        let cross = Triple { x: o.y * d.z - o.z * d.y, y: o.z * d.x - o.x * d.z, z: o.x * d.y - o.y * d.x };
        let square = d.dot(d);
        let room = self.reach_squared * square - cross.dot(cross);
        let zero = square.all(0.0);
        let is_near = zero.le(room);
        if !is_near.any() {
            return None;
        }
        let inverse = square.max(square.all(TINY)).recip();
        let (middle, half) = (-o.dot(d) * inverse, room.max(zero).sqrt() * inverse);
        let (mut near, mut far) = ((middle - half).max(zero), end().min(middle + half));
        for (lower, upper, inverse) in [
            (self.lower.x, self.upper.x, recip(d.x)),
            (self.lower.y, self.upper.y, recip(d.y)),
            (self.lower.z, self.upper.z, recip(d.z)),
        ] {
            let (a, b) = (lower * inverse, upper * inverse);
            near = near.max(a.min(b));
            far = far.min(a.max(b));
        }
        let active = is_near & near.le(far);
        active.any().then_some(BoxSpan { near, far, direction: d, active })
    }
}

/// 1 / x; a large number where x is 0.
#[inline(always)]
pub(super) fn recip<S: Simd>(x: Lanes<S>) -> Lanes<S> {
    x.abs().max(x.all(TINY)).with_sign_of(x).recip()
}
