//! Ray against unit shape for any exponents, by isolating the first root with bounds.
//!
//! The ray is cut where it crosses x = 0, y = 0 and z = 0. On a piece |x|, |y|, |z| are linear, and
//! with
//!
//! ```text
//! R(x, y) = (|x|^p + |y|^p)^(1/p)    convex along the piece for p >= 1, concave for p <= 1,
//! C(z)    = (1 - |z|^q)^(1/q)        concave for q >= 1, convex for q <= 1,
//! ```
//!
//! `h = R - C` has the sign of `io`. Let `f = h` for a start outside and `f = -h` for a start
//! inside. The search finds the first t at which f falls below 0. f is a sum of two terms, each
//! convex or concave. On an interval a convex term lies above its tangents and a concave one above
//! its chord: a lower bound whose gap shrinks with the square of the width. Each term's derivative
//! is monotone, so its values at the ends bound it.
//!
//! An interval is discarded only on proof: the bound is above 0, or f does not decrease on it, or f
//! decreases and ends above 0. A root is accepted only where f decreases over the whole interval
//! and changes sign: it is the only root there, and every interval before it has been discarded.
//! All other intervals are halved, down to the spacing of f64.
//!
//! Near the coordinate planes f has a cusp where p or q < 1, and crossings may lie 1e-20 from the
//! cut. Each half of a piece therefore measures from the cut at its own end, where the crossing
//! coordinate is exactly 0 and the others are exact to rounding.

use glam::DVec3;

use crate::math::numeric::difference_of_products;
use crate::math::ray::RayStart;
use crate::norm::{NormForm, PowerNorm};
use crate::shape::ShapeHit;
use crate::solve::span::{BoxSpan, point_on_plane, t_between};

/// The most intervals that are examined for one half piece. Hostile rays need some hundreds.
const MAX_INTERVALS: usize = 20_000;

/// The first crossing in unit space.
pub(crate) fn intersect(norm: &NormForm, span: &BoxSpan, start: RayStart) -> Option<ShapeHit> {
    let inside = match start {
        RayStart::SurfaceOutward => false,
        RayStart::SurfaceInward => true,
        RayStart::Free => span.starts_inside_box && norm.value(span.origin) < 1.0,
    };
    let function = Function::new(norm, inside);
    let cuts = Cuts::of(span);
    for (from, to) in cuts.pieces() {
        if !inside && function.is_outside_hull(from.point, to.point) {
            continue;
        }
        let half_length = 0.5 * cuts.gap(from, to);
        if half_length.is_nan() || half_length <= 0.0 {
            continue;
        }
        let quadrant = from.point + to.point;
        for (anchor, time_sign) in [(from, 1.0), (to, -1.0)] {
            let half = HalfPiece::new(anchor, quadrant, span.direction * time_sign, half_length);
            if let Some(s) = function.first_fall(&half, time_sign > 0.0) {
                return Some(ShapeHit {
                    t: (anchor.t + time_sign * s).max(0.0),
                    point: half.point_at(s),
                    leaving: inside,
                });
            }
        }
    }
    // A ray that starts inside leaves the shape, at the latest with the box: rounding may have
    // hidden the crossing.
    inside.then_some(ShapeHit { t: span.t_out, point: span.point_out, leaving: true })
}

/// An end of a piece.
#[derive(Clone, Copy, Debug)]
struct Cut {
    t: f64,
    point: DVec3,
    /// The coordinate that is 0 here, if the cut is a crossing of its plane.
    axis: Option<usize>,
}

/// The ends of the pieces in order: where the ray's span begins, crosses a coordinate plane, and
/// ends.
struct Cuts {
    origin: DVec3,
    direction: DVec3,
    cuts: [Cut; 5],
    count: usize,
}

impl Cuts {
    fn of(span: &BoxSpan) -> Self {
        let end = |t, point| Cut { t, point, axis: None };
        let mut cuts = [end(span.t_in, span.point_in); 5];
        let mut count = 1;
        for axis in 0..3 {
            let d = span.direction[axis];
            // The signs at both ends are exact, a comparison of t is not.
            if d == 0.0 || span.point_in[axis] * d >= 0.0 || span.point_out[axis] * d <= 0.0 {
                continue;
            }
            let t = (-span.origin[axis] / d).clamp(span.t_in, span.t_out);
            let point = point_on_plane(span.origin, span.direction, axis, 0.0);
            cuts[count] = Cut { t, point, axis: Some(axis) };
            count += 1;
        }
        cuts[count] = end(span.t_out, span.point_out);
        count += 1;
        let mut this = Self { origin: span.origin, direction: span.direction, cuts, count };
        this.sort_crossings();
        this
    }

