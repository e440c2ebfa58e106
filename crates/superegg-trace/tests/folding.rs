//! Small groups are folded into their parents; answers, names and ids are those of the scene as it is described.

use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use superegg_geom::glam::DVec3;
use superegg_geom::{Ray, Superquadric};
use superegg_lang::load_text;
use superegg_scene::{MAX_DEPTH, Scene};
use superegg_trace::reference::{self, FlatInstance};
use superegg_trace::{CompiledScene, InstanceNumbers};

fn load(text: &str) -> Scene {
    let (session, diagnostics) = load_text("folding.scn", text);
    assert!(diagnostics.is_empty(), "{diagnostics:?}");
    session.scene().clone()
}

fn compile(text: &str, depth: u32) -> (CompiledScene, Vec<FlatInstance>) {
    let scene = load(text);
    let flat = reference::flatten(&scene, "all", depth, 5_000).expect("the scene has few instances");
    (CompiledScene::compile(&scene, Some("all"), depth), flat)
}

/// Rays from around a place into it.
fn rays(count: u32, center: DVec3, radius: f64) -> impl Iterator<Item = Ray> {
    (0..count).map(move |i| {
        let a = f64::from(i);
        let origin = center + radius * DVec3::new((1.3 * a).sin(), (0.7 * a).cos(), (2.9 * a).sin());
        let target = center + 0.4 * radius * DVec3::new((2.1 * a).cos(), (1.1 * a).sin(), (0.37 * a).cos());
        Ray::new(origin, target - origin)
    })
}

/// Rays hit the instances of the list, up to a relative error of t. Returns the number of hits.
fn check_rays(
    (compiled, flat): &(CompiledScene, Vec<FlatInstance>),
    rays: impl Iterator<Item = Ray>,
    error: f64,
) -> usize {
    let mut hits = 0;
    for ray in rays {
        let (graph, list) = (compiled.intersect_ray(&ray), reference::intersect(flat, &ray));
        assert_eq!(graph.is_some(), list.is_some(), "{ray:?} {graph:?} {list:?}");
        let (Some(hit), Some((index, expected))) = (graph, list) else { continue };
        hits += 1;
        assert!((hit.t - expected.t).abs() <= error * (1.0 + expected.t), "{hit:?} {expected:?}");
        assert_eq!(compiled.path_name(&hit.path), flat[index].path);
        let surface = compiled.interaction(&hit);
        let scale = 1.0 + ray.origin.length();
        assert!((surface.position - ray.point_at(hit.t)).length() <= 4.0 * error * scale, "{surface:?}");
    }
    hits
}

/// A chain of one shape and itself, turned and a little smaller.
const CHAIN: &str = "prm straw\nexp 1 .4\ncoeff .05 .05 .6\nobj all\nap straw\nrs 1 0 0 80\nxs 1 0 0\n\
    ao all\nss .98 .98 .98\nrs 0 0 1 47\nxs 0 0 .02\n";

#[test]
fn chains_answer_as_their_list_at_every_depth() {
    let mut hits = 0;
    for depth in (1..=MAX_DEPTH).filter(|depth| *depth < 20 || depth % 11 == 9) {
        let both = compile(CHAIN, depth);
        assert_eq!(both.0.instance_count().to_string(), depth.to_string());
        hits += check_rays(&both, rays(300, DVec3::Z * 0.4, 2.5), 1e-10);
    }
    assert!(hits > 500, "{hits}");
}

/// Chains whose maps are mirrored, sheared, large, small, or all of these by turns.
#[test]
fn hostile_maps_are_folded_as_far_as_they_can_be_composed() {
    let maps = [
        ("ss -.9 .9 .9\nrs 1 2 3 70\nxs .3 0 .1", 64, 1e-9),
        // A product of unequal scales and rotations is a shear. It is worse with every level.
        ("rs 1 1 0 30\nss 1.3 .8 .9\nrs 0 1 2 50\nxs .2 .1 0", 20, 1e-6),
        ("ss .5 .5 .5\nrs 3 1 2 100\nxs .7 0 0", 40, 1e-9),
        ("xs 1000000 0 0\nss .001 .001 .001\nrs 0 0 1 180\nxs 1000.3 0 0", 20, 1e-5),
    ];
    for (map, depth, error) in maps {
        let text = format!("prm ball\ncoeff .4 .3 .2\nobj all\nap ball\nao all\n{map}\n");
        let both = compile(&text, depth);
        let hits = check_rays(&both, rays(500, DVec3::ZERO, 2.5), error);
        assert!(hits > 15, "{map}: {hits}");
    }
    for far in ["1e150", "1e-150", "1e300"] {
        let text = format!(
            "prm ball\nobj in\nap ball\nap ball b\nxs 3 0 0\nobj mid\nao in\nss {far} {far} {far}\n\
             ao in b\nxs 0 3 0\nobj all\nao mid\nao mid b\nxs 0 0 3\nss {far} {far} {far}\n"
        );
        let (session, _) = load_text("far.scn", &text);
        let scene = session.scene();
        let compiled = CompiledScene::compile(scene, Some("all"), 9);
        let hit = compiled.intersect_ray(&Ray::new(DVec3::new(0.1, 3.0, 9.0), DVec3::NEG_Z));
        assert!(hit.is_some() || far.starts_with("1e3"), "{far}");
    }
}

