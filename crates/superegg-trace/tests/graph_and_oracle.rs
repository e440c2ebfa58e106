//! The compiled graph against the list of all instances, on random scenes that hold themselves.

use num_bigint::BigUint;
use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use std::sync::atomic::AtomicBool;

use superegg_geom::Ray;
use superegg_geom::glam::DVec3;
use superegg_lang::load_text;
use superegg_scene::Scene;
use superegg_trace::CompiledScene;
use superegg_trace::reference::{self, FlatInstance};

/// Four primitives and three objects with children among all of them, themselves included.
fn scene_text() -> impl Strategy<Value = String> {
    let exponent = prop::sample::select(vec!["0.1", "0.5", "1", "2", "3"]);
    let primitives =
        prop::collection::vec((exponent.clone(), exponent, prop::array::uniform3(0.2..0.9f64)), 4);
    let name = prop::sample::select(vec!["p0", "p1", "p2", "p3", "o0", "o1", "o2"]);
    let child = (
        name,
        prop::array::uniform3(-2.0..2.0f64),
        prop::array::uniform3(-1.0..1.0f64),
        -180.0..180.0f64,
        0.4..0.9f64,
    );
    let objects = prop::collection::vec((prop::collection::vec(child, 0..5), -90.0..90.0f64), 3);
    (primitives, objects).prop_map(|(primitives, objects)| {
        let mut text = String::new();
        for (i, (e, n, [x, y, z])) in primitives.iter().enumerate() {
            text += &format!("prm p{i}\nexp {e} {n}\ncoeff {x} {y} {z}\n");
        }
        text += "obj o0\nobj o1\nobj o2\n";
        for (i, (children, turn)) in objects.iter().enumerate() {
            text += &format!("obj o{i}\nrall 0 1 1 {turn}\n");
            for (j, (name, [x, y, z], [ax, ay, az], angle, scale)) in children.iter().enumerate() {
                let add = if name.starts_with('p') { "ap" } else { "ao" };
                text += &format!("{add} {name} c{j}\nss {scale} {scale} -{scale}\nrs {ax} {ay} {az} {angle}\nxs {x} {y} {z}\n");
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

fn both(text: &str, depth: u32) -> Option<(CompiledScene, Vec<FlatInstance>)> {
    let scene = load(text);
    let flat = reference::flatten(&scene, "o0", depth, 3000)?;
    Some((CompiledScene::compile(&scene, Some("o0"), depth), flat))
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, rng_seed: RngSeed::Fixed(4), failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn the_graph_stands_for_every_instance(text in scene_text(), depth in 0..8u32) {
        if let Some((compiled, flat)) = both(&text, depth) {
            prop_assert_eq!(compiled.instance_count().to_string(), flat.len().to_string());
        }
    }

    #[test]
    fn rays_hit_the_same_instance_at_the_same_place(
        text in scene_text(), depth in 1..6u32,
        rays in prop::collection::vec((prop::array::uniform3(-6.0..6.0f64), prop::array::uniform3(-2.0..2.0f64)), 30),
    ) {
        let Some((compiled, flat)) = both(&text, depth) else { return Ok(()) };
        for (origin, target) in rays {
            let ray = Ray::new(origin.into(), DVec3::from(target) - DVec3::from(origin));
            let (graph, list) = (compiled.intersect_ray(&ray), reference::intersect(&flat, &ray));
            prop_assert_eq!(graph.is_some(), list.is_some(), "{:?} {:?}", graph, list);
            if let (Some(hit), Some((i, flat_hit))) = (graph, list) {
                prop_assert!((hit.t - flat_hit.t).abs() < 1e-9, "{hit:?} {flat_hit:?}");
                prop_assert_eq!(hit.leaving, flat_hit.leaving);
                // Two shapes may be met at once; else it is the same one.
                let name = compiled.path_name(&hit.path);
                let same_place = |other: &FlatInstance| {
                    other.path == name && other.shape.norm().value(
                        other.world_from_local.inverse().transform_point3(ray.point_at(hit.t)) / other.shape.radii()) < 1.0 + 1e-6
                };
                prop_assert!(flat[i].path == name || flat.iter().any(same_place), "{name} is not {}", flat[i].path);
                let surface = compiled.interaction(&hit);
                prop_assert!((surface.position - ray.point_at(hit.t)).length() < 1e-9);
                let expected = flat[i].world_from_local.normal_to_world(flat[i].shape.normal(flat_hit.point)).normalize();
                prop_assert!(flat[i].path != name || surface.normal.dot(expected) > 1.0 - 1e-6, "{} {expected}", surface.normal);
                prop_assert!(compiled.occluded(&ray.into(), hit.t * (1.0 + 1e-9) + 1e-9));
                prop_assert!(!compiled.occluded(&ray.into(), hit.t * (1.0 - 1e-9)));
            }
        }
    }

    #[test]
    fn points_have_the_same_least_value(
        text in scene_text(), depth in 1..6u32, points in prop::collection::vec(prop::array::uniform3(-4.0..4.0f64), 50),
    ) {
        let Some((compiled, flat)) = both(&text, depth) else { return Ok(()) };
        for point in points {
            let answer = compiled.query_point(point.into());
            let contains = compiled.contains_point_unless(point.into(), &AtomicBool::new(false));
            let is_at_surface = answer.least.as_ref().is_some_and(|(value, _)| value.abs() < 1e-9);
            assert!(is_at_surface || contains == Some(answer.inside), "{point:?}");
            let broken_off = compiled.contains_point_unless(point.into(), &AtomicBool::new(true));
            assert!(broken_off.is_none() || compiled.bounds().is_none());
            let expected = reference::least_value(&flat, point.into());
            prop_assert_eq!(answer.least.is_some(), expected.is_some());
            if let (Some((value, path)), Some((i, least))) = (&answer.least, expected) {
                prop_assert!((value - least).abs() < 1e-7 * (1.0 + least.abs()) || *value == least, "{value} {least}");
                prop_assert!(compiled.path_name(path) == flat[i].path || *value == least, "{} {}", compiled.path_name(path), flat[i].path);
                prop_assert_eq!(answer.inside, *value < 0.0);
            }
        }
    }
}

#[test]
fn depth_counts_the_selected_object_as_level_one() {
    let text = "prm p\nobj o\nap p\nao o deeper\nss .5 .5 .5\nxs 0 0 2\n";
    for depth in 0..=64 {
        let compiled = CompiledScene::compile(&load(text), Some("o"), depth);
        assert_eq!(compiled.instance_count().to_string(), depth.to_string());
        assert!(compiled.group_count() <= depth as usize);
    }
    let primitive = CompiledScene::compile(&load(text), Some("p"), 0);
    assert_eq!((primitive.instance_count().to_string().as_str(), primitive.group_count()), ("1", 0));
}

#[test]
fn a_fractal_is_a_small_graph_however_many_instances() {
    let children: String = (0..20).map(|i| format!("ao o c{i}\nss .1 .1 .1\nxs {i} 0 0\n")).collect();
    let compiled = CompiledScene::compile(&load(&format!("prm p\nobj o\nap p\n{children}")), Some("o"), 64);
    assert_eq!(compiled.group_count(), 64);
    // 1 + 20 + ... + 20^63
    let expected: BigUint = (BigUint::from(20u32).pow(64) - 1u32) / 19u32;
    assert_eq!(compiled.instance_count().to_string(), expected.to_string());
    assert!((compiled.instance_count().to_f64() / 20f64.powi(64) * 19.0 - 1.0).abs() < 1e-12);
    let hit = compiled.intersect_ray(&Ray::new(DVec3::new(0.0, 0.0, 10.0), DVec3::NEG_Z)).unwrap();
    assert_eq!(hit.t, 9.0);
    assert!(compiled.query_point(DVec3::ZERO).inside);
}

#[test]
fn an_object_without_objects_is_one_group_at_any_depth() {
    let text = "prm p\nobj leaf\nap p\nobj a\nao leaf\nobj b\nao a\nao leaf\n";
    assert_eq!(CompiledScene::compile(&load(text), Some("b"), 25).group_count(), 3);
}
