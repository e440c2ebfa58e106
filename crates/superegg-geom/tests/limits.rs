//! Exponents of 0 are the limits: boxes and cylinders, exactly.

use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use superegg_geom::glam::{DMat3, DVec2, DVec3};
use superegg_geom::{Exponents, HitBatch, Ray, RayBatch, RayStart, Superquadric};

fn config() -> ProptestConfig {
    ProptestConfig {
        cases: 500,
        rng_seed: RngSeed::Fixed(1971),
        failure_persistence: None,
        ..ProptestConfig::default()
    }
}

const RADII: DVec3 = DVec3::new(2.0, 0.5, 1.25);

fn shape(radii: DVec3, e: f64, n: f64) -> Superquadric {
    Superquadric::new(radii, Exponents::new(e, n).unwrap()).unwrap()
}

/// A number in [-4, 4], often a special one.
fn coordinate() -> impl Strategy<Value = f64> {
    prop_oneof![3 => -4.0..4.0f64, 1 => prop::sample::select(vec![0.0, 1.0, -1.0, 0.5, 2.0, -1.25, 3.0])]
}

fn vector() -> impl Strategy<Value = DVec3> {
    [coordinate(), coordinate(), coordinate()].prop_map(DVec3::from_array)
}

/// The t at which a ray enters and leaves the box of these semi-axes; `None` if it misses.
fn slabs(radii: DVec3, origin: DVec3, direction: DVec3) -> Option<(f64, f64)> {
    let (mut near, mut far) = (f64::NEG_INFINITY, f64::INFINITY);
    for axis in 0..3 {
        let (o, d, r) = (origin[axis], direction[axis], radii[axis]);
        if d == 0.0 {
            if o.abs() > r {
                return None;
            }
            continue;
        }
        let (a, b) = ((-r - o) / d, (r - o) / d);
        (near, far) = (near.max(a.min(b)), far.min(a.max(b)));
    }
    (near <= far).then_some((near, far))
}

/// The same for the cylinder of radius 1 about z, of half height 1.
fn cylinder(origin: DVec3, direction: DVec3) -> Option<(f64, f64)> {
    let (o, d) = (DVec2::new(origin.x, origin.y), DVec2::new(direction.x, direction.y));
    let (mut near, mut far) = (f64::NEG_INFINITY, f64::INFINITY);
    let (a, b, c) = (d.length_squared(), o.dot(d), o.length_squared() - 1.0);
    if a == 0.0 {
        if c > 0.0 {
            return None;
        }
    } else {
        let root = (b * b - a * c).sqrt();
        if root.is_nan() {
            return None;
        }
        (near, far) = ((-b - root) / a, (-b + root) / a);
    }
    let wide = DVec3::new(f64::MAX, f64::MAX, 1.0);
    let (low, high) = slabs(wide, origin, direction)?;
    (near, far) = (near.max(low), far.min(high));
    (near <= far).then_some((near, far))
}

/// The first t >= 0 of an interval.
fn first(span: Option<(f64, f64)>) -> Option<f64> {
    let (near, far) = span?;
    if near >= 0.0 { Some(near) } else { Some(far).filter(|far| *far >= 0.0) }
}

/// Whether the ray passes near an edge or a face's border, where the answers may differ.
fn is_grazing(span: Option<(f64, f64)>, wider: Option<(f64, f64)>, narrower: Option<(f64, f64)>) -> bool {
    let is_hit = span.is_some();
    wider.is_some() != is_hit
        || narrower.is_some() != is_hit
        || span.is_some_and(|(near, far)| far - near < 1e-6)
}

