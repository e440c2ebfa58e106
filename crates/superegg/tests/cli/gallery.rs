//! The project's own scenes: each is without fault, says what it shows, and looks as it did.

use std::path::PathBuf;

use crate::support::{Place, project};

fn scenes() -> Vec<(String, PathBuf)> {
    let mut scenes: Vec<(String, PathBuf)> = std::fs::read_dir(project("scenes"))
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|extension| extension == "scn"))
        .map(|path| (path.file_stem().unwrap().to_str().unwrap().to_owned(), path))
        .collect();
    scenes.sort();
    scenes
}

#[test]
fn each_is_without_fault_and_says_what_it_shows() {
    let scenes = scenes();
    assert!(scenes.len() >= 10);
    for (name, path) in scenes {
        Place::new().run(&format!("check --strict {}", path.display())).fine();
        assert!(std::fs::read_to_string(&path).unwrap().starts_with("# "), "{name} has no comment");
    }
}

#[test]
fn each_looks_as_it_did() {
    let failures: Vec<String> = scenes()
        .into_iter()
        .filter_map(|(name, path)| {
            let place = Place::new();
            place
                .run(&format!("render {} --size 128x96 --samples 4 --quiet -o actual.png", path.display()))
                .fine();
            superegg_golden::check(&project("tests/golden"), &name, &place.path("actual.png")).err()
        })
        .collect();
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}
