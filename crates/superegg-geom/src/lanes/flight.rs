//! Rays that have nothing in common: many against the boxes of one node, eight of them on their way to shapes of their own, thirty-two of them
//! against those shapes.
//!
//! What needs f64 is done before: a ray is brought into its shape's space and to the place where it enters the shape's box ([`Approaches`]); then
//! only the way through the box is solved ([`FlightLanes`]). Made to be inlined into the caller's own lane code.

use glam::{DAffine3, DVec3};
use pulp::Simd;

use super::beam::NumberOfPackets as Column;
use super::descent::{NEAR, Passage, SIDE_BY_SIDE, entries, first_crossings};
use super::kernel::{Descent, Evaluate, Triple};
use super::log_norm::{AnyPower, LogNorm};
use super::vector::Lanes;

/// How far N may be off for rays prepared in f64: what f32 rounds within the box.
pub const TOLERANCE: f32 = 1.5e-6;
/// A start where N is so near to 1 may be on the surface.
const SURFACE: f32 = 1e-4;

/// Where the last step to an exit begins: backwards what an edge hides is too late, and something else may seem to be first.
const NEAR_EXIT: f32 = 1e-5;

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
    /// 1 where the ray is known to start on the surface and to go in.
    inward: Column,
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
    /// 1 where the ray leaves the shape there.
    pub leaving: Column,
}

impl Default for FlightAnswers {
    fn default() -> Self {
        let zero = Column::splat(0.0);
        Self { way: Column::splat(f32::INFINITY), error: zero, doubt: zero, leaving: zero }
    }
}

impl Default for FlightLanes {
    fn default() -> Self {
        let one = Column::splat(1.0);
        Self {
            start: [one; 3],
            direction: [one; 3],
            length: Column::splat(-1.0),
            p: one,
            q: one,
            inward: Column::splat(0.0),
        }
    }
}

impl FlightLanes {
    /// Puts a ray into a lane, with its convex shape of radii 1, by its [`super::lane_powers`]; `is_inward` where it is known to start on the surface and to go
    /// in.
    #[inline(always)]
    pub fn set(&mut self, lane: usize, [p, q]: [f32; 2], approach: &Approach, is_inward: bool) {
        for axis in 0..3 {
            self.start[axis].0[lane] = approach.start[axis];
            self.direction[axis].0[lane] = approach.direction[axis];
        }
        self.length.0[lane] = approach.length;
        self.p.0[lane] = p;
        self.q.0[lane] = q;
        self.inward.0[lane] = f32::from(u8::from(is_inward));
    }

    /// Takes the rays out of the lanes from one on.
    #[inline(always)]
    pub fn unset_from(&mut self, lane: usize) {
        for length in &mut self.length.0[lane..FLIGHT] {
            *length = -1.0;
        }
    }