    /// Insertion sort of at most three crossings by their exact order.
    fn sort_crossings(&mut self) {
        for i in 2..self.count - 1 {
            let mut j = i;
            while j > 1 && self.signed_gap(&self.cuts[j - 1], &self.cuts[j]) < 0.0 {
                self.cuts.swap(j - 1, j);
                j -= 1;
            }
        }
    }

    fn pieces(&self) -> impl Iterator<Item = (&Cut, &Cut)> {
        self.cuts[..self.count].windows(2).map(|pair| (&pair[0], &pair[1]))
    }

    /// The length of t from one cut to a later one, exact to rounding between two crossings however
    /// close they are.
    fn gap(&self, from: &Cut, to: &Cut) -> f64 {
        self.signed_gap(from, to).max(0.0)
    }

    fn signed_gap(&self, from: &Cut, to: &Cut) -> f64 {
        let (o, d) = (self.origin, self.direction);
        match (from.axis, to.axis) {
            (Some(j), Some(k)) => difference_of_products(o[j], d[k], o[k], d[j]) / d[j] / d[k],
            _ => t_between(from.point, to.point, d),
        }
    }
}

/// A coordinate's magnitude along half a piece: `at_anchor + slope s`, both >= 0 in effect for s in
/// the half piece.
#[derive(Clone, Copy, Debug)]
struct Magnitude {
    at_anchor: f64,
    slope: f64,
    sign: f64,
}

impl Magnitude {
    fn at(&self, s: f64) -> f64 {
        (self.at_anchor + self.slope * s).max(0.0)
    }
}

/// Half of a piece, measured from the cut at its end: s in 0..=length.
#[derive(Debug)]
struct HalfPiece {
    x: Magnitude,
    y: Magnitude,
    z: Magnitude,
    length: f64,
}

impl HalfPiece {
    /// `quadrant` has the signs of the coordinates within the piece, `direction` leads from the
    /// anchor into the half piece.
    fn new(anchor: &Cut, quadrant: DVec3, direction: DVec3, length: f64) -> Self {
        let magnitude = |axis: usize| {
            let sign = if quadrant[axis] < 0.0 { -1.0 } else { 1.0 };
            Magnitude { at_anchor: (sign * anchor.point[axis]).max(0.0), slope: sign * direction[axis], sign }
        };
        Self { x: magnitude(0), y: magnitude(1), z: magnitude(2), length }
    }

    fn point_at(&self, s: f64) -> DVec3 {
        DVec3::new(self.x.sign * self.x.at(s), self.y.sign * self.y.at(s), self.z.sign * self.z.at(s))
    }
}

/// A term's value and its derivative by s at one s. The derivative may be infinite at an end of a
/// piece.
#[derive(Clone, Copy, Debug)]
struct Term {
    value: f64,
    derivative: f64,
}

/// The two terms of f at one s.
#[derive(Clone, Copy, Debug)]
struct Sample {
    s: f64,
    r_term: Term,
    c_term: Term,
}

impl Sample {
    fn f(&self) -> f64 {
        self.r_term.value + self.c_term.value
    }

    fn derivative(&self) -> f64 {
        self.r_term.derivative + self.c_term.derivative
    }
}

/// The result of examining an interval.
enum Finding {
    /// f does not fall below 0 on it.
    Nothing,
    /// f falls below 0 first at this s.
    Fall(f64),
    /// Undecided: cut the interval here.
    Unknown(f64),
}

/// `f = sign (R - C)` as a sum of two terms of known curvature.
#[derive(Debug)]
struct Function {
    xy: PowerNorm,
    q: f64,
    sign: f64,
    r_term_is_convex: bool,
    c_term_is_convex: bool,
}

impl Function {
    /// f of rays that start inside, or outside.
    fn new(norm: &NormForm, inside: bool) -> Self {
        Self {
            xy: norm.xy,
            q: norm.rz.p,
            sign: if inside { -1.0 } else { 1.0 },
            r_term_is_convex: (norm.xy.p >= 1.0) != inside,
            c_term_is_convex: (norm.rz.p >= 1.0) != inside,
        }
    }

    fn sample(&self, half: &HalfPiece, s: f64) -> Sample {
        let radial = self.radial(half, s);
        let profile = self.profile(half.z.at(s), half.z.slope);
        Sample {
            s,
            r_term: Term { value: self.sign * radial.value, derivative: self.sign * radial.derivative },
            c_term: Term { value: -self.sign * profile.value, derivative: -self.sign * profile.derivative },
        }
    }