#[test]
fn memory_is_linear_in_the_depth() {
    let tree = "prm leaf\ncoeff .1 .1 .5\nobj all\nap leaf\nao all a\nss .8 .8 .8\nrs 0 1 0 40\nxs 0 0 1\n\
        ao all b\nss .7 .7 .7\nrs 0 1 0 -40\nxs 0 0 1\nao all c\nss .7 .7 .7\nrs 1 0 0 40\nxs 0 0 1\n";
    for text in [CHAIN, tree] {
        let scene = load(text);
        for depth in [1, 8, 32, MAX_DEPTH] {
            let bytes = CompiledScene::compile(&scene, Some("all"), depth).bytes();
            assert!(bytes < 400_000 + 20_000 * depth as usize, "{bytes} bytes at depth {depth}");
        }
    }
    // No object is opened into its parent without limit.
    let mut wide = String::from("prm ball\ncoeff .1 .1 .1\nobj twelve\n");
    for i in 0..12 {
        wide += &format!("ap ball b{i}\nxs {i} 0 0\n");
    }
    wide += "obj all\n";
    for i in 0..2_000 {
        wide += &format!("ao twelve t{i}\nxs 0 {i} 0\n");
    }
    let compiled = CompiledScene::compile(&load(&wide), Some("all"), 9);
    assert!(compiled.bytes() < 1_500_000, "{}", compiled.bytes());
    // Nor do many objects become wide.
    let mut many = String::from("prm ball\ncoeff 3 3 3\nobj row\n");
    for i in 0..400 {
        many += &format!("ap ball b{i}\nxs {i} 0 0\n");
    }
    for i in 0..200 {
        many += &format!("obj wide{i}\n");
        for j in 0..8 {
            many += &format!("ao row r{j}\nxs 0 {j} {i}\n");
        }
    }
    many += "obj all\n";
    for i in 0..200 {
        many += &format!("ao wide{i} w{i}\n");
    }
    let compiled = CompiledScene::compile(&load(&many), Some("all"), 9);
    assert!(compiled.bytes() < 30_000_000, "{}", compiled.bytes());
}

