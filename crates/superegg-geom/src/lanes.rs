//! Rays against convex superquadrics in f32 lanes: eight at a time with AVX2, sixteen with AVX-512, four with NEON, chosen when the program
//! runs.
//!
//! The method is that of `convex.rs`. Rays are prepared in f64: each is brought into the space of its unit shape and its origin moved
//! along it to the place nearest the centre, so that f32 holds all that matters however far the ray comes from. The answers are those of
//! the f64 path to a few 1e-6 of the shape's radius, measured across the surface; about hit or miss the two may differ where
//! the ray passes within 1e-5 of tangency.

pub mod beam;
pub mod crowd;
mod descent;
pub mod flight;
mod kernel;
mod log_norm;
pub mod settle;
pub mod vector;

use glam::DVec3;
use pulp::{Arch, Simd, WithSimd};

use crate::math::ray::{Ray, RayStart};
use crate::shape::ShapeHit;
use crate::superquadric::Superquadric;
use kernel::{Kernel, Powers};

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

/// A power as the kernel treats it.
#[derive(Clone, Copy, Debug, PartialEq)]
enum PowerKind {
    One,
    Two,
    General(f32),
}

impl PowerKind {
    fn of(p: f64) -> Self {
        match p {
            1.0 => Self::One,
            2.0 => Self::Two,
            _ => Self::General(lane_power(p)),
        }
    }

    fn power(self) -> f32 {
        match self {
            Self::One => 1.0,
            Self::Two => 2.0,
            Self::General(p) => p,
        }
    }
}

/// A power in f32. Beyond 1e9 f32 cannot tell the norm from the larger argument.
fn lane_power(p: f64) -> f32 {
    p.min(1e9) as f32
}

/// The powers of a shape as lanes take them: 2/e and 2/n, and those of a shape that is not convex are [`NO_LANE_POWERS`].
pub fn lane_powers(shape: &Superquadric) -> [f32; 2] {
    let norm = shape.norm();
    if shape.is_convex() { [lane_power(norm.xy.p), lane_power(norm.rz.p)] } else { NO_LANE_POWERS }
}

/// Of a shape that is not convex, which lanes do not take.
pub const NO_LANE_POWERS: [f32; 2] = [0.0; 2];

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
            let (mut wide, mut narrow, mut eight) =
                (LaneHits::default(), LaneHits::default(), LaneHits::default());
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
            kernel(&mut narrow).with_simd(pulp::Scalar);
            eight.clone_from(&wide);
            #[cfg(target_arch = "x86_64")]
            if let Some(avx2) = pulp::x86::V3::try_new() {
                Simd::vectorize(avx2, kernel(&mut eight));
            }
            for other in [&narrow, &eight] {
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
