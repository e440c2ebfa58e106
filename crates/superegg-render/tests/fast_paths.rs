//! Ray streams against single rays, recompiling against compiling, deep graphs against composition
//! in twice the precision.

use std::cell::Cell;

use proptest::prelude::*;
use proptest::test_runner::{RngSeed, TestRunner};
use superegg_geom::glam::{DMat3, DVec3, Vec3Swizzles};
use superegg_geom::{Aabb, Exponents, Ray, Superquadric, TransformStep};
use superegg_lang::load_text;
use superegg_render::{Film, Pixel, RenderOptions, RenderSettings, render};
use superegg_scene::{Camera, Entity, Light, LightKind, Picture, Scene};
use superegg_trace::reference;
use superegg_trace::{CompiledScene, Footprint, TraceRay};

fn load(text: &str) -> Scene {
    let (session, diagnostics) = load_text("fast.scn", text);
    assert!(diagnostics.is_empty(), "{diagnostics:?}");
    session.scene().clone()
}

/// Shapes of all kinds at random, some in groups of their own.
fn scene_text() -> impl Strategy<Value = String> {
    let exponent = prop::sample::select(vec!["0.05", "0.3", "1", "1.7", "2", "3"]);
    let shape = (
        exponent.clone(),
        exponent,
        prop::array::uniform3(0.1..0.7f64),
        prop::array::uniform3(-2.0..2.0f64),
        0..3u8,
    );
    prop::collection::vec(shape, 1..60).prop_map(|shapes| {
        let mut text = String::from("obj part\nobj all\nao part one\nrs 1 1 0 50\nss .7 .7 -.7\nao part two\nxs 1 0 -1\n");
        for (i, (e, n, [x, y, z], [a, b, c], group)) in shapes.iter().enumerate() {
            let object = if *group == 0 { "part" } else { "all" };
            text += &format!("prm p{i}\nexp {e} {n}\ncoeff {x} {y} {z}\nobj {object}\nap p{i}\nrs {a} {b} {c} 77\nxs {c} {a} {b}\n");
        }
        text + "obj all\n"
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 60, rng_seed: RngSeed::Fixed(6), failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn streams_answer_as_single_rays_do(
        text in scene_text(),
        rays in prop::collection::vec((prop::array::uniform3(-3.0..3.0f64), prop::array::uniform3(-1.0..1.0f64)), 200),
    ) {
        let scene = CompiledScene::compile(&load(&text), Some("all"), 5);
        let mut traced: Vec<TraceRay> =
            rays.iter().map(|(origin, direction)| Ray::new((*origin).into(), (*direction).into()).into()).collect();
        // Some start at the hits of others.
        let further: Vec<TraceRay> = traced.iter().filter_map(|ray| {
            let hit = scene.intersect_ray(&ray.ray)?;
            Some(scene.interaction(&hit).spawn_ray(ray.ray.direction.yzx()))
        }).collect();
        traced.extend(further);
        let (hits, occluded) = (scene.intersect_many(&traced), scene.occluded_many(&traced, 1.5));
        for ((ray, hit), occluded) in traced.iter().zip(hits).zip(occluded) {
            let expected = scene.intersect(ray);
            prop_assert_eq!(hit.is_some(), expected.is_some(), "{:?} {:?} {:?}", ray, hit, expected);
            if let (Some(hit), Some(expected)) = (hit, expected) {
                prop_assert!((hit.t - expected.t).abs() < 1e-9 * (1.0 + expected.t), "{hit:?} {expected:?}");
                prop_assert_eq!(hit.path, expected.path);
                prop_assert_eq!((hit.leaving, hit.primitive), (expected.leaving, expected.primitive));
            }
            prop_assert_eq!(occluded, scene.occluded(ray, 1.5), "{:?}", ray);
        }
    }

    #[test]
    fn a_box_holds_what_the_list_of_all_instances_says(
        text in scene_text(), center in prop::array::uniform3(-2.0..2.0f64), half in 0.05..1.0f64,
    ) {
        let scene = load(&text);
        let compiled = CompiledScene::compile(&scene, Some("all"), 5);
        let query = Aabb::around(center.into(), DVec3::splat(half));
        let mut found: Vec<String> =
            compiled.query_box(&query, usize::MAX).iter().map(|path| compiled.path_name(path)).collect();
        let mut expected: Vec<String> = reference::flatten(&scene, "all", 5, 10_000).unwrap().into_iter()
            .filter(|flat| {
                let forward = flat.world_from_local.forward();
                Aabb::around(forward.translation, flat.shape.half_extent_under(&forward.matrix3)).intersects(&query)
            })
            .map(|flat| flat.path).collect();
        found.sort();
        expected.sort();
        prop_assert_eq!(found, expected);
    }

    #[test]
    fn recompiling_is_compiling(text in scene_text(), rays in prop::collection::vec((prop::array::uniform3(-3.0..3.0f64), prop::array::uniform3(-1.0..1.0f64)), 40)) {
        let mut scene = load(&text);
        let before = CompiledScene::compile(&scene, Some("all"), 5);
        prop_assert_eq!(before.recompile(&scene, Some("all"), 5).reused_group_count(), before.group_count());
        let first = scene.primitives().map(|(name, _)| name.to_owned()).next().unwrap();
        scene.primitive_mut(&first).unwrap().shape = superegg_geom::Superquadric::unit_sphere();
        let (again, anew) = (before.recompile(&scene, Some("all"), 5), CompiledScene::compile(&scene, Some("all"), 5));
        for (origin, direction) in rays {
            let ray = Ray::new(origin.into(), direction.into());
            prop_assert_eq!(again.intersect_ray(&ray), anew.intersect_ray(&ray));
        }
    }
}

/// One change of a flat scene of many shapes: the child, the property and the amount.
type Edit = (usize, u8, [f64; 3]);

fn edits() -> impl Strategy<Value = Vec<Edit>> {
    prop::collection::vec((0..usize::MAX, 0..6u8, prop::array::uniform3(0.02..1.0f64)), 1..12)
}

/// A flat object of 300 to 700 shapes in a box of half edge 6, with another that holds it twice.
fn flat_text() -> impl Strategy<Value = String> {
    let exponent = prop::sample::select(vec!["0.05", "0.3", "1", "1.7", "2", "3"]);
    let shape = (
        exponent.clone(),
        exponent,
        prop::array::uniform3(0.05..0.4f64),
        prop::array::uniform3(-6.0..6.0f64),
    );
    prop::collection::vec(shape, 300..700).prop_map(|shapes| {
        let mut text = String::from("obj flat\n");
        for (i, (e, n, [x, y, z], [a, b, c])) in shapes.iter().enumerate() {
            text += &format!("prm p{i}\nexp {e} {n}\ncoeff {x} {y} {z}\nobj flat\nap p{i} c{i}\nrs {a} {b} {c} 77\nxs {c} {a} {b}\n");
        }
        text + "obj all\nao flat near\nao flat far\nrs 1 2 3 30\nxs 14 0 0\n"
    })
}

fn edit(scene: &mut Scene, (which, what, amount): &Edit) {
    let count = scene.object("flat").unwrap().children().len();
    let which = which % count;
    let (alias, target) = {
        let flat = scene.object("flat").unwrap();
        let (alias, child) = flat.children().nth(which).unwrap();
        (alias.to_owned(), child.target().to_owned())
    };
    let [x, y, z] = *amount;
    let step = |scene: &mut Scene, step| {
        scene.move_cursor("flat", &alias).unwrap();
        scene.transform_child("flat", step).unwrap();
    };
    let shape = scene.primitive(&target).unwrap().shape;
    match what {
        0 => step(scene, TransformStep::Translate(DVec3::new(x, -y, z))),
        1 => step(scene, TransformStep::Rotate { axis: DVec3::new(x, y, z), angle_deg: 360.0 * x }),
        2 => step(scene, TransformStep::Scale(DVec3::new(0.5 + x, 0.5 + y, -0.5 - z))),
        3 => {
            let radii = DVec3::new(x, y, z);
            scene.primitive_mut(&target).unwrap().shape =
                Superquadric::new(radii, shape.exponents()).unwrap();
        }
        4 => {
            let exponents = Exponents::new(2.5 * x, 2.5 * y).unwrap();
            scene.primitive_mut(&target).unwrap().shape =
                Superquadric::new(shape.radii(), exponents).unwrap();
        }
        _ => scene.primitive_mut(&target).unwrap().material.color = DVec3::new(x, y, z),
    }
}

/// The answers of all queries: hits with path and colour, occlusion, containment and boxes.
fn assert_same_answers(one: &CompiledScene, other: &CompiledScene, rays: &[([f64; 3], [f64; 3])]) {
    assert_eq!(one.instance_count(), other.instance_count());
    let traced: Vec<TraceRay> = rays
        .iter()
        .map(|(origin, direction)| Ray::new((*origin).into(), (*direction).into()).into())
        .collect();
    let sides = [one, other].map(|scene| {
        let details = |hit: &superegg_trace::Hit| {
            let color = scene.interaction(hit).material.color;
            (hit.t, hit.leaving, hit.primitive, hit.unit_point, scene.path_name(&hit.path), color)
        };
        let single: Vec<_> =
            traced.iter().map(|f| scene.intersect_ray(&f.ray).as_ref().map(details)).collect();
        let many: Vec<_> =
            scene.intersect_many(&traced).iter().map(|hit| hit.as_ref().map(details)).collect();
        let occluded = scene.occluded_many(&traced, 1.5);
        let occluded_single: Vec<bool> = traced.iter().map(|f| scene.occluded(&f.ray.into(), 1.5)).collect();
        let held: Vec<_> = rays
            .iter()
            .map(|(origin, reach)| {
                let point = DVec3::from(*origin);
                let around = Aabb::around(point, DVec3::from(*reach).abs());
                let mut names: Vec<String> =
                    scene.query_box(&around, usize::MAX).iter().map(|path| scene.path_name(path)).collect();
                names.sort();
                let answer = scene.query_point(point);
                let least = answer.least.map(|(value, path)| (value, scene.path_name(&path)));
                (answer.inside, least, names)
            })
            .collect();
        (single, many, occluded, occluded_single, held)
    });
    assert_eq!(sides[0].0, sides[1].0);
    assert_eq!(sides[0].1, sides[1].1);
    assert_eq!(sides[0].2, sides[1].2);
    assert_eq!(sides[0].3, sides[1].3);
    assert_eq!(sides[0].4, sides[1].4);
}

/// A small film with all that it keeps of surfaces, the numbers of instances among it.
fn picture(scene: &Scene, compiled: &CompiledScene) -> Film {
    let mut scene = scene.clone();
    scene.camera = Camera { position: DVec3::new(7.0, -30.0, 12.0), target: DVec3::X * 7.0, ..scene.camera };
    let picture = Picture { width: 32, height: 24, ..scene.picture };
    let settings = RenderSettings::of(&scene).with_picture(picture);
    render(compiled, &settings, &RenderOptions::default().with_threads(1)).unwrap().film
}

/// Equal instances; other values equal within the precision of f32 positions.
fn assert_same_film(a: &Film, b: &Film) {
    for (i, (a, b)) in a.pixels().zip(b.pixels()).enumerate() {
        assert_eq!((a.id, a.samples, a.albedo, a.alpha), (b.id, b.samples, b.albedo, b.alpha), "pixel {i}");
        let is_close = |a: f32, b: f32| a == b || (a - b).abs() <= 2e-4 * (1.0 + a.abs());
        let numbers = |pixel: &Pixel| pixel.color.into_iter().chain(pixel.normal).chain([pixel.depth]);
        assert!(numbers(&a).zip(numbers(&b)).all(|(a, b)| is_close(a, b)), "pixel {i}: {a:?} {b:?}");
    }
}

/// Each scene compiled after the one before, patches on patches, against each compiled anew.
#[test]
fn a_patched_group_answers_as_one_compiled_anew() {
    let config = ProptestConfig {
        cases: 24,
        rng_seed: RngSeed::Fixed(7),
        failure_persistence: None,
        ..ProptestConfig::default()
    };
    let ray = (prop::array::uniform3(-8.0..8.0f64), prop::array::uniform3(-1.0..1.0f64));
    let cases = (flat_text(), prop::collection::vec(edits(), 1..5), prop::collection::vec(ray, 100));
    let (patched, compiled_anew) = (Cell::new(0), Cell::new(0));
    let answer = TestRunner::new(config).run(&cases, |(text, rounds, rays)| {
        let mut scene = load(&text);
        let mut compiled = CompiledScene::compile(&scene, Some("all"), 5);
        for round in rounds {
            round.iter().for_each(|change| edit(&mut scene, change));
            compiled = compiled.recompile(&scene, Some("all"), 5);
            let of_two = if compiled.patched_group_count() == 1 { &patched } else { &compiled_anew };
            of_two.set(of_two.get() + 1);
            let anew = CompiledScene::compile(&scene, Some("all"), 5);
            assert_same_answers(&compiled, &anew, &rays);
            assert_same_film(&picture(&scene, &compiled), &picture(&scene, &anew));
        }
        Ok(())
    });
    assert!(answer.is_ok(), "{}", answer.unwrap_err());
    assert!(patched.get() > 20, "{} patched, {} anew", patched.get(), compiled_anew.get());
}

/// A grid of 1,000 balls, so that the tree and what it spans are known.
fn grid() -> Scene {
    let mut text = String::from("prm ball\ncoeff .3 .3 .3\nprm other\ncoeff .3 .3 .3\nobj flat\n");
    for i in 0..1000 {
        let ball = if i == 555 { "other" } else { "ball" };
        text += &format!("ap {ball} c{i}\nxs {} {} {}\n", i % 10, i / 10 % 10, i / 100);
    }
    load(&text)
}

#[test]
fn small_changes_are_patched_and_large_ones_are_not() {
    let scene = grid();
    let before = CompiledScene::compile(&scene, Some("flat"), 5);
    let patched = |change: &dyn Fn(&mut Scene)| {
        let mut scene = scene.clone();
        change(&mut scene);
        let again = before.recompile(&scene, Some("flat"), 5);
        (again.reused_group_count(), again.patched_group_count())
    };
    let moved = |alias: &'static str, by: DVec3| {
        move |scene: &mut Scene| {
            scene.move_cursor("flat", alias).unwrap();
            scene.transform_child("flat", TransformStep::Translate(by)).unwrap();
        }
    };
    assert_eq!(patched(&|_| ()), (1, 0));
    assert_eq!(patched(&|scene| scene.primitive_mut("ball").unwrap().material.color = DVec3::X), (1, 0));
    assert_eq!(patched(&moved("c555", DVec3::new(0.3, 0.0, 0.0))), (0, 1));
    let sphere = Superquadric::unit_sphere();
    assert_eq!(patched(&|scene| scene.primitive_mut("other").unwrap().shape = sphere), (0, 1));
    let square = Superquadric::new(DVec3::splat(0.3), Exponents::new(0.1, 0.1).unwrap()).unwrap();
    assert_eq!(patched(&|scene| scene.primitive_mut("other").unwrap().shape = square), (0, 1));
    // Beyond the tree's space, and a tree that no longer fits.
    assert_eq!(patched(&moved("c555", DVec3::new(100.0, 0.0, 0.0))), (0, 0));
    let scatter = |scene: &mut Scene| {
        for i in (0..1000).step_by(3) {
            scene.move_cursor("flat", &format!("c{i}")).unwrap();
            let by = DVec3::new(f64::from(i * 7 % 10 - i % 10), f64::from(i * 3 % 10 - i / 10 % 10), 0.0);
            scene.transform_child("flat", TransformStep::Translate(by)).unwrap();
        }
    };
    assert_eq!(patched(&scatter), (0, 0));
    // One more or fewer is another tree.
    assert_eq!(patched(&|scene| scene.remove_child("flat", "c3").unwrap()), (0, 0));
}

#[test]
fn a_tree_that_is_patched_again_and_again_is_built_anew_in_the_end() {
    let mut scene = grid();
    let mut compiled = CompiledScene::compile(&scene, Some("flat"), 5);
    let mut rebuilt = 0;
    for i in 0..600 {
        // The positions are shuffled and jittered, so that no two spheres coincide.
        scene.move_cursor("flat", &format!("c{i}")).unwrap();
        let (x, y) = (i % 10, i / 10 % 10);
        let by = DVec3::new(f64::from(x * 3 % 10 - x) + 0.4, f64::from(y * 7 % 10 - y), 0.0);
        scene.transform_child("flat", TransformStep::Translate(by)).unwrap();
        compiled = compiled.recompile(&scene, Some("flat"), 5);
        rebuilt += 1 - compiled.patched_group_count();
    }
    assert!((1..100).contains(&rebuilt), "{rebuilt}");
}

#[test]
fn what_does_not_depend_on_a_change_is_taken_over() {
    let mut scene = load(
        "prm a\nprm b\nobj left\nap a x\nap a y\nxs 1 0 0\nobj right\nap b x\nap b y\nxs 1 0 0\nobj all\nao left\nao right\nxs 5 0 0\n",
    );
    let before = CompiledScene::compile(&scene, Some("all"), 9);
    assert_eq!(before.group_count(), 3);
    scene.primitive_mut("b").unwrap().material.color = DVec3::X;
    assert_eq!(before.recompile(&scene, Some("all"), 9).reused_group_count(), 3, "a colour is in no tree");
    scene.primitive_mut("b").unwrap().shape =
        superegg_geom::Superquadric::new(DVec3::splat(0.5), superegg_geom::Exponents::ROUND).unwrap();
    assert_eq!(before.recompile(&scene, Some("all"), 9).reused_group_count(), 1, "the left one stays");
}

/// A number in twice the precision: an unevaluated sum.
#[derive(Clone, Copy)]
struct Double(f64, f64);

impl Double {
    fn sum(a: f64, b: f64) -> Self {
        let s = a + b;
        let back = s - a;
        Self(s, (a - (s - back)) + (b - back))
    }

    fn plus(self, other: Self) -> Self {
        let s = Self::sum(self.0, other.0);
        Self::sum(s.0, s.1 + self.1 + other.1)
    }

    fn times(self, factor: f64) -> Self {
        let p = self.0 * factor;
        Self::sum(p, self.0.mul_add(factor, -p) + self.1 * factor)
    }
}

/// A point through a list of maps, the last one first.
fn mapped(maps: &[superegg_geom::Transform], point: DVec3) -> [Double; 3] {
    let mut at = point.to_array().map(|x| Double(x, 0.0));
    for map in maps.iter().rev() {
        let forward = map.forward();
        let rows: DMat3 = forward.matrix3.transpose();
        at = std::array::from_fn(|axis| {
            let row = rows.col(axis);
            (0..3).fold(Double(forward.translation[axis], 0.0), |sum, j| sum.plus(at[j].times(row[j])))
        });
    }
    at
}

/// Forty levels, none of which can be folded into another.
fn forty_levels(scale: &str) -> String {
    let mut text = String::from(
        "prm shape\nexp .3 .6\ncoeff .9 .5 .7\nprm mote\ncoeff .001 .001 .001\nobj o40\nap shape\nap mote\nxs 90 0 0\n",
    );
    for level in (0..40).rev() {
        let turn = 17 + 13 * level % 90;
        text += &format!(
            "obj o{level}\nao o{} deeper\nss {scale}\nrs 1 2 {} {turn}\nxs .{level} .3 -.2\nap mote\nxs 90 {level} 3\n",
            level + 1,
            level % 5
        );
    }
    text + "obj o0\n"
}

/// Shapes of all kinds, alone and in turned groups of groups.
fn crowd() -> Scene {
    let mut text = String::from(
        "obj part\nobj clump\nao part one\nrs 1 1 0 50\nss .6 .7 -.7\nao part two\nxs .8 .3 -.5\nss .5 .5 .5\nobj all\nao clump one\nao clump two\nrs 1 0 1 30\nxs -1.3 .4 1\n",
    );
    let exponents = ["0.0001", "0.1", "0.6", "1", "1.5", "2", "4"];
    for i in 0..150 {
        let a = f64::from(i);
        let [x, y, z] = [a.sin(), (1.7 * a).cos(), (0.6 * a).sin()].map(|x| 2.0 * x);
        let (e, n) = (exponents[i as usize % 7], exponents[i as usize * 3 % 7]);
        let object = if i % 4 == 0 { "part" } else { "all" };
        text += &format!(
            "prm p{i}\nexp {e} {n}\ncoeff .4 .2 .3\nobj {object}\nap p{i}\nrs {x} {y} 1 77\nxs {x} {y} {z}\n"
        );
    }
    load(&(text + "obj all\n"))
}

#[test]
fn more_rays_than_go_together_and_hostile_ones_answer_as_single_rays_do() {
    let scene = CompiledScene::compile(&crowd(), Some("all"), 5);
    let hostile = [0.0, -0.0, f64::INFINITY, f64::NAN, 1e300, -1e300, 1e-300, 5e-324, 1.0];
    let mut rays: Vec<TraceRay> = (0..20_000)
        .map(|i| {
            let a = f64::from(i);
            let mut origin = DVec3::new((1.3 * a).sin(), (0.7 * a).cos(), (2.9 * a).sin()) * 3.0;
            let mut direction = DVec3::new((2.1 * a).cos(), (1.1 * a).sin(), (0.37 * a).cos());
            match i % 50 {
                // Along an axis, or in a plane of two.
                0 => direction = DVec3::AXES[i as usize / 50 % 3] * direction,
                1 => direction.z = 0.0,
                2 => origin[i as usize / 50 % 3] = hostile[i as usize / 150 % hostile.len()],
                3 => direction[i as usize / 50 % 3] = hostile[i as usize / 150 % hostile.len()],
                4 => direction *= [1e-200, 1e200, 1e-20, 1e20][i as usize / 50 % 4],
                5 => (origin, direction) = (-1e9 * direction, direction),
                _ => {}
            }
            let footprint = Footprint { width: if i % 11 == 0 { 0.5 } else { 0.0 }, spread: 0.0 };
            TraceRay { footprint, ..Ray::new(origin, direction).into() }
        })
        .collect();
    let first = scene.intersect_many(&rays);
    // Rays that start at these hits, some of them into the shape; some graze the surface from
    // inside.
    let further: Vec<TraceRay> = rays
        .iter()
        .zip(&first)
        .enumerate()
        .filter_map(|(i, (ray, hit))| {
            let surface = scene.interaction(hit.as_ref()?);
            let any = ray.ray.direction.zxy();
            let along = any - any.dot(surface.normal) * surface.normal;
            let direction = match i % 4 {
                0 => along - 0.1f64.powi(i as i32 / 4 % 10) * along.length() * surface.normal,
                _ => any,
            };
            Some(surface.spawn_ray(direction).with_footprint(ray.footprint))
        })
        .collect();
    assert!(further.len() > 4_000, "{}", further.len());
    rays.extend(further);
    let mut leaving = 0;
    for (ray, hit) in rays.iter().zip(scene.intersect_many(&rays)) {
        let expected = scene.intersect(ray);
        let identity = |hit: &superegg_trace::Hit| (hit.path.clone(), hit.leaving, hit.primitive);
        assert_eq!(hit.as_ref().map(identity), expected.as_ref().map(identity), "{ray:?}");
        if let (Some(hit), Some(expected)) = (hit, expected) {
            leaving += usize::from(hit.leaving);
            let [normal, exact] = [&hit, &expected].map(|hit| scene.interaction(hit).normal);
            assert!(normal.distance(exact) < 1e-6, "{normal} {exact} {ray:?}");
            assert!((hit.t - expected.t).abs() <= 1e-9 * (1.0 + expected.t), "{hit:?} {expected:?}");
        }
    }
    assert!(leaving > 1_000, "{leaving}");
    for t_max in [1.5, f64::INFINITY, f64::MAX, 1e-300, 0.0, -1.0, f64::NAN] {
        for (ray, occluded) in rays.iter().zip(scene.occluded_many(&rays, t_max)) {
            let expected = scene.occluded(ray, t_max);
            assert_eq!(occluded, expected, "{t_max} {ray:?}");
        }
    }
}

#[test]
fn a_ray_through_forty_levels_meets_the_surface_within_a_twentieth_of_a_pixel() {
    for scale in [".7 .7 .7", ".8 .6 .75", "1.1 .9 1"] {
        let scene = load(&forty_levels(scale));
        let compiled = CompiledScene::compile(&scene, Some("o0"), 64);
        let maps: Vec<superegg_geom::Transform> = (0..40)
            .map(|level| {
                let object = scene.object(&format!("o{level}")).unwrap();
                object.parent_from_child(object.child("deeper").unwrap()).unwrap()
            })
            .collect();
        let center = DVec3::from_array(mapped(&maps, DVec3::ZERO).map(|x| x.0));
        let reach = |axis: DVec3| (DVec3::from_array(mapped(&maps, axis).map(|x| x.0)) - center).length();
        let size = reach(DVec3::X).max(reach(DVec3::Y)).max(reach(DVec3::Z));
        let position = center + size * DVec3::new(3.0, 2.0, 4.0);
        let camera = Camera { position, target: center, up: DVec3::Z, fov_deg: 30.0, ..Camera::default() };
        let view = superegg_render::View::new(&camera, 1280, 960);
        let shape = match scene.get("shape") {
            Some(Entity::Primitive(primitive)) => primitive.shape,
            _ => panic!("the shape is a primitive"),
        };
        let mut hits = 0;
        let rays: Vec<TraceRay> = (0..40 * 30)
            .map(|i| {
                view.ray(superegg_geom::glam::DVec2::new(
                    f64::from(i % 40) * 32.0 + 0.5,
                    f64::from(i / 40) * 32.0 + 0.5,
                ))
                .into()
            })
            .collect();
        for (ray, hit) in rays.iter().zip(compiled.intersect_many(&rays)) {
            let single = compiled.intersect_ray(&ray.ray);
            assert_eq!(hit.is_some(), single.is_some());
            for hit in [hit, single].into_iter().flatten() {
                hits += 1;
                assert!((shape.norm().value(hit.unit_point) - 1.0).abs() < 1e-6, "{hit:?}");
                let world = mapped(&maps, hit.unit_point * shape.radii());
                let from_eye = DVec3::from_array(std::array::from_fn(|axis| {
                    world[axis].plus(Double(-position[axis], 0.0)).0
                }));
                let direction = ray.ray.direction.normalize();
                let pixel = view.footprint(1).at(from_eye.dot(direction) / ray.ray.direction.length());
                let beside = (from_eye - from_eye.dot(direction) * direction).length();
                assert!(beside < 0.05 * pixel, "{} of a pixel: {hit:?}", beside / pixel);
                let surface = compiled.interaction(&hit).position - position;
                assert!((surface - from_eye).length() < 0.05 * pixel, "{surface} {from_eye}");
            }
        }
        assert!(hits > 100, "{hits}");
    }
}

#[test]
fn boxes_of_turned_levels_do_not_swell() {
    // A shell of 60 rings of 20 ribs, each turned by 24 degrees: boxes of corners would grow at every level. The groups of
    // the lower 25 levels are folded; each of the 34 above the next has one group.
    let mut text = String::from("prm p\ncoeff .1 .1 .1\nobj shell\n");
    for rib in 0..20 {
        text += &format!("ap p p{rib}\nxs 1 0 0\nrs 0 0 1 {}\n", 18 * rib);
    }
    text += "ao shell deeper\nss .97 .97 .97\nrs 0 0 1 24\n";
    let compiled = CompiledScene::compile(&load(&text), Some("shell"), 60);
    let bounds = compiled.bounds().unwrap();
    assert!(
        bounds.half_extent().x < 1.2 && bounds.half_extent().y < 1.2 && bounds.half_extent().z < 0.11,
        "{bounds:?}"
    );
    assert!(
        compiled.box_inflation().instances == 34 && compiled.box_inflation().mean_ratio > 1.05,
        "{:?}",
        compiled.box_inflation()
    );
}

#[test]
fn what_is_smaller_than_half_a_pixel_stands_in_and_what_is_not_is_opened() {
    let text = "prm p\ncolor 1 0 0\nobj dust\nap p a\nap p b\nxs 1 0 0\nobj all\nao dust near\nxs 0 0 5\nao dust far\nss .001 .001 .001\n";
    let compiled = CompiledScene::compile(&load(text), Some("all"), 9);
    let ray = Ray::new(DVec3::new(0.0005, 0.0, 4.5), DVec3::NEG_Z);
    let exact = compiled.intersect_ray(&Ray::new(DVec3::new(0.0005, 0.0, 2.0), DVec3::NEG_Z)).unwrap();
    let at = |width: f64| {
        let from_two = Ray { origin: DVec3::new(0.0005, 0.0, 2.0), ..ray };
        compiled.intersect(&TraceRay::new(from_two).with_footprint(Footprint { width, spread: 0.0 }))
    };
    assert_eq!(at(1e-5).as_ref(), Some(&exact));
    let proxy = at(0.02).expect("two balls side by side stop every ray through their middle");
    assert!(proxy.path.is_proxy() && (proxy.t - exact.t).abs() < 0.002, "{proxy:?}");
    let surface = compiled.interaction(&proxy);
    assert!((surface.position.z - 0.001).abs() < 1e-3 && surface.material.color == DVec3::X);
    assert_eq!(compiled.path_name(&proxy.path), "all/far");
}

/// Opaque surfaces under point lights are shaded in f32. A black directional light forces f64 and
/// changes nothing else.
#[test]
fn lanes_light_surfaces_as_f64_does() {
    let exponents = [0.0001, 0.01, 0.1, 0.5, 1.0, 1.6, 2.0];
    let mut text = String::new();
    for (i, e) in exponents.into_iter().enumerate() {
        for (j, n) in exponents.into_iter().enumerate() {
            text +=
                &format!("prm p{i}{j}\nexp {e} {n}\ncoeff .4 .{} .45\nsetShininess {}\n", 3 + j, 4 * i * j);
            text +=
                &format!("color .{i} .8 .{j}\nobj o{i}{j}\nap p{i}{j}\nrs 1 {i} {j} {}\n", 20 * i + 7 * j);
        }
    }
    text += "obj all\n";
    for i in 0..exponents.len() {
        for j in 0..exponents.len() {
            text +=
                &format!("ao o{i}{j} c{i}{j}\nxs {} {} 0\n", 1.1 * (i as f64 - 3.0), 1.1 * (j as f64 - 3.0));
        }
    }
    let scene = load(&text);
    let compiled = CompiledScene::compile(&scene, Some("all"), 5);
    let picture = Picture { width: 160, height: 160, ..scene.picture };
    for distance in [6.0, 60.0] {
        let camera = Camera {
            position: distance * DVec3::new(0.3, -0.4, 1.2),
            target: DVec3::ZERO,
            fov_deg: 2.0 * f64::atan2(4.5, 1.3 * distance).to_degrees(),
            ..scene.camera
        };
        let mut settings = RenderSettings::of(&scene).with_picture(picture).with_camera(camera);
        let point = |x, y, z| Light {
            kind: LightKind::Point { position: DVec3::new(x, y, z) },
            falloff: 0.01,
            ..Light::DEFAULT
        };
        settings.environment.lights = vec![point(3.0, 2.0, 7.0), point(-5.0, 1.0, 2.0)];
        let options = RenderOptions::default().with_threads(1);
        let lanes = render(&compiled, &settings, &options).unwrap();
        let sun =
            Light { kind: LightKind::Sun { direction: DVec3::Z }, color: DVec3::ZERO, ..Light::DEFAULT };
        settings.environment.lights.push(sun);
        let exact = render(&compiled, &settings, &options).unwrap();
        assert!(lanes.film != exact.film && lanes.stats.rays.shadow.abs_diff(exact.stats.rays.shadow) < 4);
        let pixels = || lanes.film.pixels().zip(exact.film.pixels());
        assert!(pixels().filter(|(a, _)| a.id != 0).count() > 10_000);
        let (mut apart, mut not_as_deep) = (0, 0);
        for (i, (a, b)) in pixels().enumerate() {
            assert_eq!((a.id, a.albedo), (b.id, b.albedo), "pixel {i}");
            let numbers = |pixel: &Pixel| pixel.color.into_iter().chain(pixel.normal);
            let off = numbers(&a).zip(numbers(&b)).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
            // Edges, silhouettes and shadows' rims are where they are to a 64th of a pixel.
            apart += usize::from(off > 1e-3);
            let is_as_deep = a.depth == b.depth || (a.depth - b.depth).abs() < 1e-5 * b.depth;
            not_as_deep += usize::from(!is_as_deep);
        }
        assert!(apart < 20 && not_as_deep < 3, "{apart} and {not_as_deep} pixels at {distance}");
    }
}

#[test]
fn what_comes_first_by_little_is_first() {
    // Rays that graze a shape near its edges, from outside and inside, and a small sphere just
    // behind or before the hit.
    let cases = [
        (
            ".01 2",
            [-1.6769319084859482, -1.2549262162382815, 1.187499347586753],
            [0.8627542580221493, 0.331865567357543, -0.38147127738154374],
            (2.022101, 4e-6),
        ),
        (
            ".5 2",
            [0.20359586738411006, -0.1929394252201342, 0.7173713169968354],
            [0.6928338224735363, 0.3607618339515265, -0.6243654327400258],
            (1.148, 4e-4),
        ),
        (
            "2 1",
            [-1.5537515137721227, 2.5538913015100233, -0.25198304213235795],
            [0.7036563826087691, -0.7037206703947207, 0.09820851935115678],
            (2.4863, 2e-3),
        ),
        (
            ".5 2",
            [-1.680580529344145, 1.1813115291067102, 2.1863559078038777],
            [0.5563827090766846, -0.5867505705151463, -0.5883553764865582],
            (3.154, 2e-3),
        ),
    ];
    for (exponents, origin, direction, (t, radius)) in cases {
        let (origin, direction) = (DVec3::from_array(origin), DVec3::from_array(direction));
        let DVec3 { x, y, z } = origin + t * direction;
        let scene = load(&format!(
            "prm shape\nexp {exponents}\nprm ball\ncoeff {radius} {radius} {radius}\nobj all\nap shape\nap ball\nxs {x} {y} {z}\n"
        ));
        let scene = CompiledScene::compile(&scene, Some("all"), 1);
        let ray = Ray::new(origin, direction);
        let exact = scene.intersect_ray(&ray).unwrap();
        let many = scene.intersect_many(&[ray.into()]).remove(0).unwrap();
        assert_eq!(many.primitive, exact.primitive, "{exponents}: {many:?} {exact:?}");
        assert!((many.t - exact.t).abs() < 1e-12 * exact.t, "{many:?} {exact:?}");
    }
}
