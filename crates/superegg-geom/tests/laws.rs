//! Laws: true of every shape, every ray, every transform. Seeded, so that a failure can be had again.

use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use superegg_geom::glam::{DMat3, DVec3};
#[cfg(feature = "simd")]
use superegg_geom::kernels::verify::{KnownCrossing, VerifyBatch};
use superegg_geom::{
    Aabb, Exponents, NormForm, Ray, RayStart, SplitMix, Superquadric, Transform, TransformStep, textbook,
};

fn config(cases: u32) -> ProptestConfig {
    ProptestConfig {
        cases,
        rng_seed: RngSeed::Fixed(20_151_207),
        failure_persistence: None,
        ..ProptestConfig::default()
    }
}

/// Exponents from 0.0001 to 8, the special ones often.
fn exponent() -> impl Strategy<Value = f64> {
    prop_oneof![
        prop::sample::select(vec![0.0001, 0.001, 0.01, 0.1, 0.5, 1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 8.0]),
        (-4.0..0.9f64).prop_map(|log| 10f64.powf(log)),
    ]
}

fn convex_exponent() -> impl Strategy<Value = f64> {
    exponent().prop_map(|e| if e > 2.0 { e / 4.0 } else { e })
}

fn exponents() -> impl Strategy<Value = Exponents> {
    (exponent(), exponent()).prop_map(|(e, n)| Exponents::new(e, n).unwrap())
}

fn unit_shape() -> impl Strategy<Value = Superquadric> {
    exponents().prop_map(|exponents| Superquadric::new(DVec3::ONE, exponents).unwrap())
}

fn convex_shape() -> impl Strategy<Value = Superquadric> {
    (convex_exponent(), convex_exponent())
        .prop_map(|(e, n)| Superquadric::new(DVec3::ONE, Exponents::new(e, n).unwrap()).unwrap())
}

fn vector(size: f64) -> impl Strategy<Value = DVec3> {
    prop::array::uniform3(-size..size).prop_map(DVec3::from_array)
}

/// Coordinates that are often exactly 0, 1 or -1: in planes, along axes, towards edges.
fn special_vector(size: f64) -> impl Strategy<Value = DVec3> {
    let coordinate = prop_oneof![3 => -size..size, 1 => prop::sample::select(vec![0.0, -0.0, 1.0, -1.0])];
    prop::array::uniform3(coordinate).prop_map(DVec3::from_array)
}

/// Rays that mostly come near the unit shape.
fn ray() -> impl Strategy<Value = Ray> {
    (special_vector(4.0), special_vector(1.2)).prop_filter_map("a direction", |(origin, target)| {
        let direction = target - origin;
        (direction != DVec3::ZERO).then(|| Ray::new(origin, direction))
    })
}

fn steps() -> impl Strategy<Value = Vec<TransformStep>> {
    let factor = prop_oneof![0.2..3.0f64, -3.0..-0.2f64];
    let step = prop_oneof![
        vector(5.0).prop_map(TransformStep::Translate),
        (vector(1.0), -720.0..720.0f64)
            .prop_map(|(axis, angle_deg)| TransformStep::Rotate { axis, angle_deg }),
        prop::array::uniform3(factor).prop_map(|f| TransformStep::Scale(f.into())),
    ];
    prop::collection::vec(step, 0..6)
}

/// Any f64 at all, the hostile ones often.
fn hostile() -> impl Strategy<Value = f64> {
    prop_oneof![
        any::<f64>(),
        prop::sample::select(vec![
            0.0,
            -0.0,
            1.0,
            -1.0,
            0.5,
            3.0,
            f64::INFINITY,
            f64::NEG_INFINITY,
            f64::NAN,
            f64::MIN_POSITIVE,
            5e-324,
            f64::MAX,
            f64::MIN,
            1e-300,
            1e300,
            1e6,
            -1e12,
            1.0 - f64::EPSILON / 2.0,
            1.0 + f64::EPSILON,
        ]),
        -2.0..2.0f64,
    ]
}

fn hostile_vector() -> impl Strategy<Value = DVec3> {
    prop::array::uniform3(hostile()).prop_map(DVec3::from_array)
}

/// A scaled difference: how far `a` is from `b` in units of the larger, or of 1.
fn off(a: f64, b: f64) -> f64 {
    (a - b).abs() / a.abs().max(b.abs()).max(1.0)
}

/// Away from the planes where a shape may have edges, creases and poles, and so more than one normal.
fn is_smooth_at(point: DVec3) -> bool {
    point.abs().min_element() > 1e-3 && point.abs().max_element() < 0.999
}

