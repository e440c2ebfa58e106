//! Rays that share an origin, by the packet: against boxes, and against convex shapes.
//!
//! What is found here is a candidate. Directions and maps are rounded to f32, so a shape is met at the level 1 + tolerance of N, and the caller
//! settles in f64 what lies within the tolerance. No shape is missed.

use pulp::{Arch, Simd, WithSimd};

use super::kernel::{BOX, CLOSE, Evaluate, General, Pair, Square, Sum, TINY, Triple};
use super::log_norm::LogNorm;
use super::vector::Lanes;
use super::{PowerKind, lane_power};
use crate::superquadric::Superquadric;

/// Rays in a packet.
pub const PACKET: usize = 16;

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

/// The largest distance of a point of the unit shape from its centre, or a little more: for p, q >= 2 by Hölder's inequality.
fn reach(p: f32, q: f32) -> f32 {
    let across = if p > 2.0 { 2f32.powf(1.0 - 2.0 / p) } else { 1.0 };
    let squared = if q > 2.0 {
        let dual = q / (q - 2.0);
        (across.powf(dual) + 1.0).powf(1.0 / dual)
    } else {
        across
    };
    1.0001 * squared.sqrt()
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

/// The answer of [`Kernels::occlude`] for a packet: 1 where it is so, 0 elsewhere.
#[derive(Clone, Copy, Debug)]
pub struct PacketOcclusion {
    /// The shape is crossed, for certain.
    pub hit: PacketOf<f32>,
    /// It cannot be told.
    pub doubt: PacketOf<f32>,
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
    /// Which packets meet which boxes: bit i of an answer stands for packet i. `mask` has the packets to ask; `inverse` their reciprocal directions.
    pub fn boxes(
        self,
        boxes: &BeamBoxes<'_>,
        inverse: &[PacketVectors],
        hits: &[PacketHits],
        mask: u32,
    ) -> [u32; 8] {
        self.0.dispatch(BoxKernel { boxes, inverse, hits, mask })
    }

    /// The closest crossings of one shape, taken as candidate `id`. Returns the packets in which one became the best.
    pub fn meet(
        self,
        shape: &BeamShape,
        directions: &[PacketVectors],
        hits: &mut [PacketHits],
        mask: u32,
        id: u32,
    ) -> u32 {
        self.0.dispatch(MeetKernel { shape, directions, hits, mask, id })
    }

    /// Which rays of one packet cross the shape before their end, which is the t in `hits`.
    pub fn occlude(
        self,
        shape: &BeamShape,
        directions: &PacketVectors,
        t_max: &PacketOf<f32>,
    ) -> PacketOcclusion {
        self.0.dispatch(OccludeKernel { shape, directions, t_max })
    }

    /// The images of directions under a linear map, and the reciprocals of their coordinates.
    pub fn transform(
        self,
        columns: &[[f32; 3]; 3],
        directions: &[PacketVectors],
        images: &mut [PacketVectors],
        inverse: &mut [PacketVectors],
    ) {
        self.0.dispatch(TransformKernel { columns, directions, images, inverse });
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
    inverse: &'a [PacketVectors],
    hits: &'a [PacketHits],
    mask: u32,
}

impl WithSimd for BoxKernel<'_> {
    type Output = [u32; 8];

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> [u32; 8] {
        let Self { boxes, inverse, hits, mask } = self;
        let mut met = [0; 8];
        let registers = PACKET / S::F32_LANES;
        let t_scale = Lanes::<S>::splat(simd, boxes.t_scale);
        for (child, met) in met.iter_mut().enumerate().take(boxes.count) {
            let slab = |axis: usize| {
                let (origin, pad) = (boxes.origin[axis], boxes.pad[axis]);
                (
                    Lanes::<S>::splat(simd, boxes.bounds[axis][child] - origin - pad),
                    Lanes::<S>::splat(simd, boxes.bounds[axis + 3][child] - origin + pad),
                )
            };
            let slabs = [slab(0), slab(1), slab(2)];
            for packet in bits(mask) {
                for i in 0..registers {
                    let lane = |column: &PacketOf<f32>| Lanes::new(simd, S::as_simd_f32s(&column.0).0[i]);
                    let mut near = t_scale.all(0.0);
                    let mut far = lane(&hits[packet].t) * t_scale;
                    for axis in 0..3 {
                        let inverse = lane(&inverse[packet][axis]);
                        let (a, b) = (slabs[axis].0 * inverse, slabs[axis].1 * inverse);
                        near = near.max(a.min(b));
                        far = far.min(a.max(b));
                    }
                    if near.le(far).any() {
                        *met |= 1 << packet;
                        break;
                    }
                }
            }
        }
        met
    }
}

struct TransformKernel<'a> {
    columns: &'a [[f32; 3]; 3],
    directions: &'a [PacketVectors],
    images: &'a mut [PacketVectors],
    inverse: &'a mut [PacketVectors],
}