    /// R and dR/ds.
    fn radial(&self, half: &HalfPiece, s: f64) -> Term {
        let (x, y) = (half.x.at(s), half.y.at(s));
        if x == 0.0 && y == 0.0 {
            // On the z axis R is the norm of the displacement from it.
            return Term { value: 0.0, derivative: self.xy.value(half.x.slope.abs(), half.y.slope.abs()) };
        }
        let (value, by_x, by_y) = self.xy.value_and_gradient(x, y);
        let derivative = chain(by_x, half.x.slope) + chain(by_y, half.y.slope);
        Term { value, derivative }
    }

    /// C and dC/ds at |z| = z.
    fn profile(&self, z: f64, slope: f64) -> Term {
        let q = self.q;
        let z = z.min(1.0);
        let below = -(q * z.ln()).exp_m1(); // 1 - z^q
        let value = below.powf(1.0 / q);
        let by_value = if below > 0.0 { value / below } else { 0f64.powf(1.0 / q - 1.0) };
        let by_power = if z > 0.0 { (1.0 - below) / z } else { 0f64.powf(q - 1.0) };
        let steepness = if by_power == 0.0 || by_value == 0.0 { 0.0 } else { by_power * by_value };
        Term { value, derivative: chain(-steepness, slope) }
    }

    /// Whether the piece between two cuts lies outside of a hull of the shape. For p <= 1,
    /// `R >= |x| + |y|`, and for q <= 1, `N >= R + |z|`. These sums are linear along a piece, so a
    /// piece with one of them >= 1 at both ends does not intersect the shape.
    fn is_outside_hull(&self, from: DVec3, to: DVec3) -> bool {
        let (from, to) = (from.abs(), to.abs());
        let exceeds = |sum: fn(DVec3) -> f64| sum(from) >= 1.0 && sum(to) >= 1.0;
        match (self.xy.p <= 1.0, self.q <= 1.0) {
            (true, true) => exceeds(|v| v.x + v.y + v.z),
            (true, false) => exceeds(|v| v.x + v.y),
            (false, true) => exceeds(|v| v.x + v.z) || exceeds(|v| v.y + v.z),
            (false, false) => false,
        }
    }

    /// The first s in time at which f falls below 0. `None` is proved.
    fn first_fall(&self, half: &HalfPiece, forward: bool) -> Option<f64> {
        let mut pending = Vec::new();
        let mut next = Some((self.sample(half, 0.0), self.sample(half, half.length)));
        for _ in 0..MAX_INTERVALS {
            let (low, high) = next.take().or_else(|| pending.pop())?;
            match self.look_at(half, &low, &high, forward) {
                Finding::Nothing => {}
                Finding::Fall(s) => return Some(s),
                Finding::Unknown(middle) => {
                    let middle = self.sample(half, middle);
                    let (sooner, later) = ((low, middle), (middle, high));
                    let (sooner, later) = if forward { (sooner, later) } else { (later, sooner) };
                    pending.push(later);
                    next = Some(sooner);
                }
            }
        }
        None
    }

    /// Examines one interval.
    fn look_at(&self, half: &HalfPiece, low: &Sample, high: &Sample, forward: bool) -> Finding {
        let (first, last) = if forward { (low, high) } else { (high, low) };
        let (least, greatest) = self.derivative_range(low, high, forward);
        if least >= 0.0 {
            return Finding::Nothing;
        }
        if greatest <= 0.0 {
            return if first.f() <= 0.0 {
                Finding::Fall(first.s)
            } else if last.f() < 0.0 {
                Finding::Fall(self.root_between(half, *low, *high))
            } else {
                Finding::Nothing
            };
        }
        // Far beyond any exponent of use R itself overflows; a concave term with infinite ends is
        // infinite.
        if self.lower_bound(low, high) > 0.0 || low.f().min(high.f()) == f64::INFINITY {
            return Finding::Nothing;
        }
        match split(low.s, high.s, half.length) {
            Some(middle) => Finding::Unknown(middle),
            None if last.f() < 0.0 => Finding::Fall(last.s),
            None => Finding::Nothing,
        }
    }

