//! The batch kernel against the f64 path: millions of rays in release, fewer without optimisation.

use rays::Random;
use superegg_geom::glam::DVec3;
use superegg_geom::kernels::batch;
use superegg_geom::{Exponents, Ray, RayStart, ShapeHit, Superquadric};

#[path = "../benches/rays/mod.rs"]
#[allow(dead_code, reason = "the benchmarks use the rest")]
mod rays;

impl Random {
    /// Special exponents and any of the convex range, evenly in their logarithm.
    fn exponent(&mut self) -> f64 {
        const SPECIAL: [f64; 8] = [0.0001, 0.001, 0.1, 0.5, 1.0, 1.5, 1.999, 2.0];
        if self.unit() < 0.5 {
            SPECIAL[(self.unit() * 8.0) as usize]
        } else {
            10f64.powf(self.unit() * 4.3 - 4.0)
        }
    }

    /// A ray of one of several kinds: near, inside, far, along an axis, in a coordinate plane, away.
    fn ray(&mut self) -> Ray {
        let kind = (self.unit() * 8.0) as u32;
        let target = self.within(1.1);
        let origin = match kind {
            0 => self.within(0.9),
            1 => self.within(100.0),
            2 => self.within(1e6),
            _ => self.within(4.0),
        };
        let mut direction = (target - origin).normalize();
        let mut origin = origin;
        match kind {
            3 => direction = DVec3::AXES[(self.unit() * 3.0) as usize],
            4 => (origin.y, direction.y) = (0.0, 0.0),
            5 => direction = -direction,
            6 => direction *= 10f64.powf(self.unit() * 12.0 - 6.0),
            _ => {}
        }
        Ray::new(origin, if direction == DVec3::ZERO { DVec3::X } else { direction })
    }
}

/// How near N comes to 1 at its least along the ray: N is convex there, so a search by thirds finds the least.
fn distance_from_tangency(shape: &Superquadric, ray: &Ray) -> f64 {
    let direction = ray.direction.normalize();
    let nearest = (-ray.origin.dot(direction)).max(0.0);
    let (mut low, mut high) = ((nearest - 2.0).max(0.0), nearest + 2.0);
    let value = |t: f64| shape.norm().value(ray.origin + t * direction);
    for _ in 0..200 {
        let (a, b) = (low + (high - low) / 3.0, high - (high - low) / 3.0);
        if value(a) < value(b) { high = b } else { low = a }
    }
    (value(low) - 1.0).abs()
}

/// The differences that lanes may have: hit or miss only within 1e-5 of tangency, the place by 1e-5 across the surface.
fn check(shape: &Superquadric, ray: &Ray, lanes: Option<ShapeHit>, exact: Option<ShapeHit>) {
    let context = || format!("{:?} {ray:?}: {lanes:?} for {exact:?}", shape.exponents());
    match (&lanes, &exact) {
        (None, None) => {}
        (Some(lane), Some(exact)) => {
            assert!(lane.t.is_finite() && lane.t >= 0.0, "{}", context());
            let from_surface = (shape.norm().value(ray.point_at(lane.t)) - 1.0).abs();
            assert!(from_surface < 1e-5, "{from_surface} off: {}", context());
            // The right one of the two crossings: the other is off by the length of the way between.
            let apart = (lane.t - exact.t).abs() * ray.direction.length();
            if lane.leaving != exact.leaving || apart > 0.02 + 1e-9 * exact.t {
                assert!(is_in_doubt(shape, ray), "{}", context());
            }
        }
        _ => assert!(is_in_doubt(shape, ray), "{}", context()),
    }
}

/// Whether the ray passes within 1e-5 of tangency, or starts so near the surface.
fn is_in_doubt(shape: &Superquadric, ray: &Ray) -> bool {
    (shape.norm().value(ray.origin) - 1.0).abs() < 1e-5 || distance_from_tangency(shape, ray) < 1e-5
}

/// How many shapes to draw; `SUPEREGG_LANE_SHAPES` makes a night of it, with other seeds.
fn shape_count() -> usize {
    let asked = std::env::var("SUPEREGG_LANE_SHAPES").ok().and_then(|word| word.parse().ok());
    asked.unwrap_or(if cfg!(debug_assertions) { 40 } else { 1000 })
}

const RAYS: usize = 2500;

#[test]
fn many_rays_against_one_shape_agree_with_the_f64_path() {
    let mut random = Random(3 + shape_count() as u64);
    let mut hits = Vec::new();
    for _ in 0..shape_count() {
        let exponents = Exponents::new(random.exponent(), random.exponent()).unwrap();
        let shape = Superquadric::new(DVec3::ONE, exponents).unwrap();
        let rays: Vec<Ray> = (0..RAYS + (random.unit() * 20.0) as usize).map(|_| random.ray()).collect();
        batch::intersect(&shape.as_convex().unwrap(), &rays, &mut hits);
        for (i, ray) in rays.iter().enumerate() {
            check(&shape, ray, hits[i], shape.intersect(ray, RayStart::Free));
        }
    }
}

#[test]
fn one_ray_against_each_of_many_shapes_agrees_with_the_f64_path() {
    let mut random = Random(4);
    let mut hits = Vec::new();
    for _ in 0..shape_count() * 200 {
        let exponents = Exponents::new(random.exponent(), random.exponent()).unwrap();
        let shape = Superquadric::new(DVec3::ONE, exponents).unwrap();
        let ray = random.ray();
        batch::intersect(&shape.as_convex().unwrap(), &[ray], &mut hits);
        check(&shape, &ray, hits[0], shape.intersect(&ray, RayStart::Free));
    }
}

#[test]
fn hostile_rays_do_no_harm() {
    let values = [
        0.0,
        -0.0,
        1.0,
        -1.0,
        0.5,
        1e6,
        -1e12,
        1e300,
        f64::INFINITY,
        f64::NAN,
        5e-324,
        f64::MAX,
        1.0 - f64::EPSILON,
    ];
    let mut random = Random(5);
    let mut any = || values[(random.unit() * values.len() as f64) as usize];
    let mut hits = Vec::new();
    for (e, n) in [(1.0, 1.0), (0.0001, 0.0001), (2.0, 2.0), (0.5, 1.5), (1e-300, 2.0)] {
        let shape = Superquadric::new(DVec3::new(1.0, 2.0, 1e-3), Exponents::new(e, n).unwrap()).unwrap();
        let rays: Vec<Ray> = (0..20_000)
            .map(|_| Ray::new(DVec3::new(any(), any(), any()), DVec3::new(any(), any(), any())))
            .collect();
        batch::intersect(&shape.as_convex().unwrap(), &rays, &mut hits);
        for (i, ray) in rays.iter().enumerate() {
            if let Some(hit) = hits[i] {
                assert!(hit.t >= 0.0 && !hit.t.is_nan(), "{ray:?} {hit:?}");
            }
        }
    }
}