/// A linear map in every lane.
#[derive(Clone, Copy)]
struct Linear<S: Simd>([Triple<S>; 3]);

impl<S: Simd> Linear<S> {
    #[inline(always)]
    fn splat(simd: S, columns: &[[f32; 3]; 3]) -> Self {
        Self(columns.map(|[x, y, z]| Triple {
            x: Lanes::splat(simd, x),
            y: Lanes::splat(simd, y),
            z: Lanes::splat(simd, z),
        }))
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
        let one = self.x.all(1.0);
        let of = |x: Lanes<S>| one / x.abs().max(x.all(TINY)).with_sign_of(x);
        Self { x: of(self.x), y: of(self.y), z: of(self.z) }
    }
}

impl WithSimd for TransformKernel<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let map = Linear::splat(simd, self.columns);
        for ((direction, image), inverse) in self.directions.iter().zip(self.images).zip(self.inverse) {
            for i in 0..PACKET / S::F32_LANES {
                let v = map.image(Triple::of_packet(simd, direction, i));
                let reciprocal = v.recip();
                for (packet, v) in [(&mut *image, v), (&mut *inverse, reciprocal)] {
                    for (column, lanes) in packet.iter_mut().zip([v.x, v.y, v.z]) {
                        S::as_mut_simd_f32s(&mut column.0).0[i] = lanes.register;
                    }
                }
            }
        }
    }
}

struct MeetKernel<'a> {
    shape: &'a BeamShape,
    directions: &'a [PacketVectors],
    hits: &'a mut [PacketHits],
    mask: u32,
    id: u32,
}

impl WithSimd for MeetKernel<'_> {
    type Output = u32;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> u32 {
        match (self.shape.xy, self.shape.rz) {
            (PowerKind::Two, PowerKind::Two) => self.run(simd, Pair(Square, Square)),
            (PowerKind::Two, PowerKind::General(q)) => self.run(simd, Pair(Square, General::splat(simd, q))),
            (PowerKind::General(p), PowerKind::Two) => self.run(simd, Pair(General::splat(simd, p), Square)),
            (PowerKind::One, PowerKind::One) => self.run(simd, Pair(Sum, Sum)),
            (PowerKind::Two, PowerKind::One) => self.run(simd, Pair(Square, Sum)),
            (PowerKind::One, PowerKind::Two) => self.run(simd, Pair(Sum, Square)),
            (xy, rz) => {
                self.run(simd, LogNorm::new(Lanes::splat(simd, xy.power()), Lanes::splat(simd, rz.power())))
            }
        }
    }
}

