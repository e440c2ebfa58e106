//! The book: every block of code on its pages runs and prints what is shown, every picture is the one that its commands make, and every
//! link leads somewhere. `SUPEREGG_BLESS=1` writes outputs and pictures anew.
#![cfg(unix)]
// A test that is skipped says so.
#![allow(clippy::print_stderr)]

mod page;
mod run;

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::atomic::{AtomicUsize, Ordering};

use crate::page::Page;
use crate::run::{Ran, missing_tool, run_page};

/// The folder of pictures that the commands of their pages make.
const MADE: &str = "pictures/book";
/// The folder of the language page's pictures, each beside its scene.
const LANGUAGE: &str = "pictures/language";
/// A picture of the book is no larger, in bytes.
const LARGEST: u64 = 60_000;
/// Pages that are made from scenes and notebooks, whose tests run them.
const TESTED_ELSEWHERE: &[&str] = &["gallery.md", "python/"];

/// A file or folder of the project.
fn project(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(name)
}

/// The pages that the summary lists, relative to docs.
fn summary() -> Vec<String> {
    Page::read(&project("docs/SUMMARY.md")).links().into_iter().map(|(_, target)| target).collect()
}

fn file_names(folder: &Path, extension: &str) -> BTreeSet<String> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().map(|entry| entry.unwrap().path());
    entries
        .filter(|path| path.extension().is_some_and(|is| is == extension))
        .map(|path| path.file_name().unwrap().to_str().unwrap().to_owned())
        .collect()
}

/// Compares the pictures that a page shows with those that its commands made.
fn check_pictures(page: &Page, ran: &Ran) -> Vec<String> {
    let mut failures = Vec::new();
    for (line, target) in page.links() {
        let Some((_, name)) = target.split_once(&format!("{MADE}/")) else { continue };
        let made = ran.file(name);
        if !made.is_file() {
            failures.push(format!("{}: no command of the page makes {name}", page.at(line)));
            continue;
        }
        let stem = name.trim_end_matches(".png");
        if let Err(why) = superegg_golden::check(&project("docs").join(MADE), stem, &made) {
            failures.push(format!("{}: {why}", page.at(line)));
        }
    }
    failures
}

/// Runs a page; writes it anew where outputs changed and `SUPEREGG_BLESS` is set.
fn check_page(path: &Path) -> Vec<String> {
    let page = Page::read(path);
    if let Some(tool) = missing_tool(&page) {
        eprintln!("{}: skipped: {tool} is not on this machine", path.display());
        return Vec::new();
    }
    let mut failures: Vec<String> = page
        .indented_code()
        .into_iter()
        .map(|line| format!("{}: put code between fences, so that it is run", page.at(line)))
        .collect();
    let mut ran = run_page(&page);
    failures.append(&mut ran.failures);
    failures.extend(check_pictures(&page, &ran));
    if !ran.changes.is_empty() {
        let mut lines = page.lines.clone();
        for (range, new) in ran.changes.into_iter().rev() {
            lines.splice(range, new);
        }
        std::fs::write(path, lines.join("\n") + "\n").unwrap();
    }
    failures
}

#[test]
fn every_block_runs_and_makes_the_pictures_of_its_page() {
    let pages: Vec<PathBuf> = summary()
        .iter()
        .filter(|name| !TESTED_ELSEWHERE.iter().any(|other| name.starts_with(other)))
        .map(|name| project("docs").join(name))
        .chain([project("README.md")])
        .collect();
    assert!(pages.len() > 10, "the summary lists too few pages");
    let next = AtomicUsize::new(0);
    let failures: Vec<String> = std::thread::scope(|scope| {
        let (pages, next) = (&pages, &next);
        let workers = std::thread::available_parallelism().map_or(1, usize::from);
        let work = move || {
            let mut failures = Vec::new();
            while let Some(path) = pages.get(next.fetch_add(1, Ordering::Relaxed)) {
                failures.extend(check_page(path));
            }
            failures
        };
        let workers: Vec<_> = (0..workers).map(|_| scope.spawn(work)).collect();
        workers.into_iter().flat_map(|worker| worker.join().unwrap()).collect()
    });
    assert!(failures.is_empty(), "{}", failures.join("\n\n"));
}