    /// Bounds of df/dt in time over an interval: each term's derivative is monotone, so its range
    /// is that of its ends.
    fn derivative_range(&self, low: &Sample, high: &Sample, forward: bool) -> (f64, f64) {
        let range = |low: f64, high: f64, is_convex: bool| if is_convex { (low, high) } else { (high, low) };
        let r = range(low.r_term.derivative, high.r_term.derivative, self.r_term_is_convex);
        let c = range(low.c_term.derivative, high.c_term.derivative, self.c_term_is_convex);
        let (least, greatest) = (r.0 + c.0, r.1 + c.1);
        if forward { (least, greatest) } else { (-greatest, -least) }
    }

    /// A number that f does not go below on the interval, or NaN where infinite slopes leave none.
    fn lower_bound(&self, low: &Sample, high: &Sample) -> f64 {
        let width = high.s - low.s;
        let (mut at_low, mut at_high) = (0.0, 0.0);
        let mut tangent_low = Term { value: 0.0, derivative: 0.0 };
        let mut tangent_high = tangent_low;
        for (a, b, is_convex) in [
            (&low.r_term, &high.r_term, self.r_term_is_convex),
            (&low.c_term, &high.c_term, self.c_term_is_convex),
        ] {
            if is_convex {
                tangent_low.value += a.value;
                tangent_low.derivative += a.derivative;
                tangent_high.value += b.value;
                tangent_high.derivative += b.derivative;
            } else {
                at_low += a.value;
                at_high += b.value;
            }
        }
        // The chord of the concave terms plus a tangent of the convex ones is a line; f is above
        // both such lines.
        let chord = (at_high - at_low) / width;
        let line_low = (at_low + tangent_low.value, chord + tangent_low.derivative);
        let line_high = (at_high + tangent_high.value, chord + tangent_high.derivative);
        least_of_upper_envelope(line_low, line_high, width)
    }

    /// The root in an interval over which f is monotone and changes sign: Newton's method kept
    /// within the bracket.
    fn root_between(&self, half: &HalfPiece, low: Sample, high: Sample) -> f64 {
        let rises = low.f() < 0.0;
        let (mut low_s, mut high_s) = (low.s, high.s);
        let mut at = if low.derivative().is_finite() { low } else { high };
        let mut last_step = f64::INFINITY;
        for _ in 0..200 {
            let newton = at.s - at.f() / at.derivative();
            let step = (newton - at.s).abs();
            if step <= f64::EPSILON * at.s && at.derivative().is_finite() {
                return at.s;
            }
            let next = if newton > low_s && newton < high_s && step < 0.5 * last_step {
                last_step = step;
                newton
            } else {
                last_step = f64::INFINITY;
                match split(low_s, high_s, half.length) {
                    Some(middle) => middle,
                    None => return high_s,
                }
            };
            at = self.sample(half, next);
            if (at.f() < 0.0) == rises {
                low_s = next;
            } else {
                high_s = next;
            }
        }
        at.s
    }
}

/// `derivative * slope`, where a coordinate that does not change contributes nothing, however steep
/// the function is.
fn chain(derivative: f64, slope: f64) -> f64 {
    if slope == 0.0 { 0.0 } else { derivative * slope }
}

/// The least value over 0..=width of the larger of two lines, the first given by value and slope at
/// 0, the second at `width`; a line with an infinite slope does not count. NaN where neither does.
fn least_of_upper_envelope(low: (f64, f64), high: (f64, f64), width: f64) -> f64 {
    let low_at_width = low.0 + low.1 * width;
    let high_at_zero = high.0 - high.1 * width;
    match (low.1.is_finite(), high.1.is_finite()) {
        (false, false) => f64::NAN,
        (true, false) => low.0.min(low_at_width),
        (false, true) => high.0.min(high_at_zero),
        (true, true) => {
            let at_zero = low.0.max(high_at_zero);
            let at_width = high.0.max(low_at_width);
            if low.1 < 0.0 && high.1 > 0.0 {
                // The lines fall and rise: the least is where they meet.
                let meeting = ((high_at_zero - low.0) / (low.1 - high.1)).clamp(0.0, width);
                at_zero.min(at_width).min(low.0 + low.1 * meeting)
            } else {
                at_zero.min(at_width)
            }
        }
    }
}

/// The s at which to cut an interval: near the anchor, where f may have a cusp, in ratios; else the
/// middle. `None` if the interval is at the spacing of f64.
fn split(low: f64, high: f64, length: f64) -> Option<f64> {
    if low == 0.0 {
        return (high > 1e-30 * length).then_some(high / 16.0);
    }
    let middle = if high > 4.0 * low { (low * high).sqrt() } else { 0.5 * (low + high) };
    (high - low > 4.0 * f64::EPSILON * high && middle > low && middle < high).then_some(middle)
}
