//! Newton's method on the norm form in lanes: `convex.rs` for many rays at a time. No picture uses it.

use glam::DVec3;
use superegg_simd::{Arch, Lanes, Simd, Triple, WithSimd};

use super::norm::{BOX, CLOSE, Norm2, Square, Sum, TINY};
use super::powers::{PowerKind, lane_power};
use crate::math::ray::{Ray, RayStart};
use crate::shape::ShapeHit;
use crate::superquadric::Superquadric;

/// The widest register has so many lanes; batches are padded to a multiple of it.
const WIDEST: usize = 16;

/// Rays in the spaces of their unit shapes, a column for each coordinate.
#[derive(Clone, Debug, Default)]
pub struct LaneRays {
    origin: [Vec<f32>; 3],
    direction: [Vec<f32>; 3],
    /// Where the ray begins, seen from the moved origin.
    t_min: Vec<f32>,
    /// What brings a lane's t back to the ray's: `anchor + scale * t`.
    anchor: Vec<f64>,
    scale: Vec<f64>,
    count: usize,
}

/// The answers for a batch of rays, one for each ray.
#[derive(Clone, Debug, Default)]
pub struct LaneHits {
    t: Vec<f32>,
    leaving: Vec<f32>,
    steps: Vec<f32>,
}

/// The powers of many convex shapes, for batches in which each ray has a shape of its own.
#[derive(Clone, Debug, Default)]
pub struct LanePowers {
    p: Vec<f32>,
    q: Vec<f32>,
}

impl LanePowers {
    /// Takes the powers of the next ray's shape.
    pub fn push(&mut self, shape: &Superquadric) {
        self.p.push(lane_power(shape.norm().xy.p));
        self.q.push(lane_power(shape.norm().rz.p));
    }

    /// Forgets all, and keeps the memory.
    pub fn clear(&mut self) {
        self.p.clear();
        self.q.clear();
    }
}

impl LaneRays {
    /// How many rays there are.
    pub fn len(&self) -> usize {
        self.count
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// Forgets all rays, and keeps the memory.
    pub fn clear(&mut self) {
        for column in self.origin.iter_mut().chain(&mut self.direction) {
            column.clear();
        }
        self.t_min.clear();
        self.anchor.clear();
        self.scale.clear();
        self.count = 0;
    }

    /// Adds a ray, given in the space of the shape that it will meet. One that is not finite, or has no direction, will hit nothing.
    pub fn push(&mut self, shape: &Superquadric, ray: &Ray) {
        self.truncate_padding();
        let inverse_radii = shape.radii().recip();
        let (origin, direction) = (ray.origin * inverse_radii, ray.direction * inverse_radii);
        let length = direction.length();
        let direction = direction / length;
        let anchor = (-origin.dot(direction)).max(0.0);
        let near = origin + anchor * direction;
        if near.is_finite() && direction.is_finite() {
            self.push_lane(near, direction, -anchor as f32);
        } else {
            self.push_miss();
        }
        self.anchor.push(anchor / length);
        self.scale.push(1.0 / length);
        self.count += 1;
    }

    fn push_lane(&mut self, origin: DVec3, direction: DVec3, t_min: f32) {
        for axis in 0..3 {
            self.origin[axis].push(origin[axis] as f32);
            self.direction[axis].push(direction[axis] as f32);
        }
        self.t_min.push(t_min);
    }

    /// A lane that hits nothing.
    fn push_miss(&mut self) {
        self.push_lane(DVec3::splat(9.0), DVec3::ONE, 0.0);
    }

    fn truncate_padding(&mut self) {
        for column in self.origin.iter_mut().chain(&mut self.direction) {
            column.truncate(self.count);
        }
        self.t_min.truncate(self.count);
    }

    /// Fills the last register.
    fn pad(&mut self) {
        while !self.t_min.len().is_multiple_of(WIDEST) {
            self.push_miss();
        }
    }

    /// All rays against one convex shape; the rays were pushed for this shape.
    pub fn intersect(&mut self, shape: &Superquadric, hits: &mut LaneHits) {
        debug_assert!(shape.is_convex());
        let norm = shape.norm();
        self.run(Powers::Uniform { xy: PowerKind::of(norm.xy.p), rz: PowerKind::of(norm.rz.p) }, hits);
    }

    /// Each ray against the convex shape it was pushed for: `powers` has theirs, in the same order. One ray against many shapes is this too.
    pub fn intersect_each(&mut self, powers: &mut LanePowers, hits: &mut LaneHits) {
        self.pad();
        powers.p.resize(self.t_min.len(), 1.0);
        powers.q.resize(self.t_min.len(), 1.0);
        self.run(Powers::Each { p: &powers.p, q: &powers.q }, hits);
        powers.p.truncate(self.count);
        powers.q.truncate(self.count);
    }

    fn run(&mut self, powers: Powers<'_>, hits: &mut LaneHits) {
        self.pad();
        for column in [&mut hits.t, &mut hits.leaving, &mut hits.steps] {
            column.resize(self.t_min.len(), 0.0);
        }
        Arch::new().dispatch(Kernel { powers, rays: self, hits });
    }

    /// The answer for ray `i` of the last batch: `t` in lengths of the ray's own direction, and whether it leads out.
    pub fn hit(&self, hits: &LaneHits, i: usize) -> Option<LaneHit> {
        let t = hits.t[i];
        (i < self.count && t.is_finite()).then(|| LaneHit {
            t: (self.anchor[i] + self.scale[i] * f64::from(t)).max(0.0),
            leaving: hits.leaving[i] > 0.0,
        })
    }
}

impl LaneHits {
    /// How many times N was evaluated for ray `i`.
    pub fn steps(&self, i: usize) -> u32 {
        self.steps[i] as u32
    }
}

/// How many rays are met at a time on this machine.
pub fn lanes_at_a_time() -> usize {
    struct Count;
    impl WithSimd for Count {
        type Output = usize;
        fn with_simd<S: Simd>(self, _: S) -> usize {
            S::F32_LANES
        }
    }
    Arch::new().dispatch(Count)
}

/// What the lanes tell of a crossing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LaneHit {
    /// The place on the ray, >= 0, in lengths of its direction.
    pub t: f64,
    /// Whether the ray goes out of the shape here.
    pub leaving: bool,
}

