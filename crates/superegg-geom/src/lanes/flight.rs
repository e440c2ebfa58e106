//! Sixteen rays at a time, each against a convex shape of its own.
//!
//! The caller brings every ray into its shape's space in f64 and to the place where it enters the shape's box; here only the way through the box is
//! solved. Made to be inlined into the caller's own lane code.

use pulp::Simd;

use super::beam::{PACKET, PacketOf, PacketVectors};
use super::descent::{Passage, entries, first_crossings};
use super::kernel::Triple;
use super::lane_power;
use super::log_norm::{AnyPower, LogNorm};
use super::vector::Lanes;
use crate::superquadric::Superquadric;

/// How far N may be off for rays prepared in f64: what f32 rounds within the box.
pub const TOLERANCE: f32 = 1.5e-6;

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
        let tolerance = Lanes::<S>::splat(simd, TOLERANCE);
        let (zero, one) = (tolerance.all(0.0), tolerance.all(1.0));
        for i in 0..PACKET / S::F32_LANES {
            let (norm, passage) = self.load(simd, i);
            let crossing = first_crossings(norm, &passage, tolerance);
            let way = crossing.found.select(crossing.s, tolerance.all(f32::INFINITY));
            S::as_mut_simd_f32s(&mut answers.way.0).0[i] = way.register();
            S::as_mut_simd_f32s(&mut answers.error.0).0[i] =
                (crossing.error + tolerance.all(1e-6)).register();
            S::as_mut_simd_f32s(&mut answers.doubt.0).0[i] = crossing.doubt.select(one, zero).register();
        }
    }

    /// Whether each ray comes into its shape at all: `way` is finite where it does for certain, at a place inside.
    #[inline(always)]
    pub fn occlude<S: Simd>(&self, simd: S, answers: &mut FlightAnswers) {
        let tolerance = Lanes::<S>::splat(simd, TOLERANCE);
        let (zero, one) = (tolerance.all(0.0), tolerance.all(1.0));
        for i in 0..PACKET / S::F32_LANES {
            let (norm, passage) = self.load(simd, i);
            let entry = entries(norm, &passage, tolerance);
            let way = tolerance.all(0.5).mul_add(passage.length, entry.s);
            let way = entry.inside.select(way, tolerance.all(f32::INFINITY));
            let doubt = entry.touched.and_not(entry.inside);
            S::as_mut_simd_f32s(&mut answers.way.0).0[i] = way.register();
            S::as_mut_simd_f32s(&mut answers.doubt.0).0[i] = doubt.select(one, zero).register();
        }
    }

    #[inline(always)]
    fn load<S: Simd>(&self, simd: S, i: usize) -> (LogNorm<S, AnyPower<S, 1>, 1>, Passage<S>) {
        let lane = |column: &PacketOf<f32>| Lanes::new(simd, S::as_simd_f32s(&column.0).0[i]);
        let norm = LogNorm::new(AnyPower::new(lane(&self.p)), lane(&self.q));
        let length = lane(&self.length);
        let passage = Passage {
            start: Triple::of_packet(simd, &self.start, i),
            direction: Triple::of_packet(simd, &self.direction, i),
            length,
            active: length.all(0.0).le(length),
        };
        (norm, passage)
    }
}
