//! Tables of instances: rays see the rows as they would see children.

use superegg_geom::glam::{DQuat, DVec3};
use superegg_geom::{Exponents, Ray};
use superegg_lang::{load_text, write_scene};
use superegg_scene::{InstanceTable, Material, Scene, TableBuilder};
use superegg_trace::CompiledScene;
use superegg_trace::reference::{flatten, intersect};

/// Pseudo-random numbers in [0, 1).
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    fn vector(&mut self) -> DVec3 {
        DVec3::new(self.next(), self.next(), self.next()) * 2.0 - 1.0
    }

    fn rotation(&mut self) -> DQuat {
        let (a, b) = (self.vector(), self.next() - 0.5);
        DQuat::from_xyzw(a.x, a.y, a.z, b).normalize()
    }
}

fn table(rows: usize, has_ids: bool) -> InstanceTable {
    let mut numbers = Numbers(rows as u64 + 7);
    let mut builder = TableBuilder::default();
    let white = builder.material(Material::default());
    let red = builder.material(Material { color: DVec3::X, ..Material::default() });
    for row in 0..rows {
        let radii = (numbers.vector().abs() + 0.05) * 0.3;
        let exponents = Exponents::new(2.5 * numbers.next() + 0.05, 2.0 * numbers.next() + 0.05).unwrap();
        let material = if row % 3 == 0 { red } else { white };
        // Every fifth row has the shape of the row before.
        let shape = match row.checked_sub(1).filter(|_| row % 5 == 4) {
            Some(_) => builder.shape(DVec3::splat(0.2), Exponents::ROUND, white).unwrap(),
            None => builder.shape(radii, exponents, material).unwrap(),
        };
        builder.push(shape, numbers.vector(), numbers.rotation(), has_ids.then_some(10_000 - row as i64));
    }
    builder.finish()
}

fn scene_with(table: InstanceTable) -> Scene {
    let mut scene = Scene::default();
    scene.add_table("grains", table).unwrap();
    scene.ensure_object("pair").unwrap();
    scene.add_child("pair", "left", "grains").unwrap();
    scene.add_child("pair", "right", "grains").unwrap();
    let step = superegg_geom::TransformStep::Translate(DVec3::new(2.5, 0.0, 0.0));
    scene.transform_child("pair", step).unwrap();
    scene
}

#[test]
fn rays_find_rows_as_the_list_of_all_instances_does() {
    for (rows, has_ids) in [(0, false), (1, true), (7, false), (300, true), (5_000, true)] {
        let scene = scene_with(table(rows, has_ids));
        for (root, copies) in [("grains", 1), ("pair", 2)] {
            let compiled = CompiledScene::compile(&scene, Some(root), 5);
            assert_eq!(compiled.instance_count().to_u64(), Some((copies * rows) as u64));
            let flat = flatten(&scene, root, 5, 1 << 20).unwrap();
            let mut numbers = Numbers(3);
            let mut hits = 0;
            for _ in 0..200 {
                let (from, to) = (numbers.vector() * 5.0, numbers.vector() * 1.5);
                let ray = Ray::new(from, to - from);
                let (found, expected) = (compiled.intersect_ray(&ray), intersect(&flat, &ray));
                assert_eq!(found.is_some(), expected.is_some());
                let (Some(found), Some((index, expected))) = (found, expected) else { continue };
                hits += 1;
                assert!((found.t - expected.t).abs() < 1e-9);
                assert_eq!(compiled.path_name(&found.path), flat[index].path);
                assert_eq!(compiled.primitive_name(found.primitive), Some("grains"));
            }
            assert!(hits > 0 || rows < 300);
        }
    }
}

#[test]
fn a_written_table_loads_as_an_object_that_rays_see_alike() {
    let scene = scene_with(table(40, true));
    let (session, diagnostics) = load_text("written.scn", &write_scene(&scene, Some("pair")));
    assert!(diagnostics.is_empty(), "{diagnostics:?}");
    let [before, after] = [&scene, session.scene()].map(|scene| flatten(scene, "pair", 5, 1000).unwrap());
    assert_eq!(before.len(), after.len());
    for (a, b) in before.iter().zip(&after) {
        assert_eq!((&a.path, a.shape), (&b.path, b.shape));
        let (a, b) = (a.world_from_local.forward(), b.world_from_local.forward());
        assert!(a.abs_diff_eq(*b, 1e-14), "{a:?} {b:?}");
    }
}

#[test]
fn a_changed_table_is_patched_and_answers_like_a_new_one() {
    let (before, after) = (scene_with(table(400, true)), scene_with(table(401, true)));
    let compiled = CompiledScene::compile(&before, Some("grains"), 3);
    assert_eq!(compiled.recompile(&before, Some("grains"), 3).reused_group_count(), 1);
    let (changed, fresh) =
        (compiled.recompile(&after, Some("grains"), 3), CompiledScene::compile(&after, Some("grains"), 3));
    assert_eq!(changed.reused_group_count(), 0);
    let ray = Ray::new(DVec3::new(0.0, 0.0, 5.0), DVec3::NEG_Z);
    let t = |scene: &CompiledScene| scene.intersect_ray(&ray).map(|hit| hit.t);
    assert_eq!(t(&changed), t(&fresh));
}