/// Steps of Newton's method before what is left goes to f64: grazing rays.
const MOST_STEPS: usize = 10;

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
        let triple = |of: &dyn Fn(f32) -> f32| {
            let [x, y, z] = shape.origin.map(of);
            Triple { x: splat(x), y: splat(y), z: splat(z) }
        };
        let half = BOX + shape.tolerance;
        let reach = shape.reach + 2.0 * shape.tolerance;
        Self {
            map: Linear::splat(simd, &shape.columns),
            origin: triple(&|x| x),
            lesser: triple(&|x| -half - x),
            larger: triple(&|x| half - x),
            reach_squared: splat(1.000_01 * reach * reach),
            t_scale: splat(shape.t_scale),
            inverse_t_scale: splat(1.0 / shape.t_scale),
        }
    }

    /// Which rays come near enough to the centre: the distance of a line is that of |o x d| / |d|.
    #[inline(always)]
    fn is_near(&self, d: Triple<S>) -> super::vector::Mask<S> {
        let o = self.origin;
        let cross = Triple { x: o.y * d.z - o.z * d.y, y: o.z * d.x - o.x * d.z, z: o.x * d.y - o.y * d.x };
        cross.dot(cross).le(self.reach_squared * d.dot(d))
    }

    /// The part of the rays in the box.
    #[inline(always)]
    fn span(&self, d: Triple<S>, t_max: Lanes<S>) -> (Lanes<S>, Lanes<S>) {
        let inverse = d.recip();
        let (mut near, mut far) = (t_max.all(0.0), t_max);
        for (lesser, larger, inverse) in [
            (self.lesser.x, self.larger.x, inverse.x),
            (self.lesser.y, self.larger.y, inverse.y),
            (self.lesser.z, self.larger.z, inverse.z),
        ] {
            let (a, b) = (lesser * inverse, larger * inverse);
            near = near.max(a.min(b));
            far = far.min(a.max(b));
        }
        (near, far)
    }
}

impl MeetKernel<'_> {
    #[inline(always)]
    fn run<S: Simd>(self, simd: S, norm: impl Evaluate<S>) -> u32 {
        let Self { shape, directions, hits, mask, id } = self;
        let setting = Setting::new(simd, shape);
        let level = Lanes::<S>::splat(simd, 1.0 + shape.tolerance);
        let (zero, one, infinity) = (level.all(0.0), level.all(1.0), level.all(f32::INFINITY));
        let close = level.all(CLOSE);
        let slack = level.all(2.0 * shape.tolerance + CLOSE);
        let mut better = 0;
        for packet in bits(mask) {
            let hits = &mut hits[packet];
            for i in 0..PACKET / S::F32_LANES {
                let d = setting.map.image(Triple::of_packet(simd, &directions[packet], i));
                let is_near = setting.is_near(d);
                if !is_near.any() {
                    continue;
                }
                let best = Lanes::new(simd, S::as_simd_f32s(&hits.t.0).0[i]);
                let best_error = Lanes::new(simd, S::as_simd_f32s(&hits.error.0).0[i]);
                let (near, far) = setting.span(d, (best + best_error) * setting.inverse_t_scale);
                let mut active = is_near & near.le(far);
                if !active.any() {
                    continue;
                }
                let start = setting.origin.along(near, d);
                let length = far - near;
                let mut s = zero;
                let mut steepness = one;
                let mut hit = zero.lt(zero);
                for _ in 0..MOST_STEPS {
                    let (value, slope) = norm.evaluate(start.along(s, d), d);
                    let above = value - level;
                    let falls = slope.lt(zero);
                    let arrived = active & above.le(close);
                    hit = hit | arrived;
                    steepness = arrived.select(slope, steepness);
                    active = (active & falls).and_not(arrived);
                    s = active.select(s - above / slope, s);
                    active = active & s.le(length);
                    if !active.any() {
                        break;
                    }
                }
                let found = hit | active;
                if !found.any() {
                    continue;
                }
                let t = found.select((near + s) * setting.t_scale, infinity);
                // t may be off by as much as N over its slope, and by the rounding of t.
                let rounding = t.all(4e-7) * t;
                let error = (slack / steepness.abs().max(t.all(TINY))).mul_add(setting.t_scale, rounding);
                let doubt = active.select(one, zero);
                let ids = simd.splat_u32s(id);
                // The rule of `PacketHits::take`, for all lanes.
                let lane = |column: &PacketOf<f32>| Lanes::new(simd, S::as_simd_f32s(&column.0).0[i]);
                let (old_error, old_doubt) = (lane(&hits.error), lane(&hits.doubt));
                let is_closer = found & t.lt(best);
                let is_near = found & (t - best).abs().le(error + old_error);
                let doubt = is_near.select(one, is_closer.select(doubt, old_doubt));
                S::as_mut_simd_f32s(&mut hits.doubt.0).0[i] = doubt.register;
                S::as_mut_simd_f32s(&mut hits.t.0).0[i] = is_closer.select(t, best).register;
                S::as_mut_simd_f32s(&mut hits.error.0).0[i] = is_closer.select(error, old_error).register;
                let old_ids = S::as_simd_u32s(&hits.id.0).0[i];
                S::as_mut_simd_u32s(&mut hits.id.0).0[i] = is_closer.select_u32(ids, old_ids);
                if is_closer.any() {
                    better |= 1 << packet;
                }
            }
        }
        better
    }
}

