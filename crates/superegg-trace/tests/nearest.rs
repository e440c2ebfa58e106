//! The nearest primitive and the signed distance against a loop over all instances.

use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use superegg_geom::glam::DVec3;
use superegg_lang::load_text;
use superegg_scene::Scene;
use superegg_trace::reference::{self, FlatInstance};
use superegg_trace::{CompiledScene, PointLimits};

/// Objects in objects, with rotations, mirrors, flat scales and shears.
fn scene_text() -> impl Strategy<Value = String> {
    let exponent = prop::sample::select(vec!["0.1", "0.5", "1", "2", "3"]);
    let primitives =
        prop::collection::vec((exponent.clone(), exponent, prop::array::uniform3(0.1..0.9f64)), 3);
    let name = prop::sample::select(vec!["ap p0", "ap p1", "ap p2", "ao o1"]);
    let child = (
        name,
        prop::array::uniform3(-3.0..3.0f64),
        prop::array::uniform3(-1.0..1.0f64),
        -180.0..180.0f64,
        prop::array::uniform3(0.3..1.1f64),
    );
    let objects = prop::collection::vec(prop::collection::vec(child, 1..5), 2);
    (primitives, objects).prop_map(|(primitives, objects)| {
        let mut text = String::new();
        for (i, (e, n, [x, y, z])) in primitives.iter().enumerate() {
            text += &format!("prm p{i}\nexp {e} {n}\ncoeff {x} {y} {z}\n");
        }
        text += "obj o0\nobj o1\n";
        for (i, children) in objects.iter().enumerate() {
            text += &format!("obj o{i}\n");
            for (j, (add, [x, y, z], [ax, ay, az], angle, [sx, sy, sz])) in children.iter().enumerate() {
                text +=
                    &format!("{add} c{j}\nss {sx} {sy} -{sz}\nrs {ax} {ay} {az} {angle}\nxs {x} {y} {z}\n");
            }
        }
        text + "obj o0\n"
    })
}

fn load(text: &str) -> Scene {
    let (session, diagnostics) = load_text("random.scn", text);
    assert!(diagnostics.is_empty(), "{diagnostics:?}");
    session.scene().clone()
}

fn both(text: &str) -> Option<(CompiledScene, Vec<FlatInstance>)> {
    let scene = load(text);
    let flat = reference::flatten(&scene, "o0", 3, 40)?;
    Some((CompiledScene::compile(&scene, Some("o0"), 3), flat))
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 60, rng_seed: RngSeed::Fixed(5), failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn answers_are_those_of_all_instances(
        text in scene_text(), points in prop::collection::vec(prop::array::uniform3(-7.0..7.0f64), 12),
    ) {
        let Some((compiled, flat)) = both(&text) else { return Ok(()) };
        let limits = PointLimits::default();
        for point in points.into_iter().map(DVec3::from) {
            let answer = compiled.nearest_primitive(point, &limits);
            let distance = compiled.signed_distance(point, &limits);
            let (holders, is_complete) = compiled.primitives_holding(point, 100, &limits);
            prop_assert!(is_complete);
            let mut expected: Vec<&str> =
                reference::holding(&flat, point).into_iter().map(|i| flat[i].path.as_str()).collect();
            let mut found: Vec<String> = holders.iter().map(|holder| compiled.path_name(&holder.path)).collect();
            expected.sort_unstable();
            found.sort();
            prop_assert_eq!(&found, &expected);
            let Some((i, least)) = reference::nearest(&flat, point) else {
                prop_assert!(answer.is_none() && distance.is_none());
                continue;
            };
            let (answer, distance) = (answer.unwrap(), distance.unwrap());
            prop_assert!(answer.is_complete && distance.is_complete);
            prop_assert_eq!(answer.inside, !holders.is_empty());
            let room = 1e-7 * (1.0 + least.abs());
            prop_assert!((distance.distance - least).abs() < room, "{} {}", distance.distance, least);
            prop_assert!(distance.error < room || distance.distance < 0.0);
            match compiled.query_point(point).least {
                // As always where boxes hold the point.
                Some((value, path)) => prop_assert_eq!((answer.value, &answer.path), (value, &path)),
                None => {
                    prop_assert_eq!(compiled.path_name(&answer.path), flat[i].path.clone());
                    let local = flat[i].world_from_local.inverse().transform_point3(point);
                    let value = flat[i].shape.inside_outside(local);
                    prop_assert!((answer.value / value - 1.0).abs() < 1e-9);
                    prop_assert_eq!(&answer.path, &distance.path);
                }
            }
        }
    }
}

#[test]
fn of_equally_near_primitives_the_first_child_counts() {
    let text = "prm p\nexp .5 .5\nobj o0\nap p b\nxs 2 0 0\nap p a\nxs -2 0 0\nap p c\nxs 0 2 0\n";
    let compiled = CompiledScene::compile(&load(text), Some("o0"), 1);
    let answer = compiled.nearest_primitive(DVec3::new(0.0, 0.0, 5.0), &PointLimits::default()).unwrap();
    assert_eq!(compiled.path_name(&answer.path), "o0/b");
}

#[test]
fn an_empty_scene_and_points_that_are_not_finite_have_no_answer() {
    let limits = PointLimits::default();
    let empty = CompiledScene::compile(&load("obj o0\n"), Some("o0"), 1);
    assert_eq!(empty.nearest_primitive(DVec3::ZERO, &limits), None);
    assert_eq!(empty.signed_distance(DVec3::ZERO, &limits), None);
    let ball = CompiledScene::compile(&load("prm o0\n"), Some("o0"), 1);
    for x in [f64::NAN, f64::INFINITY] {
        assert_eq!(ball.nearest_primitive(DVec3::new(x, 0.0, 0.0), &limits), None);
        assert_eq!(ball.signed_distance(DVec3::new(x, 0.0, 0.0), &limits), None);
    }
    for x in [1e300, 1e200, 1e9] {
        let far = ball.signed_distance(DVec3::new(x, 0.0, 0.0), &limits).unwrap();
        assert!((far.distance / x - 1.0).abs() < 1e-8, "{far:?}");
    }
}

/// The answer of a search that its limits have ended is true within the error that it gives.
#[test]
fn a_search_that_is_ended_gives_an_error_that_holds() {
    let children: String =
        (0..30).map(|i| format!("ap p c{i}\nxs {} {} {}\n", (7 * i) % 11, (5 * i) % 7, i % 3)).collect();
    let scene = load(&format!("prm p\nexp .3 .7\ncoeff .3 .2 .4\nobj o0\n{children}"));
    let flat = reference::flatten(&scene, "o0", 1, 100).unwrap();
    let compiled = CompiledScene::compile(&scene, Some("o0"), 1);
    let mut ended = 0;
    for queued in [0, 1, 8, 16, 24] {
        let mut limits = PointLimits::default();
        limits.queued = queued;
        for point in [DVec3::new(-3.0, 2.0, 9.0), DVec3::new(4.4, 3.3, 1.5), DVec3::new(30.0, -1.0, 0.0)] {
            let (_, least) = reference::nearest(&flat, point).unwrap();
            let answer = compiled.signed_distance(point, &limits).unwrap();
            assert!(
                answer.distance >= least - 1e-9 && answer.distance - answer.error <= least + 1e-9,
                "{answer:?} {least}"
            );
            ended += u32::from(!answer.is_complete);
        }
    }
    assert!(ended > 0);
}
