//! The project's own scenes: each is without fault, says what it shows, looks as it did, and is on
//! the gallery's page.

use std::path::PathBuf;

use crate::support::{Sandbox, project};

/// Names and files of the scenes of a folder.
fn scenes(folder: &str) -> Vec<(String, PathBuf)> {
    let mut scenes: Vec<(String, PathBuf)> = std::fs::read_dir(project(folder))
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|extension| extension == "scn"))
        .map(|path| (path.file_stem().unwrap().to_str().unwrap().to_owned(), path))
        .collect();
    scenes.sort();
    scenes
}

/// Renders the scenes of a folder with these flags and compares them with the pictures of another
/// one.
fn compare(folder: &str, flags: &str, golden: &str) {
    let failures: Vec<String> = scenes(folder)
        .into_iter()
        .filter_map(|(name, path)| {
            let sandbox = Sandbox::new();
            sandbox.run(&format!("render {} {flags} --quiet -o actual.png", path.display())).fine();
            superegg_golden::check(&project(golden), &name, &sandbox.path("actual.png")).err()
        })
        .collect();
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}

#[test]
fn each_is_without_fault_and_has_a_description() {
    let (pictures, features) = (scenes("scenes"), scenes("scenes/features"));
    assert!(pictures.len() >= 10 && features.len() >= 10);
    for (name, path) in pictures.into_iter().chain(features) {
        Sandbox::new().run(&format!("check --strict {}", path.display())).fine();
        assert!(std::fs::read_to_string(&path).unwrap().starts_with("# "), "{name} has no comment");
    }
}

#[test]
fn each_looks_as_it_did() {
    compare("scenes", "--size 128x96 --samples 4", "tests/golden");
}

/// With the samples that the scene sets.
#[test]
fn each_feature_looks_as_it_did() {
    compare("scenes/features", "--size 96x72", "tests/golden/features");
}

#[test]
fn every_golden_picture_has_its_scene() {
    for (scenes_folder, golden) in [("scenes", "tests/golden"), ("scenes/features", "tests/golden/features")]
    {
        let names: Vec<String> = scenes(scenes_folder).into_iter().map(|(name, _)| name).collect();
        let pictures = std::fs::read_dir(project(golden)).unwrap().map(|entry| entry.unwrap().path());
        for picture in pictures.filter(|path| path.is_file()) {
            let name = picture.file_stem().unwrap().to_str().unwrap().to_owned();
            assert!(names.contains(&name), "{} is of no scene", picture.display());
        }
    }
}

/// The texts between fences of a section of the page.
fn quoted(section: &str) -> Vec<&str> {
    section.split("```\n").skip(1).step_by(2).collect()
}

#[test]
fn the_page_has_every_scene_as_its_file_has_it() {
    let page = std::fs::read_to_string(project("docs/gallery.md")).unwrap();
    for (name, path) in scenes("scenes") {
        let text = std::fs::read_to_string(&path).unwrap();
        let heading = format!("\n## {name}\n");
        let section = page.split(&heading).nth(1);
        let section = section.unwrap_or_else(|| panic!("{name} is not on the page: tools/gallery.sh {name}"));
        let section = section.split("\n## ").next().unwrap();
        assert!(section.contains(&format!("(pictures/gallery/{name}.png)")), "{name} without its picture");
        assert!(project(&format!("docs/pictures/gallery/{name}.png")).is_file(), "{name}.png is missing");
        let parts = quoted(section);
        assert!(!parts.is_empty(), "{name} without its text");
        for part in parts {
            assert!(
                text.contains(part),
                "the text of {name} is not that of its file: tools/gallery.sh --page"
            );
        }
    }
    for (name, _) in scenes("scenes/features") {
        assert!(page.contains(&format!("(../scenes/features/{name}.scn)")), "{name} is not on the page");
    }
}

/// A picture that no scene makes would stay for ever.
#[test]
fn the_page_shows_no_picture_without_a_scene() {
    let names: Vec<String> = scenes("scenes").into_iter().map(|(name, _)| name).collect();
    for entry in std::fs::read_dir(project("docs/pictures/gallery")).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_some_and(|extension| extension == "png") {
            let name = path.file_stem().unwrap().to_str().unwrap().to_owned();
            assert!(names.contains(&name), "{} is of no scene", path.display());
        }
    }
}

#[test]
fn the_benchmark_robot_is_the_scene_of_the_crane_arm() {
    let sandbox = Sandbox::new();
    sandbox.run("bench robot --save .");
    let scene = std::fs::read_to_string(project("scenes").join("crane_arm.scn")).unwrap();
    assert_eq!(sandbox.read("robot.scn"), scene);
}
