//! Thirty-two rays at a time, each against a convex shape of its own.
//!
//! The caller brings every ray into its shape's space in f64 and to the place where it enters the shape's box; here only the way through the box is
//! solved. Made to be inlined into the caller's own lane code.

use pulp::Simd;

use super::beam::NumberOfPackets as Column;
use super::descent::{Passage, SIDE_BY_SIDE, entries, first_crossings};
use super::kernel::Triple;
use super::lane_power;
use super::log_norm::{AnyPower, LogNorm};
use super::vector::Lanes;
use crate::superquadric::Superquadric;

/// How far N may be off for rays prepared in f64: what f32 rounds within the box.
pub const TOLERANCE: f32 = 1.5e-6;

/// How many rays there are in a flight.
pub const FLIGHT: usize = 32;

/// Rays in the spaces of their shapes.
#[derive(Clone, Debug)]
pub struct FlightLanes {
    start: [Column; 3],
    direction: [Column; 3],
    /// The way from the start on, in unit space; negative where there is no ray.
    length: Column,
    p: Column,
    q: Column,
}

/// What is known of each ray.
#[derive(Clone, Debug)]
pub struct FlightAnswers {
    /// The way to the crossing, in unit space; infinite where there is none.
    pub way: Column,
    /// By how much that may be off.
    pub error: Column,
    /// 1 where it cannot be told.
    pub doubt: Column,
}

impl Default for FlightAnswers {
    fn default() -> Self {
        let (way, error, doubt) = (Column::splat(f32::INFINITY), Column::splat(0.0), Column::splat(0.0));
        Self { way, error, doubt }
    }
}