/// Unit balls at integer positions in objects of objects: many at the same position. All arithmetic is exact.
fn coincident_text() -> impl Strategy<Value = String> {
    let name = prop::sample::select(vec!["p0", "p1", "o0", "o1", "o2"]);
    let child = (name, prop::array::uniform3(-1..2i32), prop::array::uniform3(prop::bool::ANY));
    let object = prop::collection::vec(child, 1..4);
    prop::collection::vec(object, 4).prop_map(|objects| {
        let mut text = String::from("prm p0\nprm p1\nobj o0\nobj o1\nobj o2\nobj all\n");
        for (children, object) in objects.iter().zip(["o0", "o1", "o2", "all"]) {
            text += &format!("obj {object}\n");
            for (i, (name, [x, y, z], mirrored)) in children.iter().enumerate() {
                let add = if name.starts_with('p') { "ap" } else { "ao" };
                let [a, b, c] = mirrored.map(|is_mirrored| if is_mirrored { -1 } else { 1 });
                text += &format!("{add} {name} c{i}\nss {a} {b} {c}\nxs {x} {y} {z}\n");
            }
        }
        text
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 150, rng_seed: RngSeed::Fixed(20), failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn of_coincident_surfaces_the_first_in_the_order_of_children_is_hit(
        text in coincident_text(), depth in 1..6u32,
        rays in prop::collection::vec((prop::array::uniform2(-2..3i32), 0..6usize), 20),
    ) {
        let scene = load(&text);
        let Some(flat) = reference::flatten(&scene, "all", depth, 3_000) else { return Ok(()) };
        let compiled = CompiledScene::compile(&scene, Some("all"), depth);
        prop_assert_eq!(compiled.instance_count().to_string(), flat.len().to_string());
        for ([a, b], side) in rays {
            let axis = DVec3::AXES[side % 3];
            let mut origin = DVec3::new(f64::from(a), f64::from(b), f64::from(a - b)) * (DVec3::ONE - axis);
            let direction = if side < 3 { axis } else { -axis };
            origin -= direction * 16.0;
            let ray = Ray::new(origin, direction);
            let (graph, list) = (compiled.intersect_ray(&ray), reference::intersect(&flat, &ray));
            let graph = graph.map(|hit| (hit.t, compiled.path_name(&hit.path)));
            prop_assert_eq!(graph, list.map(|(index, hit)| (hit.t, flat[index].path.clone())));
            let point = DVec3::new(f64::from(a), f64::from(b), 0.0);
            let least = compiled.query_point(point).least.map(|(value, path)| (value, compiled.path_name(&path)));
            let expected = reference::least_value(&flat, point).map(|(index, value)| (value, flat[index].path.clone()));
            prop_assert_eq!(least, expected);
        }
        let placed = compiled.placed_primitives(5_000).unwrap();
        let mut names: Vec<String> = placed.iter().map(|placed| compiled.path_name(&placed.path)).collect();
        let mut listed = flat.iter().map(|flat| &flat.path);
        // Copies in one object at one position are left out of the graph, not of the list.
        prop_assert!(names.iter().all(|name| listed.any(|listed| listed == name)), "the order of {names:?}");
        names.dedup();
        prop_assert_eq!(names.len(), placed.len());
    }

    #[test]
    fn a_changed_scene_is_recompiled_as_it_is_compiled(
        text in coincident_text(), depth in 1..6u32, radius in 1..4u32,
        rays in prop::collection::vec(prop::array::uniform3(-3.0..3.0f64), 20),
    ) {
        let mut scene = load(&text);
        let before = CompiledScene::compile(&scene, Some("all"), depth);
        let radii = DVec3::new(f64::from(radius) * 0.4, 0.5, 0.6);
        let exponents = Superquadric::unit_sphere().exponents();
        scene.primitive_mut("p1").unwrap().shape = Superquadric::new(radii, exponents).unwrap();
        let (again, anew) = (before.recompile(&scene, Some("all"), depth), CompiledScene::compile(&scene, Some("all"), depth));
        prop_assert_eq!(again.instance_count(), anew.instance_count());
        for target in rays {
            let origin = DVec3::new(9.0, -7.0, 5.0);
            let ray = Ray::new(origin, DVec3::from(target) - origin);
            let answer = |scene: &CompiledScene| {
                scene.intersect_ray(&ray).map(|hit| (hit.t, scene.path_name(&hit.path), scene.instance_id(&hit.path)))
            };
            prop_assert_eq!(answer(&again), answer(&anew));
        }
    }
}

#[test]
fn numbers_follow_the_order_of_children() {
    let nested = "prm ball\ncoeff .1 .1 .1\nprm box\ncoeff .2 .1 .1\nobj in\nap ball\nap box\nxs 1 0 0\n\
        obj mid\nao in\nap ball\nxs 0 1 0\nao in second\nxs 0 2 0\nobj all\nap ball\nxs 0 0 -1\nao mid\nao mid m2\nxs 0 0 3\n";
    let wide: String = (0..300).map(|i| format!("ao in i{i}\nxs 0 {i} 0\n")).collect();
    let wide = format!("prm ball\ncoeff .1 .1 .1\nobj in\nap ball\nap ball b\nxs 3 0 0\nobj all\n{wide}");
    for (text, depth, objects) in [(CHAIN, 30, 2), (nested, 9, 3), (&wide, 9, 300)] {
        let (compiled, flat) = compile(text, depth);
        let numbers = InstanceNumbers::of(&compiled);
        let placed = compiled.placed_primitives(10_000).unwrap();
        let found: Vec<u32> = placed.iter().map(|placed| numbers.instance(&placed.path)).collect();
        assert!(found.iter().copied().eq(2..2 + flat.len() as u32), "{found:?}");
        let mut found: Vec<(u32, String)> = placed
            .iter()
            .map(|placed| (numbers.object(&placed.path), numbers.object_name(&placed.path)))
            .collect();
        found.dedup();
        assert!(found.iter().map(|(number, _)| *number).eq(2..2 + objects), "{found:?}");
        for (placed, flat) in placed.iter().zip(&flat) {
            assert!(flat.path.starts_with(&numbers.object_name(&placed.path)), "{}", flat.path);
        }
    }
}

#[test]
fn objects_of_one_child_are_passed_by_and_too_many_instances_have_hashes() {
    let (compiled, _) = compile("prm ball\nobj pair\nap ball\nap ball b\nxs 3 0 0\nobj all\nao pair\n", 9);
    let numbers = InstanceNumbers::of(&compiled);
    let hit = compiled.intersect_ray(&Ray::new(DVec3::new(3.0, 0.0, 9.0), DVec3::NEG_Z)).unwrap();
    assert_eq!((numbers.object(&hit.path), numbers.object_name(&hit.path)), (3, "all/pair/b".to_owned()));
    let scene = load(
        "prm leaf\ncoeff .1 .1 .5\nobj all\nap leaf\nao all a\nss .8 .8 .8\nxs 0 0 1\nao all b\nss .7 .7 .7\nxs 1 0 0\n",
    );
    let compiled = CompiledScene::compile(&scene, Some("all"), 40);
    assert!(compiled.instance_count().to_u64().is_none_or(|count| count > 1 << 24));
    let numbers = InstanceNumbers::of(&compiled);
    let mut found: Vec<u32> = rays(200, DVec3::Z, 3.0)
        .filter_map(|ray| Some(numbers.instance(&compiled.intersect_ray(&ray)?.path)))
        .collect();
    assert!(found.iter().all(|number| (2..=InstanceNumbers::GREATEST).contains(number)));
    found.sort_unstable();
    found.dedup();
    assert!(found.len() > 10, "{found:?}");
}