proptest! {
    #![proptest_config(config())]

    #[test]
    fn rays_hit_the_exact_box(origin in vector(), direction in vector()) {
        prop_assume!(direction.length() > 0.1);
        let span = slabs(RADII, origin, direction);
        let (wider, narrower) =
            (slabs(RADII * (1.0 + 1e-9), origin, direction), slabs(RADII * (1.0 - 1e-9), origin, direction));
        prop_assume!(!is_grazing(span, wider, narrower));
        let expected = first(span);
        prop_assume!(expected.is_none_or(|t| t > 1e-9) && span.is_none_or(|(near, _)| near.abs() > 1e-9));
        let ray = Ray::new(origin, direction);
        for exponent in [0.0, 1e-12] {
            let hit = shape(RADII, exponent, exponent).intersect(&ray, RayStart::Free);
            prop_assert_eq!(hit.is_some(), expected.is_some(), "{}", exponent);
            if let (Some(hit), Some(t)) = (hit, expected) {
                prop_assert!((hit.t - t).abs() <= 1e-11 * (1.0 + t), "{}: {} {}", exponent, hit.t, t);
                let axis = (hit.point / RADII).abs().max_position();
                let normal = shape(RADII, 0.0, 0.0).normal(hit.point);
                let second = (hit.point / RADII).abs().to_array().into_iter().fold((0.0f64, 0.0f64), |(a, b), x| {
                    if x > a { (x, a) } else { (a, b.max(x)) }
                }).1;
                if second < 1.0 - 1e-9 {
                    prop_assert_eq!(normal, DVec3::AXES[axis] * hit.point[axis].signum());
                }
            }
        }
    }

    #[test]
    fn rays_hit_the_exact_cylinder(origin in vector(), direction in vector()) {
        prop_assume!(direction.length() > 0.1);
        let span = cylinder(origin, direction);
        let scaled = |k: f64| cylinder(origin / k, direction / k);
        prop_assume!(!is_grazing(span, scaled(1.0 + 1e-9), scaled(1.0 - 1e-9)));
        let expected = first(span);
        prop_assume!(expected.is_none_or(|t| t > 1e-9) && span.is_none_or(|(near, _)| near.abs() > 1e-9));
        let ray = Ray::new(origin, direction);
        for exponent in [0.0, 1e-12] {
            let hit = shape(DVec3::ONE, 1.0, exponent).intersect(&ray, RayStart::Free);
            prop_assert_eq!(hit.is_some(), expected.is_some(), "{}", exponent);
            if let (Some(hit), Some(t)) = (hit, expected) {
                prop_assert!((hit.t - t).abs() <= 1e-11 * (1.0 + t), "{}: {} {}", exponent, hit.t, t);
            }
        }
    }

    /// The kernels agree with the scalar solver, for every mixture of 0 with other exponents.
    #[test]
    fn batches_and_single_rays_agree(
        origins in prop::collection::vec(vector(), 40),
        directions in prop::collection::vec(vector(), 40),
        e in prop::sample::select(vec![0.0, 0.3, 1.0, 2.0, 3.0]),
        n in prop::sample::select(vec![0.0, 0.3, 1.0, 2.0, 3.0]),
    ) {
        let limit = shape(RADII, e, n);
        let near = shape(RADII, e.max(1e-12), n.max(1e-12));
        let directions: Vec<DVec3> =
            directions.into_iter().map(|d| if d.length() > 0.1 { d } else { DVec3::ONE }).collect();
        let columns = |vs: &[DVec3]| -> Vec<[f64; 3]> { vs.iter().map(superegg_geom::glam::DVec3::to_array).collect() };
        let (origin_rows, direction_rows) = (columns(&origins), columns(&directions));
        let rays = RayBatch::new(&origin_rows, &direction_rows).unwrap();
        let mut hits = HitBatch::new();
        limit.intersect_batch(&rays, &mut hits);
        let mut near_hits = HitBatch::new();
        near.intersect_batch(&rays, &mut near_hits);
        for i in 0..origins.len() {
            let ray = Ray::new(origins[i], directions[i]);
            let single = limit.intersect(&ray, RayStart::Free);
            // A ray that touches an edge hits or misses by rounding.
            let is_hit = |factor: f64| shape(RADII * factor, e, n).intersect(&ray, RayStart::Free).is_some();
            if is_hit(1.0 - 1e-9) != is_hit(1.0 + 1e-9) {
                continue;
            }
            prop_assert_eq!(hits.hit(i).is_some(), single.is_some());
            prop_assert_eq!(near_hits.hit(i).is_some(), single.is_some());
            if let (Some(hit), Some(single)) = (hits.hit(i), single) {
                prop_assert!((hit.t - single.t).abs() <= 1e-9 * (1.0 + single.t), "{} {}", hit.t, single.t);
            }
        }
    }

    /// The sign of the inside-outside function, and the distance, are those of the box.
    #[test]
    fn points_of_the_box(point in vector()) {
        let cube = shape(RADII, 0.0, 0.0);
        let most = (point / RADII).abs().max_element();
        let value = cube.inside_outside(point);
        if most < 1.0 {
            prop_assert!(value < 0.0);
        } else if most > 1.0 {
            prop_assert!(value > 0.0);
        } else {
            prop_assert!(value.abs() < 2.0);
        }
        let outside = (point.abs() - RADII).max(DVec3::ZERO);
        let inside = (RADII - point.abs()).min_element();
        let expected = if most > 1.0 { outside.length() } else { inside };
        let closest = cube.closest_point(point).unwrap();
        let tolerance = 1e-9 + closest.error;
        prop_assert!((closest.distance.abs() - expected).abs() < tolerance, "{} {}", closest.distance, expected);
    }
}

