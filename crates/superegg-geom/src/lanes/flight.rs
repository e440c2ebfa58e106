//! Sixteen rays at a time, each against a convex shape of its own.
//!
//! The caller brings every ray into its shape's space in f64 and to the place where it enters the shape's box; here only the way through the box is
//! solved. Made to be inlined into the caller's own lane code.

use pulp::Simd;

use super::beam::{PACKET, PacketOf, PacketVectors};
use super::kernel::{CLOSE, Evaluate, TINY, Triple};
use super::lane_power;
use super::log_norm::LogNorm;
use super::vector::Lanes;
use crate::superquadric::Superquadric;

/// How far N may be off for rays prepared in f64: what f32 rounds within the box.
pub const TOLERANCE: f32 = 1.5e-6;
/// Steps of Newton's method before what is left goes to f64: grazing rays.
const MOST_STEPS: usize = 10;

/// Rays in the spaces of their shapes.
#[derive(Clone, Debug)]
pub struct FlightLanes {
    start: PacketVectors,
    direction: PacketVectors,
    /// The way from the start on, in unit space; negative where there is no ray.
    length: PacketOf<f32>,
    p: PacketOf<f32>,
    q: PacketOf<f32>,
}

/// What is known of each ray.
#[derive(Clone, Debug)]
pub struct FlightAnswers {
    /// The way to the crossing, in unit space; infinite where there is none.
    pub way: PacketOf<f32>,
    /// By how much that may be off.
    pub error: PacketOf<f32>,
    /// 1 where it cannot be told.
    pub doubt: PacketOf<f32>,
}

impl Default for FlightAnswers {
    fn default() -> Self {
        let (way, error, doubt) =
            (PacketOf::splat(f32::INFINITY), PacketOf::splat(0.0), PacketOf::splat(0.0));
        Self { way, error, doubt }
    }
}

impl Default for FlightLanes {
    fn default() -> Self {
        let one = PacketOf::splat(1.0);
        Self { start: [one; 3], direction: [one; 3], length: PacketOf::splat(-1.0), p: one, q: one }
    }
}

impl FlightLanes {
    /// Puts a ray into a lane: a convex shape of radii 1, a start in or on its box, a unit direction, and the way through the box.
    #[inline(always)]
    pub fn set(
        &mut self,
        lane: usize,
        shape: &Superquadric,
        start: [f32; 3],
        direction: [f32; 3],
        length: f32,
    ) {
        for axis in 0..3 {
            self.start[axis].0[lane] = start[axis];
            self.direction[axis].0[lane] = direction[axis];
        }
        self.length.0[lane] = length;
        self.p.0[lane] = lane_power(shape.norm().xy.p);
        self.q.0[lane] = lane_power(shape.norm().rz.p);
    }

    /// Takes a ray out of a lane.
    #[inline(always)]
    pub fn unset(&mut self, lane: usize) {
        self.length.0[lane] = -1.0;
    }

    /// The first crossing of each ray, from outside.
    #[inline(always)]
    pub fn meet<S: Simd>(&self, simd: S, answers: &mut FlightAnswers) {
        let splat = |x: f32| Lanes::<S>::splat(simd, x);
        let (zero, one, level) = (splat(0.0), splat(1.0), splat(1.0 + TOLERANCE));
        let close = splat(CLOSE);
        for i in 0..PACKET / S::F32_LANES {
            let (norm, start, d, length) = self.load(simd, i);
            let mut active = zero.le(length);
            let mut s = zero;
            let mut steepness = one;
            let mut hit = zero.lt(zero);
            for _ in 0..MOST_STEPS {
                let (value, slope) = norm.evaluate(start.along(s, d), d);
                let above = value - level;
                let arrived = active & above.le(close);
                hit = hit | arrived;
                steepness = arrived.select(slope, steepness);
                active = (active & slope.lt(zero)).and_not(arrived);
                s = active.select(s - above / slope, s);
                active = active & s.le(length);
                if !active.any() {
                    break;
                }
            }
            let way = (hit | active).select(s, splat(f32::INFINITY));
            let error = splat(2.0 * TOLERANCE + CLOSE) / steepness.abs().max(splat(TINY)) + splat(1e-6);
            S::as_mut_simd_f32s(&mut answers.way.0).0[i] = way.register;
            S::as_mut_simd_f32s(&mut answers.error.0).0[i] = error.register;
            S::as_mut_simd_f32s(&mut answers.doubt.0).0[i] = active.select(one, zero).register;
        }
    }

    /// Whether each ray comes into its shape at all: `way` is finite where it does for certain, at a place inside.
    #[inline(always)]
    pub fn occlude<S: Simd>(&self, simd: S, answers: &mut FlightAnswers) {
        let splat = |x: f32| Lanes::<S>::splat(simd, x);
        let (zero, one) = (splat(0.0), splat(1.0));
        let (outside, inside, close) = (splat(1.0 + TOLERANCE), splat(1.0 - TOLERANCE), splat(CLOSE));
        for i in 0..PACKET / S::F32_LANES {
            let (norm, start, d, length) = self.load(simd, i);
            let mut active = zero.le(length);
            let half = splat(0.5) * length;
            let middle = start.along(half, d);
            let mut s = zero;
            let mut downhill = one;
            let mut hit = zero.lt(zero);
            let mut touched = hit;
            for step in 0..MOST_STEPS {
                let (value, slope) = norm.evaluate(middle.along(s, d), d);
                if step == 0 {
                    downhill = (-one).times_sign_of(slope);
                }
                let arrived = active & value.le(inside);
                touched = touched | (active & value.le(outside + close));
                let level = touched.select(inside - close, outside);
                hit = hit | arrived;
                active = (active & (slope * downhill).lt(zero)).and_not(arrived);
                s = active.select(s - (value - level) / slope, s);
                active = active & s.abs().le(half);
                if !active.any() {
                    break;
                }
            }
            let doubt = (active | touched).and_not(hit);
            S::as_mut_simd_f32s(&mut answers.way.0).0[i] =
                hit.select(half + s, splat(f32::INFINITY)).register;
            S::as_mut_simd_f32s(&mut answers.doubt.0).0[i] = doubt.select(one, zero).register;
        }
    }

    #[inline(always)]
    fn load<S: Simd>(&self, simd: S, i: usize) -> (LogNorm<S>, Triple<S>, Triple<S>, Lanes<S>) {
        let lane = |column: &PacketOf<f32>| Lanes::new(simd, S::as_simd_f32s(&column.0).0[i]);
        let norm = LogNorm::new(lane(&self.p), lane(&self.q));
        (
            norm,
            Triple::of_packet(simd, &self.start, i),
            Triple::of_packet(simd, &self.direction, i),
            lane(&self.length),
        )
    }
}
