//! Batch queries against queries of one ray.

use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use superegg_geom::glam::DVec3;
use superegg_geom::{Ray, RayBatch};
use superegg_lang::load_text;
use superegg_trace::{BatchOptions, CompiledScene, ForeignHit, SceneHitBatch};

const SCENE: &str = "prm ball\nexp 1 .4\ncoeff .5 .6 .4\nprm star\nexp 3 2.5\ncoeff .8 .7 .9\nprm box\nexp .1 .1\ncoeff .7 .7 .7\n\
    obj inner\nap ball\nap star\nxs 1 .2 .1\nap box\nxs -1 0 .3\nrs 1 2 3 40\n\
    obj all\nao inner a\nrs 0 0 1 30\nss .8 .8 -.8\nao inner b\nxs 0 2 0\nap ball\nxs 0 -1.5 1\nao all deeper\nss .3 .3 .3\nxs 0 0 2\n";

fn compiled(text: &str, root: &str) -> CompiledScene {
    let (session, diagnostics) = load_text("batch.scn", text);
    assert!(diagnostics.is_empty(), "{diagnostics:?}");
    CompiledScene::compile(session.scene(), Some(root), 4)
}

fn directions_and_origins(count: usize) -> (Vec<[f64; 3]>, Vec<[f64; 3]>) {
    let origin = |x: f64| [4.0 * (1.3 * x).sin(), 4.0 * (0.7 * x).cos(), 4.0 * (2.9 * x).sin()];
    let target = |x: f64| [(2.1 * x).cos(), (1.1 * x).sin(), (0.37 * x).cos()];
    let numbers = || (0..count).map(|i| i as f64);
    let direction = |x: f64| (DVec3::from(target(x)) - DVec3::from(origin(x))).to_array();
    (numbers().map(origin).collect(), numbers().map(direction).collect())
}

/// Each row is what the query of one ray answers.
fn check(scene: &CompiledScene, rays: &RayBatch<'_>, hits: &SceneHitBatch) {
    assert_eq!((hits.len(), hits.hits().len()), (rays.len(), rays.len()));
    for i in 0..rays.len() {
        let ray = rays.ray(i).unwrap();
        let expected = scene.intersect_ray(&ray);
        assert_eq!(hits.hits().hit(i).is_some(), expected.is_some(), "{ray:?}");
        let (Some(hit), Some(expected)) = (hits.hits().hit(i), expected) else {
            assert_eq!((hits.primitives()[i], hits.instance_ids()[i]), (SceneHitBatch::NO_PRIMITIVE, 0));
            assert_eq!(hits.path(i), None);
            continue;
        };
        let surface = scene.interaction(&expected);
        assert!((hit.t - expected.t).abs() < 1e-9 * (1.0 + expected.t), "{hit:?} {expected:?}");
        assert!((hit.point - surface.position).length() < 1e-8);
        assert!(hit.normal.dot(surface.normal) > 1.0 - 1e-6, "{hit:?} {surface:?}");
        assert_eq!((hit.leaving, hits.primitives()[i]), (expected.leaving, expected.primitive));
        assert_eq!(hits.path(i), Some(&expected.path));
        assert_eq!(hits.instance_ids()[i], scene.instance_id(&expected.path));
        let shape = scene.primitive(expected.primitive).unit_shape();
        let (u, v) = shape.uv_at(expected.unit_point);
        let on_shape = |u: f64, v: f64| shape.point_at(u, v);
        assert!((on_shape(hit.uv[0], hit.uv[1]) - on_shape(u, v)).length() < 1e-6);
    }
}

#[test]
fn rows_are_the_answers_of_single_rays_at_any_number_of_threads() {
    let scene = compiled(SCENE, "all");
    let (origins, directions) = directions_and_origins(3_000);
    let rays = RayBatch::new(&origins, &directions).unwrap();
    let hits = scene.intersect_batch(&rays, BatchOptions::default());
    check(&scene, &rays, &hits);
    assert!(hits.hits().iter().flatten().count() > 1_000);
    let occluded = scene.occluded_batch(&rays, BatchOptions::default());
    for (i, is_occluded) in occluded.iter().enumerate() {
        assert_eq!(*is_occluded, hits.hits().hit(i).is_some());
    }
    for threads in [0, 2, 7] {
        let options = BatchOptions::default().with_threads(threads);
        let other = scene.intersect_batch(&rays, options);
        // Rows, and not columns: those of misses are NaN.
        assert!(other.hits().iter().eq(hits.hits().iter()));
        assert_eq!(other.primitives(), hits.primitives());
        assert_eq!(other.instance_ids(), hits.instance_ids());
        assert!((0..rays.len()).all(|i| other.path(i) == hits.path(i)));
        assert_eq!(scene.occluded_batch(&rays, options), occluded);
    }
}

#[test]
fn a_flat_scene_answers_a_few_rays_and_many() {
    let mut text = String::from("prm ball\ncoeff .3 .2 .3\nexp .5 1.2\nobj all\n");
    for i in 0..216 {
        text += &format!("ap ball b{i}\nxs {} {} {}\n", i % 6 - 3, i / 6 % 6 - 3, i / 36 - 3);
    }
    let scene = compiled(&text, "all");
    for count in [1, 10, 3_000] {
        let (origins, directions) = directions_and_origins(count);
        let rays = RayBatch::new(&origins, &directions).unwrap();
        check(&scene, &rays, &scene.intersect_batch(&rays, BatchOptions::default()));
    }
}

