//! Runs the blocks of a page in a folder of their own.
//!
//! | block | what happens |
//! |---|---|
//! | `console` | each line after `$` is run by a shell; the lines below it are its output, where there are any. `...` stands for any lines; times and the last digits of numbers may differ |
//! | `LANGUAGE FILE` | is written to the file |
//! | `scn` | is run as a session, without errors |
//! | `session` | the lines behind prompts are typed; the others are the output |
//! | `python` | has prompts `>>>`, and is run with the Python package by `crates/superegg-python/check.sh` |
//! | `text` | is to be read, such as a formula |
//! | `sh` | is not run; its first line is a comment that says why |

use std::path::{Path, PathBuf};
use std::process::Command;

use tempfile::TempDir;

use crate::page::{Block, Page};

/// A folder in which the commands of one page are run, and the home of their user.
pub(crate) struct Runner {
    folder: TempDir,
    home: TempDir,
    failures: Vec<String>,
    /// Blocks whose output has changed: lines of the page, and the new ones.
    changes: Vec<(std::ops::Range<usize>, Vec<String>)>,
}

/// The result of a page that was run.
pub(crate) struct Ran {
    folder: TempDir,
    pub(crate) failures: Vec<String>,
    pub(crate) changes: Vec<(std::ops::Range<usize>, Vec<String>)>,
}

impl Ran {
    pub(crate) fn file(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }
}

/// Runs all blocks of a page in order.
pub(crate) fn run_page(page: &Page) -> Ran {
    let mut runner = Runner {
        folder: tempfile::tempdir().unwrap(),
        home: tempfile::tempdir().unwrap(),
        failures: Vec::new(),
        changes: Vec::new(),
    };
    for name in ["scenes", "examples"] {
        std::os::unix::fs::symlink(crate::project(name).canonicalize().unwrap(), runner.path(name)).unwrap();
    }
    for block in page.blocks() {
        runner.run(page, &block);
    }
    let Runner { folder, failures, changes, .. } = runner;
    Ran { folder, failures, changes }
}

impl Runner {
    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn run(&mut self, page: &Page, block: &Block) {
        let lines = &page.lines[block.lines.clone()];
        let place = page.at(block.lines.start);
        let text = || lines.join("\n") + "\n";
        match (block.kind.as_str(), &block.file) {
            ("text", None) => {}
            ("console", None) => self.console(page, block),
            ("session", None) => self.session(page, block),
            ("scn", None) => {
                std::fs::write(self.path("block.scn"), text()).unwrap();
                let (output, code) = self.shell("superegg run block.scn");
                if code != Some(0) {
                    self.failures.push(format!("{place}: the session fails:\n{output}"));
                }
            }
            ("python", None) => {
                let page_file = page.at(0);
                let name = format!("../../{}", page_file.split(':').next().unwrap());
                let check =
                    std::fs::read_to_string(crate::project("crates/superegg-python/check.sh")).unwrap();
                if !check.split_whitespace().any(|word| word == name)
                    || !lines.first().is_some_and(|line| line.starts_with(">>> "))
                {
                    self.failures.push(format!(
                        "{place}: no test runs this Python: begin with >>> on a page of check.sh"
                    ));
                }
            }
            ("sh", None) => {
                if !lines.first().is_some_and(|line| line.starts_with("# Not run by the tests: ")) {
                    self.failures
                        .push(format!("{place}: begin with '# Not run by the tests: ' and the reason"));
                }
            }
            (_, Some(file)) if !file.contains("..") => {
                let path = self.path(file);
                std::fs::create_dir_all(path.parent().unwrap()).unwrap();
                std::fs::write(path, text()).unwrap();
            }
            (kind, _) => self.failures.push(format!("{place}: nothing runs a block of '{kind}'")),
        }
    }

    /// Standard output and error of a command, in the order in which they were written, and its exit code.
    fn shell(&self, command: &str) -> (String, Option<i32>) {
        let programs = Path::new(env!("CARGO_BIN_EXE_superegg")).parent().unwrap();
        let path = std::env::var("PATH").unwrap_or_default();
        let output = Command::new("sh")
            .args(["-c", &format!("exec 2>&1\n{command}\n")])
            .current_dir(self.folder.path())
            .env("PATH", format!("{}:{path}", programs.display()))
            .env("HOME", self.home.path())
            .env("XDG_STATE_HOME", self.home.path().join("state"))
            .env("XDG_DATA_HOME", self.home.path().join("data"))
            .env_remove("DISPLAY")
            .env_remove("WAYLAND_DISPLAY")
            .output()
            .unwrap();
        (String::from_utf8_lossy(&output.stdout).into_owned(), output.status.code())
    }

    fn console(&mut self, page: &Page, block: &Block) {
        let mut at = block.lines.start;
        while at < block.lines.end {
            let Some(command) = page.lines[at].strip_prefix("$ ") else {
                self.failures.push(format!("{}: a console begins with '$ '", page.at(at)));
                return;
            };
            let place = page.at(at);
            let mut command = command.to_owned();
            while command.ends_with('\\') && at + 1 < block.lines.end {
                at += 1;
                command.push('\n');
                command.push_str(&page.lines[at]);
            }
            let first = at + 1;
            at = (first..block.lines.end)
                .find(|&at| page.lines[at].starts_with("$ "))
                .unwrap_or(block.lines.end);
            let (output, code) = self.shell(&command);
            if code != Some(0) {
                self.failures.push(format!("{place}: exit code {code:?} of {command}\n{output}"));
            }
            self.compare(page, &place, first..at, &output);
        }
    }

