//! The children that refer to a name, found by an index after many deletions.

use superegg_geom::TransformStep;
use superegg_geom::glam::DVec3;
use superegg_scene::Scene;

/// A random number below `most` (xorshift, Marsaglia 2003).
fn below(state: &mut u64, most: usize) -> usize {
    *state ^= *state << 13;
    *state ^= *state >> 7;
    *state ^= *state << 17;
    (*state % most as u64) as usize
}

/// The uses of a name by a search through all children.
fn searched(scene: &Scene, name: &str) -> Vec<(String, String)> {
    let uses_in = |(object, content): (&str, &superegg_scene::Object)| -> Vec<(String, String)> {
        content.aliases_of(name).map(|alias| (object.to_owned(), alias.to_owned())).collect()
    };
    scene.objects().flat_map(uses_in).collect()
}

#[test]
fn the_index_finds_what_a_search_finds() {
    let mut state = 4711;
    let mut scene = Scene::default();
    let mut earlier = scene.clone();
    for round in 0..20_000 {
        let [one, two, three] = [(); 3].map(|()| format!("n{}", below(&mut state, 12)));
        // Most of these are refused, and change nothing.
        let _ = match below(&mut state, 9) {
            0 => scene.ensure_primitive(&one),
            1 | 2 => scene.ensure_object(&one),
            3 | 4 => scene.add_child(&one, &three, &two),
            5 => scene.remove_child(&one, &two),
            6 => scene.rename(&one, &two),
            7 => scene.copy(&one, &two),
            _ => {
                let expected = searched(&scene, &one);
                let deleted = scene.delete(&one);
                assert!(deleted.is_err() || deleted == Ok(expected), "round {round}");
                Ok(())
            }
        };
        for name in [&one, &two] {
            assert_eq!(scene.uses(name), searched(&scene, name), "round {round}, {name}");
        }
        // The cursor is on a child as long as there is one.
        for (name, object) in scene.objects() {
            assert_eq!(object.cursor().is_some(), object.children().len() > 0, "round {round}, {name}");
        }
        if round % 1000 == 0 {
            std::mem::swap(&mut scene, &mut earlier);
        }
        let _ = scene.transform_child(&one, TransformStep::Translate(DVec3::ONE));
    }
}