#[test]
fn a_hundred_thousand_rays_and_none() {
    let scene = compiled(SCENE, "all");
    let (origins, directions) = directions_and_origins(100_000);
    let rays = RayBatch::new(&origins, &directions).unwrap();
    let hits = scene.intersect_batch(&rays, BatchOptions::default().with_threads(3));
    let part = rays.slice(70_000..70_300).unwrap();
    let of_part = scene.intersect_batch(&part, BatchOptions::default());
    check(&scene, &part, &of_part);
    for i in 0..part.len() {
        assert_eq!(hits.hits().hit(70_000 + i), of_part.hits().hit(i));
        assert_eq!(hits.path(70_000 + i), of_part.path(i));
    }
    assert_eq!(hits.len(), 100_000);
    let none = RayBatch::new(&[], &[]).unwrap();
    for threads in [1, 4] {
        let options = BatchOptions::default().with_threads(threads);
        assert!(scene.intersect_batch(&none, options).is_empty());
        assert!(scene.occluded_batch(&none, options).is_empty());
    }
}

#[test]
fn hostile_rays_hit_nothing_or_what_single_rays_hit() {
    let scene = compiled(SCENE, "all");
    let hostile = [0.0, -0.0, 1e-300, 1e300, f64::MAX, f64::INFINITY, f64::NEG_INFINITY, f64::NAN, -1.0];
    let (mut origins, mut directions) = (Vec::new(), Vec::new());
    for x in hostile {
        for y in hostile {
            for z in [0.0, -1.0, f64::NAN] {
                origins.extend([[x, 3.0, 5.0], [0.1, 0.2, 5.0]]);
                directions.extend([[x, y, z], [y, x, z]]);
            }
        }
    }
    let rays = RayBatch::new(&origins, &directions).unwrap();
    let hits = scene.intersect_batch(&rays, BatchOptions::default());
    let occluded = scene.occluded_batch(&rays, BatchOptions::default());
    for (i, &is_occluded) in occluded.iter().enumerate() {
        let ray = rays.ray(i).unwrap();
        if !ray.origin.is_finite() || !ray.direction.is_finite() || ray.direction == DVec3::ZERO {
            assert_eq!((hits.hits().hit(i), is_occluded), (None, false), "{ray:?}");
        } else {
            assert_eq!(hits.hits().hit(i).is_some(), scene.intersect_ray(&ray).is_some(), "{ray:?}");
        }
    }
}

#[test]
fn an_empty_scene_has_no_hits() {
    let scene = compiled(SCENE, "no such object");
    let (origins, directions) = directions_and_origins(10);
    let rays = RayBatch::new(&origins, &directions).unwrap();
    let hits = scene.intersect_batch(&rays, BatchOptions::default());
    assert_eq!((hits.len(), hits.hits().iter().flatten().count()), (10, 0));
    assert_eq!(scene.occluded_batch(&rays, BatchOptions::default()), [false; 10]);
    assert!(scene.instance_count().is_zero() && scene.bounds().is_none());
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 50, rng_seed: RngSeed::Fixed(7), failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn ranges_of_t_count(ranges in prop::collection::vec((-1.0..3.0f64, 0.0..3.0f64), 60)) {
        let scene = compiled(SCENE, "all");
        let (origins, directions) = directions_and_origins(ranges.len());
        let t_min: Vec<f64> = ranges.iter().map(|range| range.0).collect();
        let t_max: Vec<f64> = ranges.iter().map(|range| range.0 + range.1).collect();
        let rays = RayBatch::new(&origins, &directions).unwrap();
        let rays = rays.with_t_min(&t_min).and_then(|rays| rays.with_t_max(&t_max)).unwrap();
        let hits = scene.intersect_batch(&rays, BatchOptions::default());
        let occluded = scene.occluded_batch(&rays, BatchOptions::default());
        for i in 0..rays.len() {
            let (ray, start) = (rays.ray(i).unwrap(), t_min[i].max(0.0));
            let from_start = Ray::new(ray.point_at(start), ray.direction);
            let expected = scene.intersect_ray(&from_start).map(|hit| start + hit.t);
            let is_near_end = expected.is_some_and(|t| (t - t_max[i]).abs() < 1e-9);
            let expected = expected.filter(|t| *t < t_max[i]);
            prop_assert!(is_near_end || hits.hits().hit(i).is_some() == expected.is_some());
            prop_assert!(is_near_end || occluded[i] == expected.is_some());
            if let (Some(hit), Some(t)) = (hits.hits().hit(i), expected) {
                prop_assert!((hit.t - t).abs() < 1e-9 * (1.0 + t));
            }
        }
    }
}

#[test]
fn a_hit_of_another_scene_is_refused() {
    let (scene, other) = (compiled(SCENE, "all"), compiled(SCENE, "inner"));
    let ray = Ray::new(DVec3::new(0.0, 0.0, 9.0), DVec3::NEG_Z);
    let hit = other.intersect_ray(&ray).unwrap();
    assert_eq!(scene.try_interaction(&hit).err(), Some(ForeignHit));
    assert!(other.try_interaction(&hit).is_ok() && other.clone().try_interaction(&hit).is_ok());
    let interaction = || scene.interaction(&hit).position;
    assert!(std::panic::catch_unwind(std::panic::AssertUnwindSafe(interaction)).is_err());
}

#[test]
fn primitives_have_their_names() {
    let scene = compiled(SCENE, "all");
    let names: Vec<_> = (0..scene.primitive_count() as u32).map(|i| scene.primitive_name(i)).collect();
    assert_eq!(names, [Some("ball"), Some("star"), Some("box")]);
    assert_eq!(scene.primitive_name(3), None);
}
