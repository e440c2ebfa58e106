//! Rays that share an origin, by the packet: against boxes, and against convex shapes.
//!
//! What is found here is a candidate. Directions and maps are rounded to f32, so a shape is met at the level 1 + tolerance of N, and the caller
//! settles in f64 what lies within the tolerance. No shape is missed.

#![allow(clippy::needless_range_loop, reason = "plain loops become lanes")]

use glam::DVec3;
use pulp::{Arch, Simd, WithSimd};

use super::crowd::{Approach, Crowd, Origin};
use super::descent::{Crossing, Entry, NEAR, SIDE_BY_SIDE, WithNorm, entries, first_crossings, with_norm};
use super::kernel::{BOX, Evaluate, Rise, TINY, Triple};
use super::vector::{Lanes, Mask};
use super::{PowerKind, lane_power};
use crate::math::numeric::scale_to_unit;
use crate::superquadric::Superquadric;

/// Rays in a packet.
pub const PACKET: usize = 16;
/// The bits of all lanes of a packet.
pub const ALL_LANES: u32 = (1 << PACKET) - 1;
/// Packets of a beam at most: as many as a mask has bits.
pub const MOST_PACKETS: usize = 32;

/// A number for each ray of a packet.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(64))]
pub struct PacketOf<T>(pub [T; PACKET]);

impl<T: Copy> PacketOf<T> {
    /// The same for all.
    pub fn splat(x: T) -> Self {
        Self([x; PACKET])
    }
}

/// A vector for each ray of a packet.
pub type PacketVectors = [PacketOf<f32>; 3];

/// The same in f64. Where there is no ray it is NaN.
pub type PacketVectors64 = [PacketOf<f64>; 3];

/// A convex shape, as the rays of a beam see it.
#[derive(Clone, Copy, Debug)]
pub struct BeamShape {
    /// The linear map from the beam's directions to the unit shape's space, by columns.
    pub columns: [[f32; 3]; 3],
    /// The beam's origin in the unit shape's space.
    pub origin: [f32; 3],
    /// How far N at a place on a ray may be off, for the rounding of maps and directions.
    pub tolerance: f32,
    /// What a t of this space has to be multiplied by to be one of the beam.
    pub t_scale: f32,
    xy: PowerKind,
    rz: PowerKind,
    /// No point of the shape is farther from its centre.
    reach: f32,
}

impl BeamShape {
    /// A shape with e, n <= 2.
    pub fn new(
        shape: &Superquadric,
        columns: [[f32; 3]; 3],
        origin: [f32; 3],
        tolerance: f32,
        t_scale: f32,
    ) -> Self {
        debug_assert!(shape.is_convex());
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

/// The largest distance of a point of the unit shape from its centre, or up to a twentieth more. For p, q >= 2 Hölder's inequality gives
/// x^2 + y^2 <= 2^(1 - 2/p) R^2 and r^2 + z^2 <= |(r^2, 1)| in the norm dual to q/2; each power is below its chord.
fn reach(p: f32, q: f32) -> f32 {
    let beyond = |p: f32| (1.0 - 2.0 / p).max(0.0);
    1.0001 * (1.0 + beyond(p) + beyond(q)).sqrt()
}

/// The best that is known of the rays of a packet.
#[derive(Clone, Copy, Debug)]
pub struct PacketHits {
    /// The t of the closest candidate, in the beam's own lengths; before there is one the largest t that counts.
    pub t: PacketOf<f32>,
    /// By how much it may be off.
    pub error: PacketOf<f32>,
    /// Which candidate it is.
    pub id: PacketOf<u32>,
    /// 1 where another candidate is as close as can be told, or where Newton's method was not followed to its end.
    pub doubt: PacketOf<f32>,
}

impl PacketHits {
    /// Nothing found yet, and nothing beyond `t_max` counts.
    pub fn up_to(t_max: f32) -> Self {
        Self {
            t: PacketOf::splat(t_max),
            error: PacketOf::splat(0.0),
            id: PacketOf::splat(u32::MAX),
            doubt: PacketOf::splat(0.0),
        }
    }

    /// The largest t that can still be the first of a ray.
    pub fn end(&self) -> f32 {
        self.t.0.iter().zip(self.error.0).map(|(t, error)| t + error).fold(-1.0, f32::max)
    }

    /// Takes a candidate for one ray.
    #[inline(always)]
    pub fn take(&mut self, lane: usize, t: f32, error: f32, id: u32, doubt: f32) {
        let (best, best_error) = (self.t.0[lane], self.error.0[lane]);
        let is_closer = t < best;
        let is_near = (t - best).abs() <= error + best_error;
        let old_doubt = self.doubt.0[lane];
        // What is clearly behind changes nothing; what is clearly before makes good any doubt about what was.
        let doubt = if is_near {
            1.0
        } else if is_closer {
            doubt
        } else {
            old_doubt
        };
        self.doubt.0[lane] = if t < f32::INFINITY { doubt } else { old_doubt };
        self.t.0[lane] = if is_closer { t } else { best };
        self.error.0[lane] = if is_closer { error } else { best_error };
        self.id.0[lane] = if is_closer { id } else { self.id.0[lane] };
    }
}

/// Surfaces of convex shapes where the rays of a packet meet them, to f32's precision.
#[derive(Clone, Copy, Debug)]
pub struct PacketSurfaces {
    /// The lanes of which this speaks, a bit for each.
    pub lanes: u32,
    /// The t of the crossing, in the beam's own lengths.
    pub t: PacketOf<f32>,
    /// By how much it may be off.
    pub error: PacketOf<f32>,
    /// The candidate.
    pub id: PacketOf<u32>,
    /// The unit normal in the beam's space, outwards.
    pub normal: PacketVectors,
}

impl PacketSurfaces {
    /// Of no ray.
    pub const NONE: Self = Self {
        lanes: 0,
        t: PacketOf([0.0; PACKET]),
        error: PacketOf([0.0; PACKET]),
        id: PacketOf([0; PACKET]),
        normal: [PacketOf([0.0; PACKET]); 3],
    };
}

/// Which candidates the rays of a packet meet.
#[derive(Clone, Copy, Debug)]
pub struct PacketCandidates {
    /// The lanes in doubt, a bit for each.
    pub doubtful: u32,
    /// The lanes where the error is below a part of the ray's width.
    pub near: u32,
    /// How many candidates there are in the other lanes.
    pub count: usize,
    /// Which they are.
    pub ids: [u32; PACKET],
    /// The lanes of each.
    pub lanes: [u32; PACKET],
}

/// A linear function of t.
#[derive(Clone, Copy, Debug)]
pub struct Widening {
    /// At t = 0.
    pub width: f32,
    /// By which it grows for each unit of t.
    pub spread: f32,
}

/// The answers of [`Kernels::occlude`]: by packets a bit for each ray.
#[derive(Clone, Copy, Debug)]
pub struct Occlusion {
    /// The packets in which anything is to be said; the others have no answer here.
    pub packets: u32,
    /// The shape is crossed, for certain.
    pub hit: [u32; MOST_PACKETS],
    /// It cannot be told.
    pub doubt: [u32; MOST_PACKETS],
}

/// What the boxes of a tree know of the packets of a beam: bounds of the reciprocals of their rays' directions, in the tree's space.
#[derive(Clone, Copy, Debug)]
pub struct Bundles {
    least: [NumberOfPackets; 3],
    largest: [NumberOfPackets; 3],
    /// The shortest and the longest image of a direction, squared.
    pub squares: [f32; 2],
}

/// A number for each packet of a beam.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(64))]
pub struct NumberOfPackets(pub [f32; MOST_PACKETS]);

impl NumberOfPackets {
    /// The same for all.
    pub fn splat(x: f32) -> Self {
        Self([x; MOST_PACKETS])
    }
}

/// The boxes around the directions of each packet, by their middles and half their sizes.
#[derive(Clone, Copy, Debug)]
pub struct DirectionBoxes {
    middle: [NumberOfPackets; 3],
    half: [NumberOfPackets; 3],
}

impl DirectionBoxes {
    /// Of no packets.
    pub const NONE: Self = Self {
        middle: [NumberOfPackets([0.0; MOST_PACKETS]); 3],
        half: [NumberOfPackets([0.0; MOST_PACKETS]); 3],
    };
}

/// The boxes of a node, as the rays of a beam see them.
#[derive(Clone, Copy, Debug)]
pub struct BeamBoxes<'a> {
    /// The least x, y and z of each box, then the largest.
    pub bounds: &'a [[f32; 8]; 6],
    /// How many boxes there are.
    pub count: usize,
    /// The beam's origin.
    pub origin: [f32; 3],
    /// Boxes are taken larger by this, for the rounding of origin and directions.
    pub pad: [f32; 3],
    /// What a t of the beam has to be multiplied by to be one of this space.
    pub t_scale: f32,
    /// Boxes that are not asked ray by ray, a bit for each.
    pub roughly: u8,
    /// Of the directions in this space, by [`Kernels::bundles`]: what a bundle meets is asked ray by ray, for bundles can be wide.
    pub inverses: &'a [PacketVectors],
}

/// The lanes of this machine.
#[derive(Clone, Copy, Debug)]
pub struct Kernels(Arch);

impl Default for Kernels {
    fn default() -> Self {
        Self(Arch::new())
    }
}

impl Kernels {
    /// Which packets may meet which boxes before their ends, in the beam's own t: bit i of an answer stands for packet i. `mask` has the packets to ask.
    pub fn boxes(
        self,
        boxes: &BeamBoxes<'_>,
        bundles: &Bundles,
        ends: &NumberOfPackets,
        mask: u32,
    ) -> [u32; 8] {
        self.0.dispatch(BoxKernel { boxes, bundles, ends, mask })
    }