proptest! {
    #![proptest_config(config(20_000))]

    /// The slow twin: no place before the first crossing is on the other side, and none at all for a miss.
    #[test]
    fn nothing_is_crossed_before_the_first_crossing(shape in unit_shape(), ray in ray()) {
        let hit = shape.intersect(&ray, RayStart::Free);
        let norm = shape.norm();
        let starts_inside = norm.value(ray.origin) < 1.0;
        let last = hit.map_or(4.0, |hit| hit.t);
        for i in 0..=400 {
            let t = last * f64::from(i) / 400.0;
            let distance = norm.value(ray.point_at(t)) - 1.0;
            // A place in doubt by rounding is on neither side; near a spike of e or n > 2 rounding is the spike's own width.
            let near_a_plane = ray.point_at(t).abs().min_element() < 1e-9 && !shape.is_convex();
            if distance.abs() > 1e-9 && t < last * (1.0 - 1e-9) && !near_a_plane {
                prop_assert_eq!(distance < 0.0, starts_inside, "t = {} of {:?}", t, hit);
            }
        }
    }

    /// A hit is on the surface, on the ray, and reported with the right side.
    #[test]
    fn a_hit_is_on_the_surface_and_on_the_ray(shape in unit_shape(), ray in ray()) {
        if let Some(hit) = shape.intersect(&ray, RayStart::Free) {
            prop_assert!(hit.t >= 0.0 && hit.t.is_finite());
            let on_ray = ray.point_at(hit.t) - hit.point;
            prop_assert!(on_ray.abs().max_element() < 1e-12, "{hit:?} is off by {on_ray}");
            prop_assert!((shape.norm().value(hit.point) - 1.0).abs() < 1e-9, "{hit:?}");
            prop_assert_eq!(hit.leaving, shape.norm().value(ray.origin) < 1.0);
            let normal = shape.normal(hit.point);
            prop_assert!((normal.length() - 1.0).abs() < 1e-12);
        }
    }

    /// The fast path and the certified search agree wherever the shape is convex.
    #[test]
    fn newton_and_the_certified_search_agree(shape in convex_shape(), ray in ray()) {
        let fast = shape.intersect(&ray, RayStart::Free);
        let slow = shape.intersect_certified(&ray, RayStart::Free);
        match (fast, slow) {
            (Some(fast), Some(slow)) => {
                // Where the ray grazes, t is as uncertain as the root of the rounding error; within a face it is anything.
                let across = shape.normal(fast.point).dot(ray.direction.normalize()).abs();
                prop_assert!(across < 1e-7 || off(fast.t, slow.t) < 1e-12 / across, "{fast:?} {slow:?}");
                prop_assert_eq!(fast.leaving, slow.leaving);
            }
            (None, None) => {}
            (Some(hit), None) | (None, Some(hit)) => {
                // One of them takes a touch for a crossing: right after it the ray is not on the other side.
                let after = shape.norm().value(ray.point_at(hit.t + 1e-6 / ray.direction.length())) - 1.0;
                prop_assert!(if hit.leaving { after < 1e-9 } else { after > -1e-9 }, "{fast:?} {slow:?} {after}");
            }
        }
    }

    /// A ray is occluded where it has a crossing before the end.
    #[test]
    fn occluded_is_a_crossing_before_the_end(shape in unit_shape(), ray in ray(), end in 0.0..3.0f64) {
        for start in [RayStart::Free, RayStart::SurfaceOutward, RayStart::SurfaceInward] {
            let hit = shape.intersect(&ray, start);
            prop_assert_eq!(shape.occluded(&ray, start, end), hit.is_some_and(|hit| hit.t < end), "{:?} {:?}", start, hit);
        }
    }

    /// A ray that leaves a convex shape outwards is not shadowed by it, wherever rounding put its start.
    #[test]
    fn a_convex_shape_does_not_shadow_itself(shape in convex_shape(), ray in ray(), direction in vector(1.0)) {
        if let Some(hit) = shape.intersect(&ray, RayStart::Free) {
            let start = Ray { origin_error: 1e-15, ..Ray::new(hit.point, direction) };
            if shape.normal(hit.point).dot(direction) > 0.0 {
                prop_assert!(!shape.occluded(&start, RayStart::SurfaceOutward, 10.0));
            }
        }
    }

    /// A shape is its own mirror image: so are the answers, to the bit.
    #[test]
    fn mirrored_rays_have_mirrored_hits(shape in unit_shape(), ray in ray(), flip in prop::array::uniform3(any::<bool>())) {
        let sign = DVec3::from_array(flip.map(|f| if f { -1.0 } else { 1.0 }));
        let mirrored = Ray::new(ray.origin * sign, ray.direction * sign);
        let (a, b) = (shape.intersect(&ray, RayStart::Free), shape.intersect(&mirrored, RayStart::Free));
        prop_assert_eq!(a.map(|hit| (hit.t, hit.point * sign)), b.map(|hit| (hit.t, hit.point)));
    }

    /// Size does not matter: a power of two on shape and ray changes nothing but the point, and one on the direction only t.
    #[test]
    fn scaling_changes_nothing(shape in unit_shape(), ray in ray(), size in -300..300i32, speed in -300..300i32) {
        let (size, speed) = (2f64.powi(size), 2f64.powi(speed));
        let scaled = Superquadric::new(DVec3::splat(size), shape.exponents()).unwrap();
        let scaled_ray = Ray::new(ray.origin * size, ray.direction * (size * speed));
        let (a, b) = (shape.intersect(&ray, RayStart::Free), scaled.intersect(&scaled_ray, RayStart::Free));
        prop_assert_eq!(a.map(|hit| (hit.t / speed, hit.point * size)), b.map(|hit| (hit.t, hit.point)));
    }

    /// A ray that leaves a convex shape outwards does not meet it again; one that goes in has one exit, where the way back is the same.
    #[test]
    fn from_the_surface_of_a_convex_shape(shape in convex_shape(), ray in ray(), direction in vector(1.0)) {
        if let Some(hit) = shape.intersect(&ray, RayStart::Free).filter(|hit| is_smooth_at(hit.point)) {
            let outward = shape.normal(hit.point).dot(direction) >= 0.0;
            let spawned = Ray::new(hit.point, direction);
            if outward {
                prop_assert_eq!(shape.intersect(&spawned, RayStart::SurfaceOutward), None);
            } else {
                let exit = shape.intersect(&spawned, RayStart::SurfaceInward).unwrap();
                prop_assert!(exit.leaving && (shape.norm().value(exit.point) - 1.0).abs() < 1e-9);
                let back = shape.intersect(&Ray::new(exit.point, -direction), RayStart::SurfaceInward).unwrap();
                // Along an edge or face the way through is as uncertain as rounding makes it.
                let across = shape.normal(hit.point).dot(direction.normalize()).abs();
                prop_assert!(off(back.t, exit.t) < 1e-9 / across.max(1e-6), "{} {}", back.t, exit.t);
            }
        }
    }

    /// The same for any shape: the start itself is not found again.
    #[test]
    fn from_the_surface_of_any_shape(shape in unit_shape(), ray in ray(), direction in vector(1.0)) {
        if let Some(hit) = shape.intersect(&ray, RayStart::Free).filter(|hit| is_smooth_at(hit.point)) {
            let across = shape.normal(hit.point).dot(direction.normalize());
            prop_assume!(across.abs() > 1e-2);
            let start = if across > 0.0 { RayStart::SurfaceOutward } else { RayStart::SurfaceInward };
            if let Some(next) = shape.intersect(&Ray::new(hit.point, direction), start) {
                prop_assert!(next.t > 1e-9, "{next:?}");
                prop_assert_eq!(next.leaving, across < 0.0);
            }
        }
    }

    /// Facts about the first crossing that are verified change no answer: neither an interval around it, nor that there is none
    /// beyond a first stretch. One that hides the crossing is not verified.
    #[cfg(feature = "simd")]
    #[test]
    fn a_verified_crossing_is_the_one_that_is_found(
        shape in unit_shape(), ray in ray(), direction in vector(1.0), before in 0.0..1.0f64, after in 1e-4..0.05f64,
    ) {
        let mut rays = vec![(ray, RayStart::Free)];
        if let Some(hit) = shape.intersect(&ray, RayStart::Free).filter(|hit| is_smooth_at(hit.point)) {
            let across = shape.normal(hit.point).dot(direction);
            let start = if across >= 0.0 { RayStart::SurfaceOutward } else { RayStart::SurfaceInward };
            rays.push((Ray::new(hit.point, direction), start));
        }
        for (ray, start) in rays {
            let found = shape.intersect(&ray, start);
            if start == RayStart::Free && found.is_none_or(|hit| hit.leaving) {
                continue;
            }
            // The first stretch ends before the crossing, or hides it.
            let no_crossing_after = |t: f64| KnownCrossing { clear_from: t, between: None };
            let known = match found {
                None => no_crossing_after(before),
                Some(hit) => {
                    let beyond = hit.t + after;
                    let is_across = (shape.norm().value(ray.point_at(beyond)) < 1.0) != hit.leaving;
                    if !is_across {
                        continue;
                    }
                    let outside = hit.t - after.min(hit.t) * before;
                    KnownCrossing { clear_from: outside * before, between: Some([outside, beyond]) }
                }
            };
            let verify = |known: &KnownCrossing| {
                let mut batch = VerifyBatch::default();
                batch.push(&shape, &ray, start, known);
                batch.run();
                batch.get(0)
            };
            let Some(verified) = verify(&known) else { continue };
            prop_assert_eq!(verified.map(|(hit, _)| hit.leaving), found.map(|hit| hit.leaving), "{:?} {:?}", known, found);
            if let (Some((a, gradient)), Some(b)) = (verified, found) {
                let slope = (shape.norm().value(b.point + 1e-4 * ray.direction) - 1.0).abs() * 1e4;
                prop_assert!(off(a.t, b.t) < 1e-11 / slope.clamp(1e-4, 1.0), "{known:?} {a:?} {b:?}");
                if let Some(gradient) = gradient {
                    let normal = gradient.normalize();
                    prop_assert!((normal - shape.normal(a.point)).length() < 1e-7, "{known:?} {a:?} {normal}");
                }
                let last = shape.intersect(&Ray::new(b.point, ray.direction), if b.leaving {
                    RayStart::SurfaceOutward
                } else {
                    RayStart::SurfaceInward
                });
                if start != RayStart::Free && last.is_none() {
                    prop_assert_eq!(verify(&no_crossing_after(b.t + 0.01)), None);
                }
            }
        }
    }

    /// Nothing panics, nothing is NaN, whatever comes.
    #[test]
    fn hostile_values_do_no_harm(
        e in hostile(), n in hostile(), radii in hostile_vector(), origin in hostile_vector(), direction in hostile_vector(),
        error in prop::sample::select(vec![0.0, 1e-15, 1.0, f64::INFINITY]),
    ) {
        for (radii, exponents) in [
            (radii, Exponents::new(e, n)),
            (DVec3::ONE, Exponents::new(e.abs().clamp(0.0001, 8.0), n.abs().clamp(0.0001, 8.0))),
        ] {
            let Ok(exponents) = exponents else { continue };
            let Ok(shape) = Superquadric::new(radii, exponents) else { continue };
            let ray = Ray { origin_error: error, ..Ray::new(origin, direction) };
            for start in [RayStart::Free, RayStart::SurfaceOutward, RayStart::SurfaceInward] {
                for hit in [shape.intersect(&ray, start), shape.intersect_certified(&ray, start)].into_iter().flatten() {
                    prop_assert!(hit.t >= 0.0 && !hit.point.is_nan(), "{hit:?}");
                    prop_assert!(shape.normal(hit.point).is_finite());
                }
            }
            if (origin / radii).is_finite() {
                prop_assert!(!shape.inside_outside(origin).is_nan());
                prop_assert!(shape.normal(origin).is_finite());
            }
            textbook::intersect(&ray, exponents);
        }
    }

    /// N is homogeneous, has the sign of io, and lies between the largest coordinate and, for convex shapes, their sum.
    #[test]
    fn the_norm_form(exponents in exponents(), v in special_vector(2.0), factor in 0.01..100.0f64) {
        let norm = NormForm::new(exponents);
        let value = norm.value(v);
        prop_assert!(off(norm.value(factor * v), factor * value) < 1e-12);
        prop_assert!(value >= v.abs().max_element() * (1.0 - 1e-15));
        if exponents.e() <= 2.0 && exponents.n() <= 2.0 {
            prop_assert!(value <= v.abs().to_array().iter().sum::<f64>() * (1.0 + 1e-12));
        }
        let io = norm.inside_outside(v);
        prop_assert!((io > 0.0) == (value > 1.0) && (io < 0.0) == (value < 1.0));
        // The course text's form, where it keeps its digits.
        let plain = textbook::inside_outside(v, exponents);
        if exponents.e() >= 0.1 && exponents.n() >= 0.1 && plain.is_finite() {
            prop_assert!(off(io, plain) < 1e-9, "{io} {plain}");
        }
    }

    /// The gradient is that of finite differences, where the shape is smooth.
    #[test]
    fn the_gradient(e in 0.2..6.0f64, n in 0.2..6.0f64, v in prop::array::uniform3(0.1..1.0f64)) {
        let norm = NormForm::new(Exponents::new(e, n).unwrap());
        let v = DVec3::from_array(v);
        let (value, gradient) = norm.value_and_gradient(v);
        prop_assert!(off(value, norm.value(v)) < 1e-15);
        let step = 1e-6;
        for (axis, derivative) in DVec3::AXES.into_iter().zip(gradient.to_array()) {
            let difference = (norm.value(v + step * axis) - norm.value(v - step * axis)) / (2.0 * step);
            prop_assert!(off(difference, derivative) < 1e-6, "{difference} {derivative}");
        }
        prop_assert!(off(gradient.dot(v), value) < 1e-12, "Euler's theorem for degree one");
    }

    /// Points of the parameterisation are on the surface.
    #[test]
    fn points_at_u_v_are_on_the_surface(shape in unit_shape(), u in -3.1..3.1f64, v in -1.5..1.5f64) {
        let point = shape.point_at(u, v);
        prop_assert!((shape.norm().value(point) - 1.0).abs() < 1e-12, "{point}");
    }

    /// The world box holds every point of the shape, and each of its faces is touched.
    #[test]
    fn bounds_hold_and_touch(e in 0.3..4.0f64, n in 0.3..4.0f64, steps in steps()) {
        let shape = Superquadric::new(DVec3::new(2.0, 1.0, 0.5), Exponents::new(e, n).unwrap()).unwrap();
        let transform = Transform::from_steps(&steps).unwrap();
        let forward = transform.forward();
        let half = shape.half_extent_under(&forward.matrix3);
        let bounds = Aabb::around(forward.translation, half);
        let mut reached = DVec3::ZERO;
        let turn = |i: i32, of: i32| std::f64::consts::PI * f64::from(i) / f64::from(of);
        for i in -60..=60 {
            for j in -30..=30 {
                let point = forward.transform_point3(shape.point_at(turn(i, 60), turn(j, 60)));
                prop_assert!(bounds.rounded_outward().contains(point));
                reached = reached.max((point - forward.translation).abs());
            }
        }
        prop_assert!((reached / half).min_element() > 0.9, "{reached} {half}");
    }

    /// A transform and its inverse undo each other; normals stay at right angles to tangents.
    #[test]
    fn transforms_are_undone(steps in steps(), point in vector(3.0), tangent in vector(1.0), normal in vector(1.0)) {
        let transform = Transform::from_steps(&steps).unwrap();
        let there = transform.forward().transform_point3(point);
        let back = transform.inverse().transform_point3(there);
        prop_assert!((back - point).length() < 1e-7, "{back} {point}");
        let tangent = tangent - normal * (tangent.dot(normal) / normal.length_squared());
        let mapped = transform.normal_to_world(normal).normalize();
        let along = (transform.forward().matrix3 * tangent).normalize_or_zero();
        prop_assert!(mapped.dot(along).abs() < 1e-6);
        // The order: one step after the others acts last.
        let stepwise = steps.iter().fold(point, |p, step| Transform::from_steps([step]).unwrap().forward().transform_point3(p));
        prop_assert!((stepwise - there).length() < 1e-9 * (1.0 + there.length()));
    }

    /// A ray keeps its t through any map.
    #[test]
    fn t_survives_transforms(shape in convex_shape(), ray in ray(), steps in steps()) {
        // A start on the surface may come to lie on either side.
        prop_assume!((shape.norm().value(ray.origin) - 1.0).abs() > 1e-9);
        let transform = Transform::from_steps(&steps).unwrap();
        let forward = transform.forward();
        let world = Ray::new(forward.transform_point3(ray.origin), forward.transform_vector3(ray.direction));
        let (a, b) = (shape.intersect(&ray, RayStart::Free), shape.intersect(&world.to_local(&transform), RayStart::Free));
        if let (Some(a), Some(b)) = (a, b) {
            let across = shape.normal(a.point).dot(ray.direction.normalize()).abs();
            prop_assert!(across < 1e-4 || off(a.t, b.t) < 1e-8 / across, "{a:?} {b:?}");
        }
    }
}