impl Superquadric {
    /// [`Superquadric::intersect`] for one ray by way of the lanes where the shape is convex, and by the certified search elsewhere. For comparing
    /// the two: a batch of one wastes the other lanes.
    pub fn intersect_fast(&self, ray: &Ray, start: RayStart) -> Option<ShapeHit> {
        if !self.is_convex() || start != RayStart::Free {
            return self.intersect(ray, start);
        }
        let (mut rays, mut hits) = (LaneRays::default(), LaneHits::default());
        rays.push(self, ray);
        rays.intersect(self, &mut hits);
        rays.hit(&hits, 0).map(|hit| ShapeHit { t: hit.t, point: ray.point_at(hit.t), leaving: hit.leaving })
    }
}

/// Convexity makes forty reach the last digit from a double root.
const MAX_STEPS: usize = 48;

/// Which exponents the rays of a batch meet.
enum Powers<'a> {
    /// The same for all.
    Uniform { xy: PowerKind, rz: PowerKind },
    /// A pair of powers for each ray.
    Each { p: &'a [f32], q: &'a [f32] },
}

/// The work on one batch.
struct Kernel<'a> {
    powers: Powers<'a>,
    rays: &'a LaneRays,
    hits: &'a mut LaneHits,
}

impl WithSimd for Kernel<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { powers, rays, hits } = self;
        match powers {
            Powers::Uniform { xy, rz } => match (xy, rz) {
                (PowerKind::Two, PowerKind::Two) => run(simd, rays, hits, |_| (Square, Square)),
                (PowerKind::One, PowerKind::One) => run(simd, rays, hits, |_| (Sum, Sum)),
                (PowerKind::Two, PowerKind::General(q)) => {
                    run(simd, rays, hits, |_| (Square, General::splat(simd, q)));
                }
                (PowerKind::General(p), PowerKind::Two) => {
                    run(simd, rays, hits, |_| (General::splat(simd, p), Square));
                }
                (PowerKind::Two, PowerKind::One) => run(simd, rays, hits, |_| (Square, Sum)),
                (PowerKind::One, PowerKind::Two) => run(simd, rays, hits, |_| (Sum, Square)),
                (xy, rz) => {
                    let general = |kind: PowerKind| General::splat(simd, kind.power());
                    run(simd, rays, hits, |_| (general(xy), general(rz)));
                }
            },
            Powers::Each { p, q } => {
                let (p, q) = (S::as_simd_f32s(p).0, S::as_simd_f32s(q).0);
                run(simd, rays, hits, |i| (General::new(simd, p[i]), General::new(simd, q[i])));
            }
        }
    }
}