    /// The closest crossings of one shape, taken as candidate `id`. Returns the packets in which one became the best. `ends` are kept at the largest t
    /// that can still be the first of a packet.
    #[expect(clippy::too_many_arguments, reason = "the parts of a beam, which has them apart")]
    pub fn meet(
        self,
        shape: &BeamShape,
        directions: &[PacketVectors],
        hits: &mut [PacketHits],
        ends: &mut NumberOfPackets,
        crowd: &mut Crowd,
        mask: u32,
        id: u32,
    ) -> u32 {
        self.0.dispatch(MeetKernel { shape, directions, hits, ends, crowd, mask, id })
    }

    /// Which rays of the packets in a mask cross the shape before their ends, which are the t in `hits`.
    pub fn occlude(
        self,
        shape: &BeamShape,
        directions: &[PacketVectors],
        hits: &[PacketHits],
        crowd: &mut Crowd,
        mask: u32,
    ) -> Occlusion {
        self.0.dispatch(OccludeKernel { shape, directions, hits, crowd, mask })
    }

    /// Which candidates rays meet, and where they are known to less than `width`, for the lanes of a packet that are asked for.
    pub fn candidates(self, hits: &PacketHits, asked: u32, width: Widening) -> PacketCandidates {
        self.0.dispatch(CandidateKernel { hits, asked, width })
    }

    /// The box around directions, and the directions times a power of two as f32; what is no number does not count for the box. `None` where all
    /// are zero, or some is infinite.
    pub fn directions(
        self,
        directions: &[PacketVectors64],
        scaled: &mut Vec<PacketVectors>,
    ) -> Option<Directions> {
        self.0.dispatch(DirectionKernel { directions, scaled })
    }

    /// The surface of one shape near the places in `hits`, for the rays of a packet whose bits are set in `lanes`; `normal_map` has the columns of the
    /// linear map from gradients in the shape's space to normals of any length in the beam's. Lanes of which f32 can tell are added to `surfaces`.
    pub fn surfaces(
        self,
        shape: &BeamShape,
        normal_map: &[[f32; 3]; 3],
        directions: &PacketVectors,
        hits: &PacketHits,
        lanes: u32,
        surfaces: &mut PacketSurfaces,
    ) {
        self.0.dispatch(SurfaceKernel { shape, normal_map, directions, hits, lanes, surfaces });
    }

    /// Begins with rays of which nothing is known: nothing beyond `t_max` counts. Rays whose direction is zero or too large for f32 have nothing to
    /// find, with a t of -1, and are made to go along with one of their packet that is neither; packets of none such have a negative end. Returns the boxes
    /// of the others.
    pub fn start(
        self,
        directions: &mut [PacketVectors],
        hits: &mut [PacketHits],
        ends: &mut NumberOfPackets,
        t_max: f32,
    ) -> DirectionBoxes {
        self.0.dispatch(StartKernel { directions, hits, ends, t_max })
    }