struct OccludeKernel<'a> {
    shape: &'a BeamShape,
    directions: &'a PacketVectors,
    t_max: &'a PacketOf<f32>,
}

impl WithSimd for OccludeKernel<'_> {
    type Output = PacketOcclusion;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> PacketOcclusion {
        match (self.shape.xy, self.shape.rz) {
            (PowerKind::Two, PowerKind::Two) => self.run(simd, Pair(Square, Square)),
            (PowerKind::Two, PowerKind::General(q)) => self.run(simd, Pair(Square, General::splat(simd, q))),
            (PowerKind::General(p), PowerKind::Two) => self.run(simd, Pair(General::splat(simd, p), Square)),
            (PowerKind::One, PowerKind::One) => self.run(simd, Pair(Sum, Sum)),
            (PowerKind::Two, PowerKind::One) => self.run(simd, Pair(Square, Sum)),
            (PowerKind::One, PowerKind::Two) => self.run(simd, Pair(Sum, Square)),
            (xy, rz) => {
                self.run(simd, LogNorm::new(Lanes::splat(simd, xy.power()), Lanes::splat(simd, rz.power())))
            }
        }
    }
}

/// Ends of rays are known to this part of their t.
const END: f32 = 4e-6;

impl OccludeKernel<'_> {
    #[inline(always)]
    fn run<S: Simd>(self, simd: S, norm: impl Evaluate<S>) -> PacketOcclusion {
        let Self { shape, directions, t_max } = self;
        let setting = Setting::new(simd, shape);
        let splat = |x: f32| Lanes::<S>::splat(simd, x);
        let (zero, one) = (splat(0.0), splat(1.0));
        let (outside, inside) = (splat(1.0 + shape.tolerance), splat(1.0 - shape.tolerance));
        let close = splat(CLOSE);
        let mut answer = PacketOcclusion { hit: PacketOf::splat(0.0), doubt: PacketOf::splat(0.0) };
        for i in 0..PACKET / S::F32_LANES {
            let d = setting.map.image(Triple::of_packet(simd, directions, i));
            let is_near = setting.is_near(d);
            if !is_near.any() {
                continue;
            }
            let end = Lanes::new(simd, S::as_simd_f32s(&t_max.0).0[i]) * setting.inverse_t_scale;
            let (near, far) = setting.span(d, end * splat(1.0 + END));
            let mut active = is_near & near.le(far);
            if !active.any() {
                continue;
            }
            // From the middle of the way through the box downhill, whichever way that is: a convex function has its least value there. First to
            // the level at which the shape can no longer be missed, then on to the one at which it is met for certain.
            let middle = splat(0.5) * (near + far);
            let start = setting.origin.along(middle, d);
            let half = splat(0.5) * (far - near);
            let mut s = zero;
            let mut downhill = one;
            let mut hit = zero.lt(zero);
            let mut touched = hit;
            for step in 0..MOST_STEPS {
                let (value, slope) = norm.evaluate(start.along(s, d), d);
                if step == 0 {
                    downhill = (-one).times_sign_of(slope);
                }
                let arrived = active & value.le(inside);
                touched = touched | (active & value.le(outside + close));
                let level = touched.select(inside - close, outside);
                hit = hit | arrived;
                // The slope still leads downhill.
                let falls = (slope * downhill).lt(zero);
                active = (active & falls).and_not(arrived);
                s = active.select(s - (value - level) / slope, s);
                active = active & s.abs().le(half);
                if !active.any() {
                    break;
                }
            }
            // A place inside that is nearer than the end is proof; one at the end is not.
            let certain = hit & (middle + s).lt(end * splat(1.0 - END));
            let doubt = (active | touched | hit).and_not(certain);
            S::as_mut_simd_f32s(&mut answer.hit.0).0[i] = certain.select(one, zero).register;
            S::as_mut_simd_f32s(&mut answer.doubt.0).0[i] = doubt.select(one, zero).register;
        }
        answer
    }
}
