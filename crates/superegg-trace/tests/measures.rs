//! Samples and measures of scenes against closed forms.

use std::f64::consts::PI;

use superegg_geom::glam::DVec3;
use superegg_lang::load_text;
use superegg_trace::{CompiledScene, PointLimits, SceneMeasures, SceneSurfaces};

fn compiled(text: &str, root: &str) -> CompiledScene {
    let (session, diagnostics) = load_text("measures.scn", text);
    assert!(diagnostics.is_empty(), "{diagnostics:?}");
    CompiledScene::compile(session.scene(), Some(root), 8)
}

/// Two unit balls whose centres are 1 apart, and a far small one.
const BALLS: &str = "prm ball\nobj o\nap ball a\nap ball b\nxs 1 0 0\nap ball c\nss .5 .5 .5\nxs 0 9 0\n";

#[test]
fn points_are_even_over_all_instances() {
    let scene = compiled(BALLS, "o");
    let surfaces = SceneSurfaces::of(&scene, 10).unwrap();
    let expected = 4.0 * PI * (1.0 + 1.0 + 0.25);
    assert!((surfaces.total_area() / expected - 1.0).abs() < 1e-12);
    let points = surfaces.sample(9_000, 3);
    assert_eq!(points, surfaces.sample(9_000, 3));
    assert_ne!(points, surfaces.sample(9_000, 4));
    assert_eq!(points.len(), 9_000);
    for (instance, share) in [(0, 4_000), (1, 4_000), (2, 1_000)] {
        let count = points.iter().filter(|point| point.instance == instance).count();
        assert!(count.abs_diff(share) <= 1, "{count}");
    }
    let names: Vec<String> =
        surfaces.instances().iter().map(|placed| scene.path_name(&placed.path)).collect();
    assert_eq!(names, ["o/a", "o/b", "o/c"]);
    for point in &points {
        let center = surfaces.instances()[point.instance].world_from_unit.translation;
        let radius = if point.instance == 2 { 0.5 } else { 1.0 };
        let offset = point.point - center;
        assert!((offset.length() - radius).abs() < 1e-12);
        assert!((offset / radius - point.normal).length() < 1e-12);
        // A cap of height 1/2 is in the other ball.
        let other = if point.instance == 0 { 1.0 } else { 0.0 };
        let is_covered = point.instance < 2 && (point.point - other * DVec3::X).length() < 1.0 - 1e-6;
        assert_eq!(surfaces.is_covered(point, &PointLimits::default()), is_covered);
    }
}

#[test]
fn any_number_of_points_is_shared_out() {
    let scene = compiled(BALLS, "o");
    let surfaces = SceneSurfaces::of(&scene, 10).unwrap();
    for count in [0, 1, 2, 3, 17] {
        for seed in 0..20 {
            assert_eq!(surfaces.sample(count, seed).len(), count);
        }
    }
    let empty = compiled("obj o\n", "o");
    assert!(SceneSurfaces::of(&empty, 10).unwrap().sample(10, 1).is_empty());
}

#[test]
fn too_many_instances_are_refused() {
    let children: String = (0..20).map(|i| format!("ao o c{i}\nss .1 .1 .1\nxs {i} 0 0\n")).collect();
    let scene = compiled(&format!("prm p\nobj o\nap p\n{children}"), "o");
    assert!(SceneSurfaces::of(&scene, 1000).is_none() && SceneMeasures::of(&scene, 1000).is_none());
}