    /// What a tree's boxes know of packets, by the linear map into its space. Of each packet in `mask` every lane counts; the reciprocals of their
    /// directions in that space go to `inverses`.
    pub fn bundles(
        self,
        columns: &[[f32; 3]; 3],
        directions: &[PacketVectors],
        direction_boxes: &DirectionBoxes,
        mask: u32,
        inverses: &mut [PacketVectors],
    ) -> Bundles {
        self.0.dispatch(BundleKernel { columns, directions, direction_boxes, mask, inverses })
    }
}

/// The bits that are set, from the lowest.
#[inline(always)]
fn bits(mut mask: u32) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        (mask != 0).then(|| {
            let bit = mask.trailing_zeros();
            mask &= mask - 1;
            bit as usize
        })
    })
}

struct BoxKernel<'a> {
    boxes: &'a BeamBoxes<'a>,
    bundles: &'a Bundles,
    ends: &'a NumberOfPackets,
    mask: u32,
}

impl WithSimd for BoxKernel<'_> {
    type Output = [u32; 8];

    /// All packets against one box at a time, a bundle as an interval of reciprocals.
    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> [u32; 8] {
        let Self { boxes, bundles, ends, mask } = self;
        let mut met = [0; 8];
        let mut faces = [[0f32; 8]; 6];
        for axis in 0..3 {
            for i in 0..8 {
                faces[axis][i] = boxes.bounds[axis][i] - boxes.origin[axis] - boxes.pad[axis];
                faces[axis + 3][i] = boxes.bounds[axis + 3][i] - boxes.origin[axis] + boxes.pad[axis];
            }
        }
        let splat = |x: f32| Lanes::<S>::splat(simd, x);
        let zero = splat(0.0);
        let t_scale = splat(boxes.t_scale);
        for i in 0..MOST_PACKETS / S::F32_LANES {
            let asked = lanes_of_mask::<S>(mask, i);
            if asked == 0 {
                continue;
            }
            let lane = |column: &NumberOfPackets| Lanes::<S>::new(simd, S::as_simd_f32s(&column.0).0[i]);
            let [x, y, z] = &bundles.least;
            let least = [lane(x), lane(y), lane(z)];
            let [x, y, z] = &bundles.largest;
            let largest = [lane(x), lane(y), lane(z)];
            let end = lane(ends) * t_scale;
            for (child, met) in met.iter_mut().enumerate().take(boxes.count) {
                let (mut near, mut far) = (zero, end);
                for axis in 0..3 {
                    let (low, high) = (splat(faces[axis][child]), splat(faces[axis + 3][child]));
                    let (a, b) = (low * least[axis], low * largest[axis]);
                    let (c, d) = (high * least[axis], high * largest[axis]);
                    near = near.max(a.min(b).min(c.min(d)));
                    far = far.min(a.max(b).max(c.max(d)));
                }
                *met |= (near.le(far).bits() & asked) << (i * S::F32_LANES);
            }
        }
        for (child, met) in met.iter_mut().enumerate().take(boxes.count) {
            if boxes.roughly >> child & 1 == 1 {
                continue;
            }
            for packet in bits(*met) {
                let end = splat(ends.0[packet] * boxes.t_scale);
                let mut is_met = false;
                for i in 0..PACKET / S::F32_LANES {
                    let inverse = Triple::of_packet(simd, &boxes.inverses[packet], i);
                    let (mut near, mut far) = (zero, end);
                    for (axis, inverse) in [inverse.x, inverse.y, inverse.z].into_iter().enumerate() {
                        let low = splat(faces[axis][child]) * inverse;
                        let high = splat(faces[axis + 3][child]) * inverse;
                        near = near.max(low.min(high));
                        far = far.min(low.max(high));
                    }
                    is_met |= near.le(far).any();
                }
                *met &= !(u32::from(!is_met) << packet);
            }
        }
        met
    }
}

/// The bits of a mask for the lanes of register `i`.
#[inline(always)]
fn lanes_of_mask<S: Simd>(mask: u32, i: usize) -> u32 {
    let below = mask >> (i * S::F32_LANES);
    if S::F32_LANES < 32 { below & ((1 << S::F32_LANES) - 1) } else { below }
}

struct StartKernel<'a> {
    directions: &'a mut [PacketVectors],
    hits: &'a mut [PacketHits],
    ends: &'a mut NumberOfPackets,
    t_max: f32,
}

impl WithSimd for StartKernel<'_> {
    type Output = DirectionBoxes;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> DirectionBoxes {
        let Self { directions, hits, ends, t_max } = self;
        let splat = |x: f32| Lanes::<S>::splat(simd, x);
        let (zero, none) = (splat(0.0), simd.splat_u32s(u32::MAX));
        *ends = NumberOfPackets::splat(-1.0);
        let mut boxes = DirectionBoxes::NONE;
        for (number, (packet, hits)) in directions.iter_mut().zip(hits).enumerate() {
            let mut live = 0;
            for i in 0..PACKET / S::F32_LANES {
                let Triple { x, y, z } = Triple::<S>::of_packet(simd, packet, i);
                let size = x.abs() + y.abs() + z.abs();
                let is_live = zero.lt(size) & size.lt(splat(f32::INFINITY));
                live |= is_live.bits() << (i * S::F32_LANES);
                let t = is_live.select(splat(t_max), splat(-1.0));
                S::as_mut_simd_f32s(&mut hits.t.0).0[i] = t.register();
                S::as_mut_simd_f32s(&mut hits.error.0).0[i] = zero.register();
                S::as_mut_simd_f32s(&mut hits.doubt.0).0[i] = zero.register();
                S::as_mut_simd_u32s(&mut hits.id.0).0[i] = none;
            }
            if live == 0 {
                continue;
            }
            ends.0[number] = t_max;
            for (axis, column) in packet.iter_mut().enumerate() {
                if live != ALL_LANES {
                    let along = column.0[live.trailing_zeros() as usize];
                    for lane in 0..PACKET {
                        column.0[lane] = if live >> lane & 1 == 1 { column.0[lane] } else { along };
                    }
                }
                let (mut least, mut largest) = (splat(f32::INFINITY), splat(f32::NEG_INFINITY));
                for &register in S::as_simd_f32s(&column.0).0 {
                    let parts = Lanes::new(simd, register);
                    (least, largest) = (least.min(parts), largest.max(parts));
                }
                let (low, high) = (least.least(), largest.largest());
                boxes.middle[axis].0[number] = 0.5 * low + 0.5 * high;
                boxes.half[axis].0[number] = 0.5 * high - 0.5 * low;
            }
        }
        boxes
    }
}