#[test]
fn every_picture_is_shown_and_small() {
    let docs = project("docs");
    let targets: BTreeSet<String> = summary()
        .iter()
        .map(|name| Page::read(&docs.join(name)))
        .chain([Page::read(&project("README.md"))])
        .flat_map(|page| page.links())
        .filter_map(|(_, target)| target.rsplit_once('/').map(|(_, name)| name.to_owned()))
        .collect();
    for folder in [MADE, LANGUAGE] {
        let folder = docs.join(folder);
        let names = file_names(&folder, "png");
        assert!(!names.is_empty());
        for name in names {
            assert!(targets.contains(&name), "no page shows {name}");
            let size = std::fs::metadata(folder.join(&name)).unwrap().len();
            assert!(size <= LARGEST, "{name} has {size} bytes: render it smaller or with fewer samples");
        }
    }
}

/// The pictures of the language page, which its scenes make.
#[test]
fn the_pictures_of_the_language_are_those_of_their_scenes() {
    let folder = project("docs").join(LANGUAGE);
    let page = Page::read(&project("docs/language.md")).lines.join("\n");
    let scenes = file_names(&folder, "scn");
    assert!(!scenes.is_empty());
    let scratch = tempfile::tempdir().unwrap();
    let mut failures = Vec::new();
    for scene in &scenes {
        let name = scene.trim_end_matches(".scn");
        let made = scratch.path().join(format!("{name}.png"));
        let rendered = Command::new(env!("CARGO_BIN_EXE_superegg"))
            .args(["render", "--quiet", "-o"])
            .arg(&made)
            .arg(folder.join(scene))
            .output()
            .unwrap();
        if !rendered.status.success() || !rendered.stderr.is_empty() {
            failures.push(format!("{scene}: {}", String::from_utf8_lossy(&rendered.stderr)));
        } else if let Err(why) = superegg_golden::check(&folder, name, &made) {
            failures.push(why);
        }
        if !page.contains(&format!("{LANGUAGE}/{name}.png")) {
            failures.push(format!("docs/language.md does not show {name}"));
        }
    }
    let pictures: Vec<String> =
        file_names(&folder, "png").into_iter().map(|name| name.replace(".png", ".scn")).collect();
    failures.extend(
        pictures.iter().filter(|scene| !scenes.contains(*scene)).map(|scene| format!("{scene} is missing")),
    );
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}

#[test]
fn the_readme_is_short() {
    let lines = Page::read(&project("README.md")).lines.len();
    assert!(lines <= 150, "{lines} lines: what is long belongs to the book");
}

#[test]
fn every_page_is_in_the_summary() {
    let listed = summary();
    for name in file_names(&project("docs"), "md") {
        assert!(name == "SUMMARY.md" || listed.contains(&name), "docs/SUMMARY.md does not list {name}");
    }
    for name in file_names(&project("docs/python"), "md") {
        assert!(listed.contains(&format!("python/{name}")), "docs/SUMMARY.md does not list python/{name}");
    }
}

/// The files of the project, without those of builds.
fn files() -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut folders = vec![project("")];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(&folder).unwrap() {
            let path = entry.unwrap().path();
            let name = path.file_name().unwrap().to_string_lossy().into_owned();
            if !path.is_dir() {
                found.push(path);
            } else if !path.is_symlink()
                && !name.starts_with('.')
                && name != "target"
                && name != "node_modules"
                && name != "shared"
            {
                folders.push(path);
            }
        }
    }
    found.sort();
    found
}

/// Every text of the project that has links.
fn documents() -> Vec<PathBuf> {
    files().into_iter().filter(|path| path.extension().is_some_and(|is| is == "md")).collect()
}