/// Any p >= 1: `m (1 + r^p)^(1/p)` with the larger argument m taken out.
#[derive(Clone, Copy)]
struct General<S: Simd> {
    p: Lanes<S>,
    inverse_p: Lanes<S>,
}

impl<S: Simd> General<S> {
    #[inline(always)]
    fn new(simd: S, p: S::f32s) -> Self {
        let p = Lanes::new(simd, p);
        Self { p, inverse_p: p.all(1.0) / p }
    }

    #[inline(always)]
    fn splat(simd: S, p: f32) -> Self {
        Self::new(simd, simd.splat_f32s(p))
    }
}

impl<S: Simd> Norm2<S> for General<S> {
    #[inline(always)]
    fn value_and_gradient(self, a: Lanes<S>, b: Lanes<S>) -> (Lanes<S>, Lanes<S>, Lanes<S>) {
        let one = a.all(1.0);
        let larger = a.max(b).max(a.all(TINY));
        let ratio = (a.min(b) / larger).max(a.all(TINY));
        let power = (self.p * ratio.log2()).exp2();
        let sum = one + power;
        let growth = (self.inverse_p * sum.log2()).exp2();
        let by_larger = growth / sum;
        let by_smaller = by_larger * power / ratio;
        let a_is_larger = b.le(a);
        (
            larger * growth,
            a_is_larger.select(by_larger, by_smaller),
            a_is_larger.select(by_smaller, by_larger),
        )
    }
}

/// All registers of a batch.
#[inline(always)]
fn run<S: Simd, X: Norm2<S>, Z: Norm2<S>>(
    simd: S,
    rays: &LaneRays,
    hits: &mut LaneHits,
    norms: impl Fn(usize) -> (X, Z),
) {
    let t_min = S::as_simd_f32s(&rays.t_min).0;
    let out_t = S::as_mut_simd_f32s(&mut hits.t).0;
    let out_leaving = S::as_mut_simd_f32s(&mut hits.leaving).0;
    let out_steps = S::as_mut_simd_f32s(&mut hits.steps).0;
    for i in 0..out_t.len() {
        let (xy, rz) = norms(i);
        let origin = triple(simd, &rays.origin, i);
        let direction = triple(simd, &rays.direction, i);
        let (t, leaving, steps) = intersect(xy, rz, origin, direction, Lanes::new(simd, t_min[i]));
        out_t[i] = t.register();
        out_leaving[i] = leaving.register();
        out_steps[i] = steps.register();
    }
}