struct BundleKernel<'a> {
    columns: &'a [[f32; 3]; 3],
    directions: &'a [PacketVectors],
    direction_boxes: &'a DirectionBoxes,
    mask: u32,
    inverses: &'a mut [PacketVectors],
}

/// Images of directions in f32 are off by less than this part of those of their sizes.
const BOX_ROUNDING: f32 = 2e-6;
/// Stands for a reciprocal of any size.
const ENDLESS: f32 = 1e30;

impl WithSimd for BundleKernel<'_> {
    type Output = Bundles;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Bundles {
        let Self { columns, directions, direction_boxes: boxes, mask, inverses } = self;
        let map = Linear::splat(simd, columns);
        let splat = |x: f32| Lanes::<S>::splat(simd, x);
        let (mut shortest, mut longest) = (splat(f32::INFINITY), splat(0.0));
        for packet in bits(mask) {
            for i in 0..PACKET / S::F32_LANES {
                let v = map.image(Triple::of_packet(simd, &directions[packet], i));
                let square = v.dot(v);
                shortest = shortest.min(square);
                longest = longest.max(square);
                for (axis, v) in [v.x, v.y, v.z].into_iter().enumerate() {
                    S::as_mut_simd_f32s(&mut inverses[packet][axis].0).0[i] = recip(v).register();
                }
            }
        }
        let mut bundles = Bundles {
            least: [NumberOfPackets::splat(0.0); 3],
            largest: [NumberOfPackets::splat(0.0); 3],
            squares: [shortest.least(), longest.largest()],
        };
        let size = Linear::splat(simd, &columns.map(|column| column.map(f32::abs)));
        let (one, tiny, endless) = (splat(1.0), splat(TINY), splat(ENDLESS));
        for i in 0..MOST_PACKETS / S::F32_LANES {
            if lanes_of_mask::<S>(mask, i) == 0 {
                continue;
            }
            let lane = |column: &NumberOfPackets| Lanes::<S>::new(simd, S::as_simd_f32s(&column.0).0[i]);
            let triple = |[x, y, z]: &[NumberOfPackets; 3]| Triple { x: lane(x), y: lane(y), z: lane(z) };
            let (middle, half) = (triple(&boxes.middle), triple(&boxes.half));
            // With room for the rounding of the middle and of its image.
            let rounding = splat(BOX_ROUNDING);
            let half = Triple {
                x: rounding.mul_add(middle.x.abs(), half.x),
                y: rounding.mul_add(middle.y.abs(), half.y),
                z: rounding.mul_add(middle.z.abs(), half.z),
            };
            let (middle, half) = (map.image(middle), size.image(half));
            let sides = [(middle.x, half.x), (middle.y, half.y), (middle.z, half.z)];
            for (axis, (middle, half)) in sides.into_iter().enumerate() {
                let (low, high) = (middle - half, middle + half);
                // Directions of both signs pass a slab anywhere.
                let has_sign = tiny.lt(low) | high.lt(-tiny);
                let least = has_sign.select(one / high, -endless);
                let largest = has_sign.select(one / low, endless);
                S::as_mut_simd_f32s(&mut bundles.least[axis].0).0[i] = least.register();
                S::as_mut_simd_f32s(&mut bundles.largest[axis].0).0[i] = largest.register();
            }
        }
        bundles
    }
}

/// A linear map in every lane.
#[derive(Clone, Copy)]
struct Linear<S: Simd>([Triple<S>; 3]);

impl<S: Simd> Linear<S> {
    #[inline(always)]
    fn splat(simd: S, columns: &[[f32; 3]; 3]) -> Self {
        let [a, b, c] = *columns;
        Self([Triple::splat(simd, a), Triple::splat(simd, b), Triple::splat(simd, c)])
    }

    #[inline(always)]
    fn image(self, v: Triple<S>) -> Triple<S> {
        let [a, b, c] = self.0;
        let row = |a: Lanes<S>, b: Lanes<S>, c: Lanes<S>| a.mul_add(v.x, b.mul_add(v.y, c * v.z));
        Triple { x: row(a.x, b.x, c.x), y: row(a.y, b.y, c.y), z: row(a.z, b.z, c.z) }
    }
}

impl<S: Simd> Triple<S> {
    #[inline(always)]
    fn splat(simd: S, [x, y, z]: [f32; 3]) -> Self {
        Self { x: Lanes::splat(simd, x), y: Lanes::splat(simd, y), z: Lanes::splat(simd, z) }
    }

    #[inline(always)]
    pub(super) fn of_packet(simd: S, packet: &PacketVectors, i: usize) -> Self {
        let lane = |column: &PacketOf<f32>| Lanes::new(simd, S::as_simd_f32s(&column.0).0[i]);
        Self { x: lane(&packet[0]), y: lane(&packet[1]), z: lane(&packet[2]) }
    }

    #[inline(always)]
    fn dot(self, other: Self) -> Lanes<S> {
        self.x.mul_add(other.x, self.y.mul_add(other.y, self.z * other.z))
    }

    /// Reciprocals; that of 0 is a large number.
    #[inline(always)]
    fn recip(self) -> Self {
        Self { x: recip(self.x), y: recip(self.y), z: recip(self.z) }
    }
}

#[inline(always)]
fn recip<S: Simd>(x: Lanes<S>) -> Lanes<S> {
    x.abs().max(x.all(TINY)).with_sign_of(x).recip()
}

/// What all rays against one shape share.
#[derive(Clone, Copy)]
struct Setting<S: Simd> {
    map: Linear<S>,
    origin: Triple<S>,
    /// The faces of the box, seen from the origin: the lesser ones and the larger ones.
    lesser: Triple<S>,
    larger: Triple<S>,
    reach_squared: Lanes<S>,
    t_scale: Lanes<S>,
    inverse_t_scale: Lanes<S>,
}

impl<S: Simd> Setting<S> {
    #[inline(always)]
    fn new(simd: S, shape: &BeamShape) -> Self {
        let splat = |x: f32| Lanes::<S>::splat(simd, x);
        let [x, y, z] = shape.origin;
        let half = BOX + shape.tolerance;
        let reach = shape.reach + 2.0 * shape.tolerance;
        Self {
            map: Linear::splat(simd, &shape.columns),
            origin: Triple::splat(simd, [x, y, z]),
            lesser: Triple::splat(simd, [-half - x, -half - y, -half - z]),
            larger: Triple::splat(simd, [half - x, half - y, half - z]),
            reach_squared: splat(1.000_01 * reach * reach),
            t_scale: splat(shape.t_scale),
            inverse_t_scale: splat(1.0 / shape.t_scale),
        }
    }

