//! CONTRIBUTING.md has the reason for each dependency.

use std::fs;
use std::path::Path;

#[test]
fn each_dependency_has_its_reason() {
    let project = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let manifest = fs::read_to_string(project.join("Cargo.toml")).unwrap();
    let (_, rest) = manifest.split_once("[workspace.dependencies]\n").unwrap();
    let section = rest.split("\n[").next().unwrap();
    let names: Vec<&str> = section
        .lines()
        .filter_map(|line| line.split_once(" = "))
        .map(|(name, _)| name)
        .filter(|name| !name.starts_with("superegg") && !name.starts_with('#'))
        .collect();
    assert!(names.len() > 40);
    let page = fs::read_to_string(project.join("CONTRIBUTING.md")).unwrap();
    let (_, table) = page.split_once("## Dependencies").unwrap();
    let table = table.split("\n## ").next().unwrap();
    let listed: Vec<&str> = table
        .lines()
        .filter_map(|line| line.strip_prefix("| "))
        .filter_map(|line| line.split('|').next())
        .flat_map(|cell| cell.trim().split(", "))
        .collect();
    for name in &names {
        assert!(listed.contains(name), "CONTRIBUTING.md has no reason for {name}");
    }
    for name in listed.iter().filter(|name| **name != "crate" && !name.starts_with('-')) {
        assert!(names.contains(name), "CONTRIBUTING.md lists {name}, which nothing uses");
    }
}