    fn session(&mut self, page: &Page, block: &Block) {
        let lines = &page.lines[block.lines.clone()];
        let typed: Vec<&str> = lines.iter().filter_map(|line| typed(line)).collect();
        std::fs::write(self.path("typed.txt"), typed.join("\n") + "\n").unwrap();
        let (output, code) = self.shell("superegg < typed.txt");
        let place = page.at(block.lines.start);
        if code != Some(0) {
            self.failures.push(format!("{place}: exit code {code:?} of the session\n{output}"));
        }
        let shown: Vec<&str> =
            lines.iter().filter(|line| typed_at(line).is_none()).map(String::as_str).collect();
        let printed: Vec<&str> = output.lines().collect();
        if !fits(&shown, &printed) {
            self.failures.push(format!("{place}: the session prints\n{output}"));
        }
    }

    fn compare(&mut self, page: &Page, place: &str, shown: std::ops::Range<usize>, output: &str) {
        let expected: Vec<&str> = page.lines[shown.clone()].iter().map(String::as_str).collect();
        let printed: Vec<&str> = output.lines().collect();
        if expected.is_empty() || fits(&expected, &printed) {
            return;
        }
        if expected.contains(&"...") || std::env::var_os("SUPEREGG_BLESS").is_none() {
            self.failures
                .push(format!("{place}: SUPEREGG_BLESS=1 writes it anew if this is right:\n{output}"));
        } else {
            self.changes.push((shown, printed.into_iter().map(str::to_owned).collect()));
        }
    }
}

/// A program that commands of the page begin with and this machine lacks.
pub(crate) fn missing_tool(page: &Page) -> Option<&'static str> {
    let tool = "python3";
    let is_needed = page.lines.iter().any(|line| line.starts_with(&format!("$ {tool} ")));
    let is_there =
        || Command::new(tool).arg("--version").output().is_ok_and(|output| output.status.success());
    (is_needed && !is_there()).then_some(tool)
}

/// The prompt and the line behind it.
fn typed_at(line: &str) -> Option<(&str, &str)> {
    let (prompt, rest) = line.split_once("> ")?;
    (!prompt.is_empty() && !prompt.contains(' ')).then_some((prompt, rest))
}

fn typed(line: &str) -> Option<&str> {
    typed_at(line).map(|(_, rest)| rest)
}

/// Whether lines are as the page shows them: `...` stands for any lines, and times may differ.
fn fits(expected: &[&str], printed: &[&str]) -> bool {
    match expected {
        [] => printed.is_empty(),
        ["...", rest @ ..] => (0..=printed.len()).any(|skipped| fits(rest, &printed[skipped..])),
        [first, rest @ ..] => printed
            .split_first()
            .is_some_and(|(line, others)| is_same_line(first, line) && fits(rest, others)),
    }
}

/// Whether lines are the same but for times, and for the last digits of other numbers, which depend on the machine.
fn is_same_line(one: &str, other: &str) -> bool {
    let (one, other) = (without_times(one), without_times(other));
    let is_same = |(a, b): (&str, &str)| {
        let number = |word: &str| word.trim_matches([',', '(', ')']).parse::<f64>();
        a == b
            || number(a)
                .and_then(|a| Ok((a, number(b)?)))
                .is_ok_and(|(a, b)| (a - b).abs() <= 1e-6 * (1.0 + a.abs()))
    };
    one.split(' ').count() == other.split(' ').count() && one.split(' ').zip(other.split(' ')).all(is_same)
}

/// A line whose times are all `#`.
fn without_times(line: &str) -> String {
    let words: Vec<&str> = line.trim_end().split(' ').collect();
    let is_time = |at: usize| {
        let unit = words.get(at + 1).map_or("", |unit| unit.trim_end_matches([',', ';', '.', ')']));
        ["s", "ms", "min"].contains(&unit) && words[at].trim_start_matches('(').parse::<f64>().is_ok()
    };
    let words = (0..words.len()).map(|at| if is_time(at) { "#" } else { words[at] });
    words.collect::<Vec<_>>().join(" ")
}

#[test]
fn output_fits_whatever_the_times() {
    assert!(fits(&["a.png: 4 s", "...", "end"], &["a.png: 0.3 s", "x", "y", "end"]));
    assert!(!fits(&["a.png: 4 s"], &["b.png: 4 s"]));
    assert!(!fits(&["one"], &["one", "two"]));
    assert!(fits(&["at 0.30000000000000004, 1"], &["at 0.3, 1"]) && !fits(&["at 0.3"], &["at 0.4"]));
    assert_eq!(typed_at("pair[left]> undo"), Some(("pair[left]", "undo")));
    assert_eq!(typed_at("a is larger -> b"), None);
}