    /// Where rays are within the ball around the shape and within its box before `end`; `None` where there are none.
    #[inline(always)]
    fn approach(&self, v: Triple<S>, end: impl FnOnce() -> Lanes<S>) -> Option<Approach<S>> {
        let (o, d) = (self.origin, self.map.image(v));
        // The distance of a line from the centre is that of |o x d| / |d|.
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
        let inverse = d.recip();
        for (lesser, larger, inverse) in [
            (self.lesser.x, self.larger.x, inverse.x),
            (self.lesser.y, self.larger.y, inverse.y),
            (self.lesser.z, self.larger.z, inverse.z),
        ] {
            let (a, b) = (lesser * inverse, larger * inverse);
            near = near.max(a.min(b));
            far = far.min(a.max(b));
        }
        let active = is_near & near.le(far);
        active.any().then_some(Approach { near, far, direction: d, active })
    }
}

struct MeetKernel<'a> {
    shape: &'a BeamShape,
    directions: &'a [PacketVectors],
    hits: &'a mut [PacketHits],
    ends: &'a mut NumberOfPackets,
    crowd: &'a mut Crowd,
    mask: u32,
    id: u32,
}

/// [`MeetKernel`] with the lanes.
struct Meet<'a, S: Simd>(S, MeetKernel<'a>);

impl WithSimd for MeetKernel<'_> {
    type Output = u32;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> u32 {
        with_norm(simd, self.shape.xy, self.shape.rz, Meet(simd, self))
    }
}

impl<S: Simd> WithNorm<S> for Meet<'_, S> {
    type Output = u32;

    #[inline(always)]
    fn run(mut self, one: impl Evaluate<S>, many: impl Evaluate<S, SIDE_BY_SIDE>) -> u32 {
        let simd = self.0;
        let setting = Setting::new(simd, self.1.shape);
        let MeetKernel { directions, hits, crowd, mask, .. } = &mut self.1;
        crowd.clear();
        for packet in bits(*mask) {
            for i in 0..PACKET / S::F32_LANES {
                let hits = &hits[packet];
                let end = || {
                    let best = Lanes::new(simd, S::as_simd_f32s(&hits.t.0).0[i]);
                    let error = Lanes::new(simd, S::as_simd_f32s(&hits.error.0).0[i]);
                    (best + error) * setting.inverse_t_scale
                };
                let v = Triple::of_packet(simd, &directions[packet], i);
                if let Some(approach) = setting.approach(v, end) {
                    crowd.push(packet, i, &approach);
                }
            }
        }
        let count = crowd.close::<S>();
        for register in (0..count).step_by(SIDE_BY_SIDE) {
            if register + 1 < count {
                self.meet(many, &setting, register);
            } else {
                self.meet(one, &setting, register);
            }
        }
        let mut better = 0;
        let mut place = 0;
        while let Some(origin) = self.1.crowd.origin(place) {
            better |= u32::from(self.take(origin, &setting)) << origin.packet;
            place += 1;
        }
        better
    }
}

impl<S: Simd> Meet<'_, S> {
    /// Meets the rays of some registers of the crowd.
    #[inline(always)]
    fn meet<const K: usize>(&mut self, norm: impl Evaluate<S, K>, setting: &Setting<S>, register: usize) {
        let Self(simd, MeetKernel { shape, crowd, .. }) = self;
        let tolerance = Lanes::splat(*simd, shape.tolerance);
        let (near, passage) = crowd.passage(setting.origin, register);
        let Crossing { s, found, error, doubt } = first_crossings(norm, &passage, tolerance, near.all(NEAR));
        let t = found.select(near + s, near.all(f32::INFINITY));
        let error = doubt.select(near.all(-1.0), error);
        crowd.put(register, [t, error]);
    }

    /// The rule of [`PacketHits::take`], for all lanes of a register. Whether any became the best.
    #[inline(always)]
    fn take(&mut self, origin: Origin, setting: &Setting<S>) -> bool {
        let Self(simd, MeetKernel { hits, ends, crowd, id, .. }) = self;
        let Origin { packet, register: i, lanes, .. } = origin;
        let (hits, asked) = (&mut hits[packet], Mask::of_bits(*simd, lanes));
        let (zero, one) = (Lanes::splat(*simd, 0.0), Lanes::splat(*simd, 1.0));
        let infinity = zero.all(f32::INFINITY);
        let [t, error] = crowd.found(*simd, origin);
        let t = asked.select(t, infinity);
        let found = t.lt(infinity);
        if !found.any() {
            return false;
        }
        let doubt = error.lt(zero).select(one, zero);
        let t = t * setting.t_scale;
        // t may be off by as much as its place in the shape's space, and by its own rounding.
        let error = error.max(zero).mul_add(setting.t_scale, t.all(4e-7) * t);
        let lane = |column: &PacketOf<f32>| Lanes::<S>::new(*simd, S::as_simd_f32s(&column.0).0[i]);
        let (best, old_error, old_doubt) = (lane(&hits.t), lane(&hits.error), lane(&hits.doubt));
        let is_closer = found & t.lt(best);
        let is_near = found & (t - best).abs().le(error + old_error);
        let doubt = is_near.select(one, is_closer.select(doubt, old_doubt));
        S::as_mut_simd_f32s(&mut hits.doubt.0).0[i] = doubt.register();
        if !is_closer.any() {
            return false;
        }
        S::as_mut_simd_f32s(&mut hits.t.0).0[i] = is_closer.select(t, best).register();
        S::as_mut_simd_f32s(&mut hits.error.0).0[i] = is_closer.select(error, old_error).register();
        let old_ids = S::as_simd_u32s(&hits.id.0).0[i];
        S::as_mut_simd_u32s(&mut hits.id.0).0[i] = is_closer.select_u32(simd.splat_u32s(*id), old_ids);
        let mut end = zero;
        for i in 0..PACKET / S::F32_LANES {
            let (t, error) = (S::as_simd_f32s(&hits.t.0).0[i], S::as_simd_f32s(&hits.error.0).0[i]);
            end = end.max(Lanes::<S>::new(*simd, t) + Lanes::new(*simd, error));
        }
        ends.0[packet] = end.largest();
        true
    }
}

/// The directions of a beam.
#[derive(Clone, Copy, Debug)]
pub struct Directions {
    /// What they were multiplied by: a power of two.
    pub scale: f64,
    /// The box around them, scaled.
    pub least: DVec3,
    /// Its other corner.
    pub most: DVec3,
}