/// The dual norm is the support function: for the identity the box is the unit box, whatever the exponents.
#[test]
fn the_unit_shape_touches_the_unit_box() {
    for e in [0.0001, 0.5, 1.0, 2.0, 5.0] {
        for n in [0.0001, 0.5, 1.0, 2.0, 5.0] {
            let shape = Superquadric::new(DVec3::new(3.0, 2.0, 1.0), Exponents::new(e, n).unwrap()).unwrap();
            assert_eq!(shape.half_extent_under(&DMat3::IDENTITY), DVec3::new(3.0, 2.0, 1.0));
        }
    }
}

/// From any distance, and on shapes of any thinness, a ray meets the place it is aimed at.
#[test]
fn distance_does_not_matter() {
    for exponents in [(1.0, 1.0), (0.3, 0.7), (2.0, 1.0), (3.0, 2.5), (0.5, 4.0)] {
        let exponents = Exponents::new(exponents.0, exponents.1).unwrap();
        let shape = Superquadric::new(DVec3::ONE, exponents).unwrap();
        let near = Ray::new(DVec3::new(0.1, 0.05, 4.0), DVec3::NEG_Z);
        let expected = shape.intersect(&near, RayStart::Free).unwrap().point;
        for distance in [1e3, 1e9, 1e15, 1e16, 1e30, 1e300] {
            let far = Ray::new(DVec3::new(0.1, 0.05, distance), DVec3::NEG_Z);
            let hit = shape.intersect(&far, RayStart::Free).unwrap();
            assert!((hit.point - expected).length() < 1e-12, "{exponents:?} {distance}: {hit:?}");
            let thin = Superquadric::new(DVec3::new(1.0, 1.0, 1.0 / distance), exponents).unwrap();
            let hit = thin.intersect(&near, RayStart::Free).unwrap();
            assert!(
                (hit.point * DVec3::new(1.0, 1.0, distance) - expected).length() < 1e-12,
                "{exponents:?} {distance}: {hit:?}"
            );
        }
    }
    let small = Superquadric::new(DVec3::splat(1e-150), Exponents::ROUND).unwrap();
    let fast = Ray::new(DVec3::Z * 10.0, DVec3::NEG_Z * 1e170);
    assert!((small.intersect(&fast, RayStart::Free).unwrap().t - 1e-169).abs() < 1e-180);
}