impl Default for FlightLanes {
    fn default() -> Self {
        let one = Column::splat(1.0);
        Self { start: [one; 3], direction: [one; 3], length: Column::splat(-1.0), p: one, q: one }
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

    /// The first crossing of each ray, from outside; a ray that starts inside is said to cross at its start.
    #[inline(always)]
    pub fn meet<S: Simd>(&self, simd: S, answers: &mut FlightAnswers) {
        let tolerance = Lanes::<S, SIDE_BY_SIDE>::splat(simd, TOLERANCE);
        for i in (0..FLIGHT / S::F32_LANES).step_by(SIDE_BY_SIDE) {
            let (norm, passage) = self.load(simd, i);
            let crossings = first_crossings(norm, &passage, tolerance);
            for k in 0..SIDE_BY_SIDE {
                let crossing = crossings.part(k);
                let one = crossing.s.all(1.0);
                let way = crossing.found.select(crossing.s, one.all(f32::INFINITY));
                let error = crossing.error + one.all(1e-6);
                S::as_mut_simd_f32s(&mut answers.way.0).0[i + k] = way.register();
                S::as_mut_simd_f32s(&mut answers.error.0).0[i + k] = error.register();
                S::as_mut_simd_f32s(&mut answers.doubt.0).0[i + k] =
                    crossing.doubt.select(one, one.all(0.0)).register();
            }
        }
    }

    /// Whether each ray comes into its shape at all: `way` is finite where it does for certain, at a place inside.
    #[inline(always)]
    pub fn occlude<S: Simd>(&self, simd: S, answers: &mut FlightAnswers) {
        let tolerance = Lanes::<S, SIDE_BY_SIDE>::splat(simd, TOLERANCE);
        for i in (0..FLIGHT / S::F32_LANES).step_by(SIDE_BY_SIDE) {
            let (norm, passage) = self.load(simd, i);
            let entry = entries(norm, &passage, tolerance);
            for k in 0..SIDE_BY_SIDE {
                let (s, inside) = (entry.s.part(k), entry.inside.part(k));
                let way = s.all(0.5).mul_add(passage.length.part(k), s);
                let way = inside.select(way, s.all(f32::INFINITY));
                let doubt = entry.touched.part(k).and_not(inside);
                S::as_mut_simd_f32s(&mut answers.way.0).0[i + k] = way.register();
                S::as_mut_simd_f32s(&mut answers.doubt.0).0[i + k] =
                    doubt.select(s.all(1.0), s.all(0.0)).register();
            }
        }
    }

    #[inline(always)]
    fn load<S: Simd, const K: usize>(
        &self,
        simd: S,
        i: usize,
    ) -> (LogNorm<S, AnyPower<S, K>, K>, Passage<S, K>) {
        let norm = LogNorm::new(AnyPower::new(lanes(simd, &self.p, i)), lanes(simd, &self.q, i));
        let length: Lanes<S, K> = lanes(simd, &self.length, i);
        let passage = Passage {
            start: triple(simd, &self.start, i),
            direction: triple(simd, &self.direction, i),
            length,
            active: length.all(0.0).le(length),
        };
        (norm, passage)
    }
}

/// A ray as boxes see it.
#[derive(Clone, Copy, Debug)]
pub struct BoxRay {
    /// The origin for faces that are met first, and for those that are met last: moved a little, so that boxes are taken larger.
    pub first_origin: [f32; 3],
    /// See `first_origin`.
    pub last_origin: [f32; 3],
    /// The reciprocals of the direction's coordinates; none is infinite.
    pub inverse: [f32; 3],
}

/// Which of eight boxes (the least x, y and z of each, then the largest) a ray meets before `t_max`, a bit for each, and where it enters them.
#[inline(always)]
pub fn meet_boxes<S: Simd>(
    simd: S,
    bounds: &[[f32; 8]; 6],
    ray: &BoxRay,
    t_max: f32,
    near: &mut [f32; 8],
) -> u32 {
    #[cfg(target_arch = "x86_64")]
    if let Some(v4) = (&simd as &dyn std::any::Any).downcast_ref::<pulp::x86::V4>() {
        // Eight boxes fill half of a register.
        return meet_boxes_by::<pulp::x86::V3>(**v4, bounds, ray, t_max, near);
    }
    meet_boxes_by(simd, bounds, ray, t_max, near)
}

#[inline(always)]
fn meet_boxes_by<S: Simd>(
    simd: S,
    bounds: &[[f32; 8]; 6],
    ray: &BoxRay,
    t_max: f32,
    near: &mut [f32; 8],
) -> u32 {
    let mut met = 0;
    for i in 0..8 / S::F32_LANES {
        let (mut enter, mut leave) = (Lanes::<S>::splat(simd, 0.0), Lanes::<S>::splat(simd, t_max));
        for axis in 0..3 {
            let (first, last) = if ray.inverse[axis] >= 0.0 { (axis, axis + 3) } else { (axis + 3, axis) };
            let inverse = Lanes::splat(simd, ray.inverse[axis]);
            let face = Lanes::new(simd, S::as_simd_f32s(&bounds[first]).0[i]);
            enter = enter.max((face - Lanes::splat(simd, ray.first_origin[axis])) * inverse);
            let face = Lanes::new(simd, S::as_simd_f32s(&bounds[last]).0[i]);
            leave = leave.min((face - Lanes::splat(simd, ray.last_origin[axis])) * inverse);
        }
        S::as_mut_simd_f32s(near).0[i] = enter.register();
        met |= enter.le(leave).bits() << (i * S::F32_LANES);
    }
    met
}

#[inline(always)]
fn lanes<S: Simd, const K: usize>(simd: S, column: &Column, i: usize) -> Lanes<S, K> {
    let registers = S::as_simd_f32s(&column.0).0;
    let mut parts = [Lanes::new(simd, registers[i]); K];
    for k in 1..K {
        parts[k] = Lanes::new(simd, registers[i + k]);
    }
    Lanes::join(parts)
}

#[inline(always)]
fn triple<S: Simd, const K: usize>(simd: S, columns: &[Column; 3], i: usize) -> Triple<S, K> {
    let [x, y, z] = columns;
    Triple { x: lanes(simd, x, i), y: lanes(simd, y, i), z: lanes(simd, z, i) }
}