    /// The first crossing of each ray in the first `count` lanes, from outside; a ray that starts inside is said to cross at its start.
    #[inline(always)]
    pub fn meet<S: Simd>(&self, simd: S, count: usize, answers: &mut FlightAnswers) {
        let tolerance = Lanes::<S, SIDE_BY_SIDE>::splat(simd, TOLERANCE);
        for i in (0..count.div_ceil(S::F32_LANES)).step_by(SIDE_BY_SIDE) {
            let (norm, passage) = self.load(simd, i);
            let crossings = first_crossings(norm, &passage, tolerance, tolerance.all(NEAR));
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

    /// The same for rays that start within the boxes of their shapes and are seen to the boxes' ends: from a start in the shape, or on it and inwards, the
    /// way out, which is the first crossing from the other end. Any other start too near to the surface to tell is a doubt.
    #[inline(always)]
    pub fn meet_within<S: Simd>(&self, simd: S, count: usize, answers: &mut FlightAnswers) {
        let tolerance = Lanes::<S, SIDE_BY_SIDE>::splat(simd, TOLERANCE);
        for i in (0..count.div_ceil(S::F32_LANES)).step_by(SIDE_BY_SIDE) {
            let (norm, passage) = self.load(simd, i);
            let one = tolerance.all(1.0);
            let zero = tolerance.all(0.0);
            let Descent { excess, .. } = norm.descent(passage.start, passage.direction, one);
            let inward = zero.lt(lanes(simd, &self.inward, i));
            let inside = excess.lt(one.all(-SURFACE)) | inward;
            let outside = one.all(SURFACE).lt(excess).and_not(inward);
            let Passage { start, direction, length, active } = passage;
            let turn = inside.select(-one, one);
            let back = inside.select(length, zero);
            let turned = Passage {
                start: start.along(back, direction),
                direction: direction.scaled(turn),
                length,
                active: active & (inside | outside),
            };
            let crossing =
                first_crossings(norm, &turned, tolerance, inside.select(one.all(NEAR_EXIT), one.all(NEAR)));
            let way = turn.mul_add(crossing.s, back);
            let way = crossing.found.select(way, one.all(f32::INFINITY));
            // Of those within none can miss.
            let mut doubt =
                crossing.doubt | active.and_not(inside | outside) | (inside & active).and_not(crossing.found);
            if inward.any() {
                // A way that nowhere goes deep is along the surface, and may end anywhere.
                let halfway = start.along(way * one.all(0.5), direction);
                let Descent { excess, .. } = norm.descent(halfway, direction, one);
                doubt = doubt | (inward & active).and_not(excess.lt(one.all(-SURFACE)));
            }
            let error = crossing.error + one.all(1e-6);
            for k in 0..SIDE_BY_SIDE {
                S::as_mut_simd_f32s(&mut answers.way.0).0[i + k] = way.part(k).register();
                S::as_mut_simd_f32s(&mut answers.error.0).0[i + k] = error.part(k).register();
                S::as_mut_simd_f32s(&mut answers.doubt.0).0[i + k] =
                    doubt.select(one, zero).part(k).register();
                S::as_mut_simd_f32s(&mut answers.leaving.0).0[i + k] =
                    inside.select(one, zero).part(k).register();
            }
        }
    }

    /// Whether each ray in the first `count` lanes comes into its shape at all: `way` is finite where it does for certain, at a place inside.
    #[inline(always)]
    pub fn occlude<S: Simd>(&self, simd: S, count: usize, answers: &mut FlightAnswers) {
        let tolerance = Lanes::<S, SIDE_BY_SIDE>::splat(simd, TOLERANCE);
        for i in (0..count.div_ceil(S::F32_LANES)).step_by(SIDE_BY_SIDE) {
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

/// A ray as boxes see it: half a line of the cache.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C, align(32))]
pub struct BoxRay {
    /// The origin, moved by half of `room` along each axis the way the ray goes, for faces that are met first; without all of it, for those that are met last.
    pub first_origin: [f32; 3],
    /// The reciprocals of the direction's coordinates; none is infinite.
    pub inverse: [f32; 3],
    /// Boxes are taken so much wider, for rounding.
    pub room: f32,
}

impl BoxRay {
    /// A ray from its origin and direction, in a space where boxes have coordinates of the order of 1, and the largest coordinate of the origin.
    #[inline(always)]
    pub fn new(origin: DVec3, direction: DVec3, size: f64) -> Self {
        let pad = 6e-7 * (size + 2.0);
        let mut ray = Self { room: (2.0 * pad) as f32, ..Self::default() };
        for axis in 0..3 {
            let inverse = (1.0 / direction[axis] as f32).clamp(-MOST_INVERSE as f32, MOST_INVERSE as f32);
            ray.first_origin[axis] = (origin[axis] + pad.copysign(f64::from(inverse))) as f32;
            ray.inverse[axis] = inverse;
        }
        ray
    }
}

/// A ray of a list: its place among the rays, and that of its end among the ends.
#[derive(Clone, Copy, Debug, Default)]
pub struct Listed {
    ray: u32,
    end: u32,
}

impl Listed {
    /// From both places.
    #[inline(always)]
    pub fn new(ray: u32, end: u32) -> Self {
        Self { ray, end }
    }

    /// The place among the rays.
    #[inline(always)]
    pub fn ray(self) -> usize {
        self.ray as usize
    }

    /// The place among the ends.
    #[inline(always)]
    pub fn end(self) -> usize {
        self.end as usize
    }
}

/// What the rays of a list meet of eight boxes.
#[derive(Debug)]
pub struct BoxEntries<'a> {
    /// By rays the t where it enters each box, infinite where it does not before its end.
    pub near: &'a mut [[f32; 8]],
    /// By rays the boxes that it enters, a bit for each.
    pub met: &'a mut [u8],
}

/// Where each ray of a list enters eight boxes (the least x, y and z of each, then the largest). All rays are of one octant. Returns a bit for each box
/// that any of them meets.
#[inline(always)]
pub fn meet_boxes<S: Simd>(
    simd: S,
    bounds: &[[f32; 8]; 6],
    octant: u8,
    rays: &[BoxRay],
    list: &[Listed],
    ends: &[f32],
    entries: BoxEntries<'_>,
) -> u8 {
    #[cfg(target_arch = "x86_64")]
    if let Some(v4) = (&simd as &dyn std::any::Any).downcast_ref::<pulp::x86::V4>() {
        // Eight boxes fill half of a register.
        return meet_boxes_by::<pulp::x86::V3>(**v4, bounds, octant, rays, list, ends, entries);
    }
    meet_boxes_by(simd, bounds, octant, rays, list, ends, entries)
}

#[inline(always)]
fn meet_boxes_by<S: Simd>(
    simd: S,
    bounds: &[[f32; 8]; 6],
    octant: u8,
    rays: &[BoxRay],
    list: &[Listed],
    ends: &[f32],
    entries: BoxEntries<'_>,
) -> u8 {
    let BoxEntries { near, met } = entries;
    let mut met_by_any = 0;
    for i in 0..8 / S::F32_LANES {
        let face = |row: usize| Lanes::<S>::new(simd, S::as_simd_f32s(&bounds[row]).0[i]);
        let is_back = [octant & 1, octant >> 1 & 1, octant >> 2 & 1];
        let mut first = [face(0); 3];
        let mut last = [face(0); 3];
        let mut forth = [face(0); 3];
        for axis in 0..3 {
            first[axis] = face(axis + 3 * usize::from(is_back[axis]));
            last[axis] = face(axis + 3 * usize::from(1 - is_back[axis]));
            forth[axis] = Lanes::splat(simd, if is_back[axis] == 1 { -1.0 } else { 1.0 });
        }
        let nothing = Lanes::<S>::splat(simd, f32::INFINITY);
        for ((listed, near), met) in list.iter().zip(near.iter_mut()).zip(met.iter_mut()) {
            let ray = &rays[listed.ray()];
            let mut enter = Lanes::<S>::splat(simd, 0.0);
            let mut leave = Lanes::<S>::splat(simd, ends[listed.end()]);
            let room = Lanes::splat(simd, ray.room);
            for axis in 0..3 {
                let inverse = Lanes::splat(simd, ray.inverse[axis]);
                let origin = Lanes::splat(simd, ray.first_origin[axis]);
                enter = enter.max((first[axis] - origin) * inverse);
                leave = leave.min(forth[axis].mul_add(room, last[axis] - origin) * inverse);
            }
            let meets = enter.le(leave);
            S::as_mut_simd_f32s(near).0[i] = meets.select(enter, nothing).register();
            let bits = (meets.bits() << (i * S::F32_LANES)) as u8;
            *met = if i == 0 { bits } else { *met | bits };
            met_by_any |= bits;
        }
    }
    met_by_any
}

/// How many rays approach their shapes together.
pub const APPROACH: usize = 8;
/// Boxes of shapes are taken so much larger, for rounding.
const BOX: f64 = 1.0 + 1e-6;
/// Ends of rays are known to this part of their t.
pub const END: f64 = 4e-6;
/// The square of the farthest that a box reaches, with room.
const BALL: f64 = 3.000_01;
/// From farther away f64 does the rest.
const FAR: f64 = 1e4;
/// Reciprocals end here.
const MOST_INVERSE: f64 = 1e30;

type Eight = [f64; APPROACH];

/// Rays in the spaces of the shapes whose boxes they may meet, in f64.
#[derive(Clone, Debug, Default)]
pub struct Approaches {
    origin: [Eight; 3],
    direction: [Eight; 3],
    t_max: Eight,
    answers: Answers,
}

#[derive(Clone, Debug, Default)]
struct Answers {
    verdict: Eight,
    start: [Eight; 3],
    direction: [Eight; 3],
    length: Eight,
    entry: Eight,
    t_per_way: Eight,
}

/// How a ray comes to the box of its shape.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// Not at all, or not before its end.
    Misses,
    /// From outside.
    Enters,
    /// It starts there.
    Within,
    /// In a way that f32 cannot hold.
    Doubtful,
}

/// A ray in the space of its shape, between where it enters the box, or starts in it, and where it leaves it or ends.
#[derive(Clone, Copy, Debug)]
pub struct Approach {
    /// The first place in the box.
    pub start: [f32; 3],
    /// Of unit length there.
    pub direction: [f32; 3],
    /// The way through the box: to its end where the ray starts within.
    pub length: f32,
    /// The ray's t at the start.
    pub entry: f64,
    /// What brings a way in that space to a t.
    pub t_per_way: f64,
}

impl Approaches {
    /// Puts a ray into a lane: the map into the space of its unit shape, its origin and direction, and the t where it ends.
    #[inline(always)]
    pub fn set(&mut self, lane: usize, map: &DAffine3, [origin, direction]: [DVec3; 2], t_max: f64) {
        let (origin, direction) = (map.transform_point3(origin), map.transform_vector3(direction));
        for axis in 0..3 {
            self.origin[axis][lane] = origin[axis];
            self.direction[axis][lane] = direction[axis];
        }
        self.t_max[lane] = t_max;
    }

    /// Brings all rays to their boxes. Plain loops, which the compiler turns into lanes.
    #[inline(always)]
    pub fn run(&mut self) {
        let Self { origin, direction, t_max, answers } = self;
        for i in 0..APPROACH {
            let (ox, oy, oz) = (origin[0][i], origin[1][i], origin[2][i]);
            let (dx, dy, dz) = (direction[0][i], direction[1][i], direction[2][i]);
            let size = (dx * dx + dy * dy + dz * dz).sqrt();
            let t_per_way = 1.0 / size;
            let (dx, dy, dz) = (dx * t_per_way, dy * t_per_way, dz * t_per_way);
            let nearest = -(ox * dx + oy * dy + oz * dz);
            let (cx, cy, cz) = (ox + nearest * dx, oy + nearest * dy, oz + nearest * dz);
            let (enter_x, leave_x) = slab(cx, dx);
            let (enter_y, leave_y) = slab(cy, dy);
            let (enter_z, leave_z) = slab(cz, dz);
            let enter = larger(larger(enter_x, enter_y), enter_z);
            let leave = lesser(lesser(leave_x, leave_y), leave_z);
            let farthest = larger(larger(ox.abs(), oy.abs()), oz.abs());
            let is_within = farthest <= BOX;
            let t_end = t_max[i] * size;
            let is_missed = cx * cx + cy * cy + cz * cz > BALL
                || enter > leave
                || (nearest + leave < 0.0 && !is_within)
                || nearest + enter > t_end;
            let is_finite = enter.abs() < f64::INFINITY
                && leave.abs() < f64::INFINITY
                && nearest.abs() < f64::INFINITY
                && size > 0.0;
            let is_told = is_finite && farthest <= FAR;
            let first = if is_within { -nearest } else { enter };
            let last = if is_within { leave } else { lesser(leave, t_end * (1.0 + END) - nearest) };
            answers.start[0][i] = cx + first * dx;
            answers.start[1][i] = cy + first * dy;
            answers.start[2][i] = cz + first * dz;
            (answers.direction[0][i], answers.direction[1][i], answers.direction[2][i]) = (dx, dy, dz);
            answers.length[i] = last - first;
            answers.entry[i] = (nearest + first) * t_per_way;
            answers.t_per_way[i] = t_per_way;
            let met = if is_within { 2.0 } else { 1.0 };
            let met = if is_told { met } else { 3.0 };
            answers.verdict[i] = if is_missed { 0.0 } else { met };
        }
    }

    /// How the ray of a lane comes to its box.
    #[inline(always)]
    pub fn verdict(&self, lane: usize) -> Verdict {
        match self.answers.verdict[lane] {
            0.0 => Verdict::Misses,
            1.0 => Verdict::Enters,
            2.0 => Verdict::Within,
            _ => Verdict::Doubtful,
        }
    }

    /// The ray of a lane that enters its box or starts in it.
    #[inline(always)]
    pub fn get(&self, lane: usize) -> Approach {
        let Answers { start, direction, length, entry, t_per_way, .. } = &self.answers;
        let (mut start_point, mut way) = ([0.0; 3], [0.0; 3]);
        for axis in 0..3 {
            start_point[axis] = start[axis][lane] as f32;
            way[axis] = direction[axis][lane] as f32;
        }
        Approach {
            start: start_point,
            direction: way,
            length: length[lane] as f32,
            entry: entry[lane],
            t_per_way: t_per_way[lane],
        }
    }
}

/// Where a line comes between two opposite faces of the box of half edges 1, and where it leaves.
#[inline(always)]
fn slab(at: f64, direction: f64) -> (f64, f64) {
    let inverse = 1.0 / direction;
    // A line within two faces comes from very far away, and leaves there.
    let size = lesser(inverse.abs(), MOST_INVERSE);
    let middle = -at * size.copysign(direction);
    (middle - size * BOX, middle + size * BOX)
}

#[inline(always)]
fn lesser(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

#[inline(always)]
fn larger(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
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