/// The first crossing with t >= `t_min` in each lane (infinity for none), 1 where it leads out, and the evaluations of N.
#[inline(always)]
fn intersect<S: Simd>(
    xy: impl Norm2<S>,
    rz: impl Norm2<S>,
    origin: Triple<S>,
    direction: Triple<S>,
    t_min: Lanes<S>,
) -> (Lanes<S>, Lanes<S>, Lanes<S>) {
    let zero = t_min.all(0.0);
    let one = t_min.all(1.0);
    let infinity = t_min.all(f32::INFINITY);

    // The span of the ray in the box, slab by slab. 0 / 0 is kept out by moving a zero component off zero.
    let (mut near, mut far) = (t_min, infinity);
    for (o, d) in [(origin.x, direction.x), (origin.y, direction.y), (origin.z, direction.z)] {
        let inverse = one / d.abs().max(t_min.all(TINY)).with_sign_of(d);
        let middle = -o * inverse;
        let half = inverse.abs() * t_min.all(BOX);
        near = near.max(middle - half);
        far = far.min(middle + half);
    }
    let mut active = near.le(far);
    let mut t_hit = infinity;
    let mut steps = zero;
    if !active.any() {
        return (t_hit, zero, steps);
    }

    // A start within the box may be inside: then the way is from the far side, backwards, to the exit.
    let mut start = origin.along(near, direction);
    let mut forward = direction;
    let mut inside = near.lt(near);
    let starts_here = active & near.le(t_min);
    if starts_here.any() {
        let (norm, _) = super::norm::evaluate(xy, rz, start, direction);
        steps = steps + starts_here.select(one, zero);
        inside = starts_here & norm.lt(one);
        let back = Triple { x: -direction.x, y: -direction.y, z: -direction.z };
        start = Triple::select(inside, origin.along(far, direction), start);
        forward = Triple::select(inside, back, forward);
    }

    let length = far - near;
    let close = t_min.all(CLOSE);
    let mut s = zero;
    let mut hit = near.lt(near);
    for _ in 0..MAX_STEPS {
        let (norm, slope) = super::norm::evaluate(xy, rz, start.along(s, forward), forward);
        steps = steps + active.select(one, zero);
        let above = norm - one;
        let falls = slope.lt(zero);
        // On the surface, coming from outside; or past it by rounding.
        let arrived = active & above.le(close) & (falls | zero.lt(s));
        hit = hit | arrived;
        active = (active & falls).and_not(arrived);
        let next = s - above / slope;
        s = active.select(next, s);
        active = active & next.le(length);
        if !active.any() {
            break;
        }
    }
    // Where rounding hides the exit of an inside start, it is the start itself.
    let s = hit.select(s, length);
    let t = inside.select((far - s).max(t_min), near + s);
    t_hit = (hit | inside).select(t, t_hit);
    (t_hit, inside.select(one, zero), steps)
}

#[inline(always)]
fn triple<S: Simd>(simd: S, columns: &[Vec<f32>; 3], i: usize) -> Triple<S> {
    Triple {
        x: Lanes::load(simd, &columns[0], i),
        y: Lanes::load(simd, &columns[1], i),
        z: Lanes::load(simd, &columns[2], i),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shape::Exponents;

    /// The same batch by one lane, and by whatever else the machine has.
    #[test]
    fn every_width_gives_the_same_answers() {
        for (e, n) in [(1.0, 1.0), (2.0, 2.0), (0.3, 1.7), (0.001, 0.5), (1.0, 0.2), (2.0, 1.0)] {
            let shape = Superquadric::new(DVec3::ONE, Exponents::new(e, n).unwrap()).unwrap();
            let mut rays = LaneRays::default();
            for i in 0..5000 {
                let angle = f64::from(i) * 0.7;
                let origin = DVec3::new(angle.sin(), (1.3 * angle).cos(), (0.6 * angle).sin())
                    * (0.5 + f64::from(i % 7));
                rays.push(&shape, &Ray::new(origin, DVec3::new(0.3, 0.2, 0.1) * angle.cos() - origin));
            }
            let (mut wide, mut narrow) = (LaneHits::default(), LaneHits::default());
            rays.intersect(&shape, &mut wide);
            let kernel = |hits| {
                let norm = shape.norm();
                Kernel {
                    powers: Powers::Uniform { xy: PowerKind::of(norm.xy.p), rz: PowerKind::of(norm.rz.p) },
                    rays: &rays,
                    hits,
                }
            };
            narrow.clone_from(&wide);
            kernel(&mut narrow).with_simd(superegg_simd::Scalar);
            {
                let other = &narrow;
                let different = (0..rays.len()).filter(|&i| {
                    let (a, b) = (rays.hit(&wide, i), rays.hit(other, i));
                    a.map(|hit| hit.leaving) != b.map(|hit| hit.leaving)
                        || a.zip(b).is_some_and(|(a, b)| (a.t - b.t).abs() > 1e-3)
                });
                assert!(different.count() <= 5, "{e} {n}");
            }
        }
    }
}