struct DirectionKernel<'a> {
    directions: &'a [PacketVectors64],
    scaled: &'a mut Vec<PacketVectors>,
}

impl WithSimd for DirectionKernel<'_> {
    type Output = Option<Directions>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Option<Directions> {
        let mut least = [simd.splat_f64s(f64::INFINITY); 3];
        let mut most = [simd.splat_f64s(f64::NEG_INFINITY); 3];
        for packet in self.directions {
            for axis in 0..3 {
                for &x in S::as_simd_f64s(&packet[axis].0).0 {
                    let (low, high) = (least[axis], most[axis]);
                    least[axis] = simd.select_f64s(simd.less_than_f64s(x, low), x, low);
                    most[axis] = simd.select_f64s(simd.less_than_f64s(high, x), x, high);
                }
            }
        }
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for axis in 0..3 {
            low[axis] = simd.reduce_min_f64s(least[axis]);
            high[axis] = simd.reduce_max_f64s(most[axis]);
        }
        let (_, scale) = scale_to_unit(low.abs().max(high.abs()))?;
        self.scaled.resize(self.directions.len(), [PacketOf::splat(0.0); 3]);
        for (to, from) in self.scaled.iter_mut().zip(self.directions) {
            for axis in 0..3 {
                for lane in 0..PACKET {
                    to[axis].0[lane] = (from[axis].0[lane] * scale) as f32;
                }
            }
        }
        Some(Directions { scale, least: low * scale, most: high * scale })
    }
}

struct CandidateKernel<'a> {
    hits: &'a PacketHits,
    asked: u32,
    width: Widening,
}

/// Ways whose squares f32 holds, from and to.
pub const RANGE: [f32; 2] = [1e-12, 1e12];

impl WithSimd for CandidateKernel<'_> {
    type Output = PacketCandidates;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> PacketCandidates {
        let Self { hits, asked, width } = self;
        let splat = |x: f32| Lanes::<S>::splat(simd, x);
        let mut answer =
            PacketCandidates { doubtful: 0, near: 0, count: 0, ids: [0; PACKET], lanes: [0; PACKET] };
        let mut missing = 0;
        for i in 0..PACKET / S::F32_LANES {
            let lane = |column: &PacketOf<f32>| Lanes::<S>::new(simd, S::as_simd_f32s(&column.0).0[i]);
            let (t, error) = (lane(&hits.t), lane(&hits.error));
            let doubtful = splat(0.0).lt(lane(&hits.doubt));
            let ids = S::as_simd_u32s(&hits.id.0).0[i];
            let has_none = Mask::<S>::of_equal(simd, ids, simd.splat_u32s(u32::MAX));
            let near = splat(RANGE[0]).le(t)
                & t.lt(splat(RANGE[1]))
                & error.le(splat(width.spread).mul_add(t, splat(width.width)));
            let first = i * S::F32_LANES;
            answer.doubtful |= doubtful.bits() << first;
            answer.near |= near.bits() << first;
            missing |= has_none.bits() << first;
        }
        answer.doubtful &= asked;
        let mut left = asked & !missing & !answer.doubtful;
        while left != 0 {
            let id = hits.id.0[left.trailing_zeros() as usize];
            let mut same = 0;
            for i in 0..PACKET / S::F32_LANES {
                let ids = S::as_simd_u32s(&hits.id.0).0[i];
                same |= Mask::<S>::of_equal(simd, ids, simd.splat_u32s(id)).bits() << (i * S::F32_LANES);
            }
            answer.ids[answer.count] = id;
            answer.lanes[answer.count] = same & left;
            answer.count += 1;
            left &= !same;
        }
        answer
    }
}

struct SurfaceKernel<'a> {
    shape: &'a BeamShape,
    normal_map: &'a [[f32; 3]; 3],
    directions: &'a PacketVectors,
    hits: &'a PacketHits,
    lanes: u32,
    surfaces: &'a mut PacketSurfaces,
}

/// Squares of normals' lengths that leave their roots and reciprocals in the range of f32.
const SQUARES: [f32; 2] = [1e-30, 1e30];

/// [`SurfaceKernel`] with the lanes.
struct Surface<'a, S: Simd>(S, SurfaceKernel<'a>);

impl WithSimd for SurfaceKernel<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        with_norm(simd, self.shape.xy, self.shape.rz, Surface(simd, self));
    }
}

impl<S: Simd> WithNorm<S> for Surface<'_, S> {
    type Output = ();

    #[inline(always)]
    fn run(self, one: impl Evaluate<S>, _: impl Evaluate<S, SIDE_BY_SIDE>) {
        let Self(simd, SurfaceKernel { shape, normal_map, directions, hits, lanes, surfaces }) = self;
        let setting = Setting::new(simd, shape);
        let to_normal = Linear::<S>::splat(simd, normal_map);
        for i in 0..PACKET / S::F32_LANES {
            let first = i * S::F32_LANES;
            let wanted = lanes_of_mask::<S>(lanes, i);
            if wanted == 0 {
                continue;
            }
            let lane = |column: &PacketOf<f32>| Lanes::<S>::new(simd, S::as_simd_f32s(&column.0).0[i]);
            let d = setting.map.image(Triple::of_packet(simd, directions, i));
            let t = lane(&hits.t) * setting.inverse_t_scale;
            // The place was found without a look at it. What a step of Newton's would be from there tells how good it is, for there may be an edge
            // between.
            let Rise { norm, gradient, scale } = one.rise(setting.origin.along(t, d));
            let step = (t.all(1.0) - norm) * scale * recip(gradient.dot(d));
            let most = lane(&hits.error) * setting.inverse_t_scale;
            let normal = to_normal.image(gradient);
            let square = normal.dot(normal);
            let is_near = step.abs().le(most) & gradient.dot(d).lt(t.all(0.0));
            let is_told = is_near & t.all(SQUARES[0]).lt(square) & square.lt(t.all(SQUARES[1]));
            let is_told = is_told & Mask::of_bits(simd, wanted);
            let inverse = square.rsqrt();
            let place = (t + step) * setting.t_scale;
            is_told.put(place, &mut S::as_mut_simd_f32s(&mut surfaces.t.0).0[i]);
            is_told.put(lane(&hits.error), &mut S::as_mut_simd_f32s(&mut surfaces.error.0).0[i]);
            for (axis, part) in [normal.x, normal.y, normal.z].into_iter().enumerate() {
                let column = &mut surfaces.normal[axis].0;
                is_told.put(part * inverse, &mut S::as_mut_simd_f32s(column).0[i]);
            }
            let old_ids = S::as_simd_u32s(&surfaces.id.0).0[i];
            let ids = is_told.select_u32(S::as_simd_u32s(&hits.id.0).0[i], old_ids);
            S::as_mut_simd_u32s(&mut surfaces.id.0).0[i] = ids;
            surfaces.lanes |= is_told.bits() << first;
        }
    }
}