/// The words that a word such as `shade/{direct,phong}.rs` stands for.
fn expanded(word: &str) -> Vec<String> {
    let parts = word.split_once('{').and_then(|(before, rest)| Some((before, rest.split_once('}')?)));
    match parts {
        Some((before, (names, after))) => {
            names.split(',').map(|name| format!("{before}{name}{after}")).collect()
        }
        None => vec![word.to_owned()],
    }
}

/// Sources and scripts that documents name, paths that begin in a folder of the project, and tests that commands run. Words in
/// capitals and stars stand for names; names of sources without a folder may be those of users.
#[test]
fn every_path_of_a_document_exists() {
    let is_text =
        |word: &str| word.bytes().all(|byte| byte.is_ascii_alphanumeric() || b"_-./".contains(&byte));
    let is_general = |part: &str| part.len() > 1 && part.bytes().all(|byte| byte.is_ascii_uppercase());
    let root = project("");
    let files: Vec<String> =
        files().iter().map(|path| path.strip_prefix(&root).unwrap().to_str().unwrap().to_owned()).collect();
    let folders: BTreeSet<&str> = files.iter().filter_map(|file| Some(file.split_once('/')?.0)).collect();
    // A path may begin in a folder within the project, as `shade/path.rs` does.
    let is_source = |word: &str| {
        let within = format!("/{word}");
        files.iter().any(|file| file == word || file.ends_with(&within))
    };
    let mut failures = Vec::new();
    let mut count = 0;
    for path in documents() {
        let page = Page::read(&path);
        let mut last = "";
        for (line, word) in page.code_words() {
            for word in expanded(word.trim_end_matches(['.', ',', ';', ':', ')']).trim_start_matches('(')) {
                let first = word.split('/').next().unwrap();
                let is_general = word.split(['/', '.']).any(is_general);
                let has_folder = word.contains('/') && is_text(&word) && !is_general;
                let exists = if last == "--test" {
                    is_source(&format!("tests/{word}.rs")) || is_source(&format!("tests/{word}/main.rs"))
                } else if has_folder && [".rs", ".py", ".sh"].iter().any(|end| word.ends_with(end)) {
                    is_source(&word)
                } else if has_folder && folders.contains(first) {
                    project(&word).exists()
                } else {
                    continue;
                };
                count += 1;
                if !exists {
                    failures.push(format!("{}: '{word}' does not exist", page.at(line)));
                }
            }
            last = word;
        }
    }
    assert!(count > 150, "{count} paths");
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}

#[test]
fn every_link_leads_somewhere() {
    let mut failures = Vec::new();
    let documents = documents();
    assert!(documents.len() > 20);
    for path in &documents {
        let page = Page::read(path);
        for (line, target) in page.links() {
            if target.contains("://") || target.starts_with("mailto:") {
                continue;
            }
            let (file, anchor) = target.split_once('#').unwrap_or((&target, ""));
            // A page in the browser reads the part behind the question mark.
            let file = file.split_once('?').map_or(file, |(file, _)| file);
            let goal = if file.is_empty() { path.clone() } else { path.parent().unwrap().join(file) };
            if !goal.exists() {
                failures.push(format!("{}: {file} does not exist", page.at(line)));
            } else if !anchor.is_empty()
                && goal.extension().is_some_and(|is| is == "md")
                && !Page::read(&goal).anchors().iter().any(|is| is == anchor)
            {
                failures.push(format!("{}: {file} has no heading #{anchor}", page.at(line)));
            }
        }
    }
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}

/// mdBook is not needed to read the pages; where it is installed it must make a book of them.
#[test]
fn mdbook_builds_the_book() {
    let out = tempfile::tempdir().unwrap();
    match Command::new("mdbook").arg("build").arg(project("docs")).arg("-d").arg(out.path()).output() {
        Err(_) => eprintln!("skipped: mdbook is not on this machine"),
        Ok(built) => {
            assert!(built.status.success(), "{}", String::from_utf8_lossy(&built.stderr));
            assert!(out.path().join("tutorial.html").is_file());
        }
    }
}
