//! Newton's method along rays that go through the box of a convex shape, several registers at a time: the steps of one depend on each other, those
//! of another fill the time between.

use pulp::Simd;

use super::PowerKind;
use super::kernel::{CLOSE, Descent, Evaluate, Pair, Square, Sum, Triple};
use super::log_norm::{AnyPower, LogNorm, Round};
use super::vector::{Lanes, Mask};

/// Steps before what is left goes to f64: grazing rays.
const MOST_STEPS: usize = 10;
/// From where N is above the level by no more than this the last step is taken unseen.
const NEAR: f32 = 3e-5;
/// The last step is off by less than this part of itself, or f64 will find that it is not.
const LAST_STEP: f32 = 1.0 / 16.0;

/// Work that needs to know the norm of a shape.
pub(super) trait WithNorm<S: Simd> {
    type Output;
    fn run(self, norm: impl Evaluate<S>) -> Self::Output;
}

/// Does work for the norm of two powers, by what is quickest for them.
#[inline(always)]
pub(super) fn with_norm<S: Simd, W: WithNorm<S>>(
    simd: S,
    xy: PowerKind,
    rz: PowerKind,
    work: W,
) -> W::Output {
    let splat = |kind: PowerKind| Lanes::splat(simd, kind.power());
    match (xy, rz) {
        (PowerKind::Two, PowerKind::Two) => work.run(Pair(Square, Square)),
        (PowerKind::One, PowerKind::One) => work.run(Pair(Sum, Sum)),
        (PowerKind::Two, PowerKind::One) => work.run(Pair(Square, Sum)),
        (PowerKind::One, PowerKind::Two) => work.run(Pair(Sum, Square)),
        (PowerKind::Two, rz) => work.run(LogNorm::new(Round, splat(rz))),
        (xy, rz) => work.run(LogNorm::new(AnyPower::new(splat(xy)), splat(rz))),
    }
}

/// A part of each ray.
#[derive(Clone, Copy)]
pub(super) struct Passage<S: Simd> {
    pub(super) start: Triple<S>,
    pub(super) direction: Triple<S>,
    /// In lengths of the direction.
    pub(super) length: Lanes<S>,
    /// Lanes that have a ray.
    pub(super) active: Mask<S>,
}

/// The first crossing of each ray with the shape at the level 1 + tolerance.
#[derive(Clone, Copy)]
pub(super) struct Crossing<S: Simd> {
    /// The way to it. The shape itself is not met before it, but for `error`.
    pub(super) s: Lanes<S>,
    pub(super) found: Mask<S>,
    /// By how much `s` is off; where N has an edge it may be more, which f64 tells.
    pub(super) error: Lanes<S>,
    /// Where the search has not come to its end.
    pub(super) doubt: Mask<S>,
}

/// From a place outside: N is convex, so each step ends before the crossing.
#[inline(always)]
pub(super) fn first_crossings<S: Simd, const K: usize>(
    norms: [impl Evaluate<S>; K],
    passages: &[Passage<S>; K],
    tolerance: Lanes<S>,
) -> [Crossing<S>; K] {
    let (zero, one) = (tolerance.all(0.0), tolerance.all(1.0));
    let (level, near, close) = (one + tolerance, tolerance.all(NEAR), tolerance.all(CLOSE));
    let nothing = zero.lt(zero);
    let mut active = [passages[0].active; K];
    for k in 1..K {
        active[k] = passages[k].active;
    }
    let mut crossings = [Crossing { s: zero, found: nothing, error: zero, doubt: nothing }; K];
    for _ in 0..MOST_STEPS {
        for k in 0..K {
            let Passage { start, direction, length, .. } = passages[k];
            let Crossing { s, found, error, .. } = &mut crossings[k];
            let Descent { excess, way } = norms[k].descent(start.along(*s, direction), direction, level);
            let step = -excess * way;
            let falls = way.lt(zero);
            // Where N rises it is met only where it is already.
            let arrived = active[k] & excess.le(falls.select(near, close));
            // A place past the crossing, by rounding, is as good.
            let last = falls.select(step.max(zero), zero);
            *found = *found | arrived;
            let slack = (tolerance + tolerance + close).mul_add(way.abs(), last * tolerance.all(LAST_STEP));
            *error = arrived.select(slack, *error);
            active[k] = (active[k] & falls).and_not(arrived);
            *s = arrived.select((*s + last).min(length.max(*s)), active[k].select(*s + step, *s));
            active[k] = active[k] & (*s).le(length);
        }
        if !any_of(&active) {
            break;
        }
    }
    for k in 0..K {
        crossings[k].doubt = active[k];
        crossings[k].found = crossings[k].found | active[k];
    }
    crossings
}

#[inline(always)]
fn any_of<S: Simd, const K: usize>(masks: &[Mask<S>; K]) -> bool {
    let mut all = masks[0];
    for &mask in &masks[1..] {
        all = all | mask;
    }
    all.any()
}

/// Whether each ray comes into the shape.
#[derive(Clone, Copy)]
pub(super) struct Entry<S: Simd> {
    /// Where it is inside for certain: this far from the middle of the passage.
    pub(super) s: Lanes<S>,
    pub(super) inside: Mask<S>,
    /// Where it may be.
    pub(super) touched: Mask<S>,
}

/// From the middle of the passage downhill, whichever way that is: a convex function has its least value there. First to the level at which the shape
/// can no longer be missed, then on to the one at which it is met for certain.
#[inline(always)]
pub(super) fn entries<S: Simd, const K: usize>(
    norms: [impl Evaluate<S>; K],
    passages: &[Passage<S>; K],
    tolerance: Lanes<S>,
) -> [Entry<S>; K] {
    let (zero, one, half) = (tolerance.all(0.0), tolerance.all(1.0), tolerance.all(0.5));
    let close = tolerance.all(CLOSE);
    let (outside, inside) = (one + tolerance, one - tolerance);
    let nothing = zero.lt(zero);
    let mut active = [passages[0].active; K];
    for k in 1..K {
        active[k] = passages[k].active;
    }
    let mut downhill = [one; K];
    let mut answers = [Entry { s: zero, inside: nothing, touched: nothing }; K];
    for step in 0..MOST_STEPS {
        for k in 0..K {
            let Passage { start, direction, length, .. } = passages[k];
            let most = half * length;
            let middle = start.along(most, direction);
            let answer = &mut answers[k];
            let level = answer.touched.select(inside - close, outside);
            let Descent { excess, way } =
                norms[k].descent(middle.along(answer.s, direction), direction, level);
            if step == 0 {
                downhill[k] = (-one).times_sign_of(way);
            }
            // What the excess over one level says of the others.
            let over_inside = excess + (level - inside);
            let arrived = active[k] & over_inside.le(zero);
            answer.touched = answer.touched | (active[k] & (excess + (level - outside)).le(close));
            answer.inside = answer.inside | arrived;
            // The slope still leads downhill.
            let falls = (way * downhill[k]).lt(zero);
            active[k] = (active[k] & falls).and_not(arrived);
            let next = answer.touched.select(inside - close, outside);
            answer.s = active[k].select(answer.s - (excess + (level - next)) * way, answer.s);
            active[k] = active[k] & answer.s.abs().le(most);
        }
        if !any_of(&active) {
            break;
        }
    }
    for k in 0..K {
        answers[k].touched = answers[k].touched | active[k];
    }
    answers
}