struct OccludeKernel<'a> {
    shape: &'a BeamShape,
    directions: &'a [PacketVectors],
    hits: &'a [PacketHits],
    crowd: &'a mut Crowd,
    mask: u32,
}

/// [`OccludeKernel`] with the lanes.
struct Occlude<'a, S: Simd>(S, OccludeKernel<'a>);

impl WithSimd for OccludeKernel<'_> {
    type Output = Occlusion;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Occlusion {
        with_norm(simd, self.shape.xy, self.shape.rz, Occlude(simd, self))
    }
}

/// Ends of rays are known to this part of their t.
const END: f32 = 4e-6;

impl<S: Simd> WithNorm<S> for Occlude<'_, S> {
    type Output = Occlusion;

    #[inline(always)]
    fn run(mut self, one: impl Evaluate<S>, many: impl Evaluate<S, SIDE_BY_SIDE>) -> Occlusion {
        let simd = self.0;
        let setting = Setting::new(simd, self.1.shape);
        let OccludeKernel { directions, hits, crowd, mask, .. } = &mut self.1;
        crowd.clear();
        for packet in bits(*mask) {
            for i in 0..PACKET / S::F32_LANES {
                let v = Triple::of_packet(simd, &directions[packet], i);
                let end = Lanes::new(simd, S::as_simd_f32s(&hits[packet].t.0).0[i]);
                let end = end * setting.inverse_t_scale * end.all(1.0 + END);
                if let Some(approach) = setting.approach(v, || end) {
                    crowd.push(packet, i, &approach);
                }
            }
        }
        let count = crowd.close::<S>();
        for register in (0..count).step_by(SIDE_BY_SIDE) {
            if register + 1 < count {
                self.enter(many, &setting, register);
            } else {
                self.enter(one, &setting, register);
            }
        }
        let mut answer = Occlusion { packets: 0, hit: [0; MOST_PACKETS], doubt: [0; MOST_PACKETS] };
        let mut place = 0;
        while let Some(origin) = self.1.crowd.origin(place) {
            self.answer(origin, &setting, &mut answer);
            place += 1;
        }
        answer
    }
}