#[test]
fn measures_are_those_of_boxes_and_cylinders() {
    let (a, b, c) = (RADII.x, RADII.y, RADII.z);
    let close = |x: f64, y: f64, what: &str| assert!((x - y).abs() <= 1e-11 * y.abs(), "{what}: {x} {y}");
    let cube = shape(RADII, 0.0, 0.0);
    close(cube.volume(), 8.0 * a * b * c, "volume");
    close(cube.surface_area(), 8.0 * (a * b + b * c + a * c), "area");
    close(cube.second_moments().x, 8.0 * a * b * c * a * a / 3.0, "moment");
    let pipe = shape(DVec3::new(a, a, c), 1.0, 0.0);
    close(pipe.volume(), std::f64::consts::TAU * a * a * c, "volume of the cylinder");
    close(pipe.surface_area(), std::f64::consts::TAU * a * (2.0 * c + a), "area of the cylinder");
    let turn = DMat3::from_rotation_z(0.5);
    let (sin, cos) = 0.5f64.sin_cos();
    let expected = DVec3::new(a * cos + b * sin, a * sin + b * cos, c);
    assert!((cube.half_extent_under(&turn) - expected).length() < 1e-12);
    for (e, n) in [(0.0, 0.0), (0.0, 1.0), (1.0, 0.0), (0.0, 2.0), (3.0, 0.0), (0.0, 3.0)] {
        let (limit, near) = (shape(RADII, e, n), shape(RADII, e.max(1e-12), n.max(1e-12)));
        close(limit.volume(), near.volume(), "volume in the limit");
        let samples = limit.sample_surface(1000, 3);
        assert!(samples.iter().all(|s| (limit.norm().value(s.point / RADII) - 1.0).abs() < 1e-12));
        assert!(samples.iter().all(|s| (s.normal.length() - 1.0).abs() < 1e-12));
        for i in -8..=8 {
            for j in -4..=4 {
                let (u, v) = (f64::from(i) * 0.37, f64::from(j) * 0.35);
                let (point, other) = (limit.point_at(u, v), near.point_at(u, v));
                assert!((point - other).length() < 1e-10, "{e} {n} {u} {v}: {point} {other}");
            }
        }
    }
    let kept = Exponents::new(-0.0, 0.0).unwrap();
    assert!(kept.e() == 0.0 && kept.e().is_sign_positive());
}