#[test]
fn the_measures_of_each_instance_and_of_the_sum_are_exact() {
    let text =
        "prm e\nexp 1 1\ncoeff 1 2 3\nobj o\nap e\nss 1 1 .5\nrs 0 0 1 90\nxs 5 6 7\nap e far\nxs -100 0 0\n";
    let scene = compiled(text, "o");
    let measures = SceneMeasures::of(&scene, 10).unwrap();
    let mass = measures.mass_of(&measures.instances()[0]);
    let volume = 4.0 / 3.0 * PI * 3.0;
    assert!((mass.volume / volume - 1.0).abs() < 1e-13);
    assert!((mass.center - DVec3::new(5.0, 6.0, 7.0)).length() < 1e-12);
    // An ellipsoid of semi-axes 2, 1, 1.5 along x, y, z.
    let [a, b, c] = [4.0, 1.0, 2.25];
    let expected = DVec3::new(b + c, a + c, a + b) * volume / 5.0;
    let inertia = mass.inertia;
    assert!((DVec3::new(inertia.x_axis.x, inertia.y_axis.y, inertia.z_axis.z) - expected).length() < 1e-11);
    assert!(inertia.x_axis.y.abs() + inertia.x_axis.z.abs() + inertia.y_axis.z.abs() < 1e-11);
    let bounds = measures.bounds_of(&measures.instances()[0]);
    assert!((bounds.min - DVec3::new(3.0, 5.0, 5.5)).length() < 1e-12, "{bounds:?}");
    // The parallel axis theorem.
    let other = measures.mass_of(&measures.instances()[1]);
    let total = measures.total_mass();
    assert!((total.volume / (mass.volume + other.volume) - 1.0).abs() < 1e-13);
    let center = (mass.volume * mass.center + other.volume * other.center) / total.volume;
    assert!((total.center - center).length() < 1e-11);
    let about_x = [mass, other].into_iter().map(|part| {
        let offset = part.center - center;
        part.inertia.x_axis.x + part.volume * (offset.y * offset.y + offset.z * offset.z)
    });
    assert!((total.inertia.x_axis.x / about_x.sum::<f64>() - 1.0).abs() < 1e-12);
}

#[test]
fn principal_moments_do_not_depend_on_the_axes() {
    let scene = compiled("prm e\nexp .5 1.5\ncoeff 1 2 3\nobj o\nap e\nrs 1 2 3 50\nxs 1 1 1\n", "o");
    let measures = SceneMeasures::of(&scene, 10).unwrap();
    let moments = measures.mass_of(&measures.instances()[0]).principal_moments();
    let straight = compiled("prm e\nexp .5 1.5\ncoeff 1 2 3\n", "e");
    let straight = SceneMeasures::of(&straight, 10).unwrap();
    let inertia = straight.mass_of(&straight.instances()[0]).inertia;
    let mut expected = [inertia.x_axis.x, inertia.y_axis.y, inertia.z_axis.z];
    expected.sort_by(f64::total_cmp);
    for (moment, expected) in moments.iter().zip(expected) {
        assert!((moment / expected - 1.0).abs() < 1e-12, "{moments:?} {expected}");
    }
}

#[test]
fn the_union_is_estimated_within_its_errors() {
    let scene = compiled(BALLS, "o");
    let measures = SceneMeasures::of(&scene, 10).unwrap();
    let union = measures.union(40_000, 7);
    assert_eq!(union, measures.union(40_000, 7));
    // The lens of two unit balls 1 apart.
    let lens = PI * 5.0 / 12.0;
    let small = 4.0 / 3.0 * PI / 8.0;
    let volume = 8.0 / 3.0 * PI - lens + small;
    assert!((union.mass.volume - volume).abs() < 5.0 * union.volume_error, "{union:?} {volume}");
    assert!(union.volume_error < 0.01 * volume && union.volume_error > 0.0);
    let pair = volume - small;
    let center = DVec3::new(0.5 * pair, 9.0 * small, 0.0) / volume;
    assert!(((union.mass.center - center).abs() - 5.0 * union.center_error).max_element() < 0.0, "{union:?}");
    // Each ball loses a cap of height 1/2.
    let area = 9.0 * PI - 2.0 * PI;
    assert!((union.area.value - area).abs() < 5.0 * union.area.error, "{union:?} {area}");

    let apart = compiled("prm ball\nobj o\nap ball\nap ball b\nxs 5 0 0\n", "o");
    let apart = SceneMeasures::of(&apart, 10).unwrap().union(1000, 1);
    assert!((apart.mass.volume / (8.0 / 3.0 * PI) - 1.0).abs() < 1e-12);
    assert!(apart.volume_error < 1e-7, "{apart:?}");
}