impl<S: Simd> Occlude<'_, S> {
    /// Sends the rays of some registers of the crowd into the shape.
    #[inline(always)]
    fn enter<const K: usize>(&mut self, norm: impl Evaluate<S, K>, setting: &Setting<S>, register: usize) {
        let Self(simd, OccludeKernel { shape, crowd, .. }) = self;
        let tolerance = Lanes::splat(*simd, shape.tolerance);
        let (near, passage) = crowd.passage(setting.origin, register);
        let Entry { s, inside, touched } = entries(norm, &passage, tolerance);
        let place = near.all(0.5).mul_add(passage.length, near + s);
        let place = inside.select(place, near.all(f32::INFINITY));
        let doubt = (touched | inside).select(near.all(-1.0), near.all(0.0));
        crowd.put(register, [place, doubt]);
    }

    /// What the crowd knows of the rays of a register.
    #[inline(always)]
    fn answer(&self, origin: Origin, setting: &Setting<S>, answer: &mut Occlusion) {
        let Self(simd, OccludeKernel { hits, crowd, .. }) = self;
        let Origin { packet, register: i, lanes, .. } = origin;
        let [place, doubt] = crowd.found(*simd, origin);
        // A place inside that is nearer than the end is proof; one at the end is not.
        let end = Lanes::new(*simd, S::as_simd_f32s(&hits[packet].t.0).0[i]);
        let end = end * setting.inverse_t_scale * end.all(1.0 - END);
        let certain = place.lt(end).bits() & lanes;
        let doubt = doubt.lt(place.all(0.0)).bits() & lanes & !certain;
        answer.packets |= 1 << packet;
        answer.hit[packet] |= certain << (i * S::F32_LANES);
        answer.doubt[packet] |= doubt << (i * S::F32_LANES);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Numbers that are the same on every run, in [0, 1).
    fn numbers() -> impl FnMut() -> f32 {
        let mut state = 1u32;
        move || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) as f32 / (1 << 24) as f32
        }
    }

    #[test]
    fn kernels_tell_the_same_with_one_lane_and_with_many() {
        let mut next = numbers();
        for round in 0..50 {
            let mut hits = PacketHits::up_to(f32::INFINITY);
            for lane in 0..PACKET {
                if next() < 0.8 {
                    hits.t.0[lane] = 10.0 * next();
                    hits.error.0[lane] = 0.01 * next();
                    hits.id.0[lane] = (4.0 * next()) as u32;
                    hits.doubt.0[lane] = f32::from(u8::from(next() < 0.2));
                }
            }
            let width = Widening { width: 0.001, spread: 0.0008 };
            let asked = if round % 2 == 0 { 0xffff } else { 0x3a7c };
            let one = CandidateKernel { hits: &hits, asked, width }.with_simd(pulp::Scalar);
            let many = Kernels::default().candidates(&hits, asked, width);
            let told = |met: &PacketCandidates| {
                (met.doubtful, met.near, met.ids[..met.count].to_vec(), met.lanes[..met.count].to_vec())
            };
            assert_eq!(told(&one), told(&many));
            assert_eq!(one.lanes.iter().fold(one.doubtful, |all, lanes| all | lanes) & !asked, 0);

            let strange = [0.0, -0.0, f64::NAN, 1e-300, 5e-324, -1.0];
            let mut vector = || {
                let mut column = || {
                    PacketOf(std::array::from_fn(|_| {
                        let x = next();
                        if x < 0.2 { strange[(30.0 * x) as usize] } else { f64::from(next()) - 0.4 }
                    }))
                };
                [column(), column(), column()]
            };
            let directions = [vector(), vector(), vector()];
            let (mut of_one, mut of_many) = (Vec::new(), Vec::new());
            let one =
                DirectionKernel { directions: &directions, scaled: &mut of_one }.with_simd(pulp::Scalar);
            let many = Kernels::default().directions(&directions, &mut of_many);
            assert_eq!(format!("{one:?} {of_one:?}"), format!("{many:?} {of_many:?}"));
            let (mut hits, mut ends) = ([hits; 3], NumberOfPackets::splat(7.0));
            let (mut more_hits, mut more_ends) = (hits, ends);
            let one = StartKernel { directions: &mut of_one, hits: &mut hits, ends: &mut ends, t_max: 3.0 }
                .with_simd(pulp::Scalar);
            let many = Kernels::default().start(&mut of_many, &mut more_hits, &mut more_ends, 3.0);
            let told = |directions: &[PacketVectors], hits: &[PacketHits; 3], ends, boxes| {
                format!("{directions:?} {hits:?} {ends:?} {boxes:?}")
            };
            assert_eq!(told(&of_one, &hits, ends, one), told(&of_many, &more_hits, more_ends, many));
            let has_ray = hits.iter().flat_map(|hits| hits.t.0).filter(|t| *t > 0.0).count();
            assert!(has_ray > 10 && of_one.iter().flatten().flat_map(|column| column.0).all(f32::is_finite));
        }
    }

    #[test]
    fn whole_beams_meet_the_same_with_one_lane_and_with_many() {
        let mut next = numbers();
        let (mut met, mut stopped) = (0, 0);
        for e in [0.0001, 0.3, 1.0, 2.0] {
            let exponents = crate::Exponents::new(e, 0.7).unwrap();
            let one: [[f32; 3]; 3] =
                std::array::from_fn(|i| std::array::from_fn(|j| f32::from(u8::from(i == j))));
            let shape = BeamShape::new(&Superquadric::unit(exponents), one, [0.3, -0.2, 9.0], 2e-6, 1.0);
            let directions: Vec<PacketVectors> = (0..MOST_PACKETS)
                .map(|_| {
                    let mut side = || PacketOf(std::array::from_fn(|_| 0.3 * next() - 0.15));
                    [side(), side(), PacketOf::splat(-1.0)]
                })
                .collect();
            let (mut of_one, mut of_many) = (vec![PacketHits::up_to(30.0); MOST_PACKETS], Vec::new());
            of_many.clone_from(&of_one);
            let (mut ends, mut more_ends) = (NumberOfPackets::splat(30.0), NumberOfPackets::splat(30.0));
            let (shape, directions, mask, id) = (&shape, directions.as_slice(), u32::MAX, 5);
            let mut crowd = Crowd::default();
            let stops = [
                OccludeKernel { shape, directions, hits: &of_one, crowd: &mut crowd, mask }
                    .with_simd(pulp::Scalar),
                Kernels::default().occlude(shape, directions, &of_one, &mut crowd, mask),
            ];
            let (hits, ends) = (of_one.as_mut_slice(), &mut ends);
            let better = MeetKernel { shape, directions, hits, ends, crowd: &mut crowd, mask, id }
                .with_simd(pulp::Scalar);
            let more_better = Kernels::default().meet(
                shape,
                directions,
                &mut of_many,
                &mut more_ends,
                &mut crowd,
                mask,
                id,
            );
            assert_eq!(better, more_better);
            for (packet, (one, many)) in of_one.iter().zip(&of_many).enumerate() {
                assert!((ends.0[packet] - more_ends.0[packet]).abs() < 1e-3);
                assert_eq!(ends.0[packet], one.end());
                for lane in 0..PACKET {
                    assert_eq!(one.id.0[lane], many.id.0[lane]);
                    let off = (one.t.0[lane] - many.t.0[lane]).abs();
                    assert!(off <= one.error.0[lane] + many.error.0[lane]);
                    met += u32::from(one.id.0[lane] == id);
                    let told = stops.each_ref().map(|stop| {
                        let is = |lanes: &[u32; MOST_PACKETS]| {
                            stop.packets >> packet & 1 == 1 && lanes[packet] >> lane & 1 == 1
                        };
                        (is(&stop.hit), is(&stop.doubt))
                    });
                    let [(hit, doubt), (more_hit, more_doubt)] = told;
                    assert!(hit == more_hit || doubt || more_doubt);
                    assert!(one.id.0[lane] != id || hit || doubt);
                    stopped += u32::from(hit);
                }
            }
        }
        assert!(met > 800 && stopped > 800 && met < 2_000, "{met} {stopped}");
    }

    #[test]
    fn bundles_hold_the_reciprocals_of_their_rays_and_are_little_wider() {
        let mut next = numbers();
        let (mut told, mut missed) = (0, 0);
        for round in 0..200 {
            // Packets from narrow ones to such as look to all sides, along an axis now and then.
            let width = [1e-6, 1e-3, 0.1, 3.0][round % 4];
            let mut packet = || {
                let middle = [next() - 0.5, next() - 0.5, if next() < 0.3 { 0.0 } else { next() }];
                middle.map(|x| PacketOf(std::array::from_fn(|_| x + width * (next() - 0.5))))
            };
            let mut directions = [packet(), packet(), packet()];
            let columns: [[f32; 3]; 3] =
                std::array::from_fn(|_| std::array::from_fn(|_| 30.0 * next() - 15.0));
            let mut hits = [PacketHits::up_to(1.0); 3];
            let mut ends = NumberOfPackets::splat(0.0);
            let boxes = Kernels::default().start(&mut directions, &mut hits, &mut ends, 1.0);
            let mut inverses = [[PacketOf::splat(0.0); 3]; 3];
            let bundles = Kernels::default().bundles(&columns, &directions, &boxes, 0b111, &mut inverses);
            for (packet, inverses) in inverses.iter().enumerate() {
                for (axis, inverses) in inverses.iter().enumerate() {
                    let (least, largest) = (bundles.least[axis].0[packet], bundles.largest[axis].0[packet]);
                    let (mut low, mut high) = (f32::INFINITY, f32::NEG_INFINITY);
                    for inverse in inverses.0 {
                        assert!(least <= inverse && inverse <= largest, "{least} {inverse} {largest}");
                        (low, high) = (low.min(inverse), high.max(inverse));
                    }
                    let is_narrow = largest.abs().max(least.abs()) < ENDLESS && width < 0.01;
                    told += u32::from(is_narrow);
                    missed +=
                        u32::from(is_narrow && largest - least > 4.0 * (high - low) + 1e-4 * high.abs());
                }
            }
        }
        assert!(told > 600 && missed < told / 50, "{missed} of {told}");
    }
}