/// A start on the surface is met only by a ray that goes in; touching is no crossing.
#[test]
fn a_start_on_the_surface_is_crossed_only_inwards() {
    for (e, n) in [(1.0, 1.0), (0.5, 0.5), (0.0001, 0.0001), (2.0, 2.0), (3.0, 3.0)] {
        let shape = Superquadric::new(DVec3::ONE, Exponents::new(e, n).unwrap()).unwrap();
        let from = |d: DVec3| {
            shape.intersect(&Ray::new(DVec3::X, d), RayStart::Free).map(|hit| (hit.t, hit.leaving))
        };
        assert_eq!(from(DVec3::X), None, "{e} {n}");
        assert_eq!(from(DVec3::NEG_X), Some((0.0, false)), "{e} {n}");
    }
}

/// A cap of a shape that is not convex lies in a face of its box. A ray that leaves it there does not come back, however its start is
/// rounded.
#[test]
fn no_ray_comes_back_to_the_cap_that_it_leaves() {
    let mut random = SplitMix::new(3);
    for case in 0..4_000 {
        let (e, n) = ([2.5, 3.0, 8.0][case % 3], [0.0, 1e-20, 1e-16, 1e-13, 1e-10][case / 3 % 5]);
        let shape = Superquadric::unit(Exponents::new(e, n).unwrap());
        let mut number = || 2.0 * random.unit() - 1.0;
        let (point, direction) = (
            0.4 * DVec3::new(number(), number(), 0.0),
            DVec3::new(number(), number(), 1e-3 + number().abs()),
        );
        let origin_error = [0.0, 1e-14, 1e-11][case / 15 % 3];
        let z = 1.0 + number() * (origin_error + 4.0 * f64::EPSILON);
        let leaving = Ray { origin: point + z * DVec3::Z, direction, origin_error };
        assert_eq!(shape.intersect(&leaving, RayStart::SurfaceOutward), None, "{e} {n} {leaving:?}");
        assert!(!shape.occluded(&leaving, RayStart::SurfaceOutward, 10.0), "{e} {n} {leaving:?}");
        let entering = Ray { direction: -direction, ..leaving };
        let exit = shape.intersect(&entering, RayStart::SurfaceInward).unwrap();
        assert!(exit.leaving && (exit.t > 1e-9 || shape.norm().value(point) > 0.9), "{e} {n} {entering:?}");
    }
}
