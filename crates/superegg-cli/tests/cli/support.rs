//! The real binary in a folder of its own.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

use tempfile::TempDir;

/// A folder that is the working folder of every command run in it, and one that is the user's home;
/// both gone at the end.
pub(crate) struct Sandbox(TempDir, TempDir);

impl Sandbox {
    pub(crate) fn new() -> Self {
        Self(tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap())
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub(crate) fn write(&self, name: &str, contents: impl AsRef<[u8]>) -> &Self {
        std::fs::write(self.path(name), contents).unwrap();
        self
    }

    pub(crate) fn read(&self, name: &str) -> String {
        std::fs::read_to_string(self.path(name)).unwrap()
    }

    /// The names of all files here.
    pub(crate) fn files(&self) -> Vec<String> {
        let mut names: Vec<String> = std::fs::read_dir(self.0.path())
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }

    /// Runs `superegg` with these words and this standard input.
    pub(crate) fn run_with(&self, words: &str, input: &str) -> Answer {
        self.run_bytes(words, input.as_bytes())
    }

    pub(crate) fn run_bytes(&self, words: &str, input: &[u8]) -> Answer {
        let mut child = Command::new(env!("CARGO_BIN_EXE_superegg"))
            .args(words.split_whitespace())
            .current_dir(self.0.path())
            .envs(self.user())
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        // Beside the reading of its answer, which may be as long; a command that does not read its
        // input closes it early.
        let (mut stdin, input) = (child.stdin.take().unwrap(), input.to_vec());
        let writing = std::thread::spawn(move || stdin.write_all(&input));
        let answer = Answer::of(child.wait_with_output().unwrap());
        let _ = writing.join().unwrap();
        answer
    }

    /// The environment of a user whose own folders are here, apart from the working folder.
    pub(crate) fn user(&self) -> Vec<(String, PathBuf)> {
        let own = self.1.path();
        [("HOME", ""), ("XDG_STATE_HOME", "state"), ("XDG_DATA_HOME", "data")]
            .map(|(name, folder)| (name.to_owned(), own.join(folder)))
            .into()
    }

    /// A file in the user's own folders.
    pub(crate) fn own(&self, name: &str) -> PathBuf {
        self.1.path().join(name)
    }

    pub(crate) fn run(&self, words: &str) -> Answer {
        self.run_with(words, "")
    }
}

/// The output of a command and its exit code.
#[derive(Debug)]
pub(crate) struct Answer {
    pub(crate) code: Option<i32>,
    pub(crate) out: String,
    pub(crate) err: String,
}

impl Answer {
    fn of(output: Output) -> Self {
        let text = |bytes: Vec<u8>| String::from_utf8_lossy(&bytes).into_owned();
        Self { code: output.status.code(), out: text(output.stdout), err: text(output.stderr) }
    }

    /// The standard output of a command that succeeded and printed no errors.
    #[track_caller]
    pub(crate) fn fine(self) -> String {
        assert_eq!((self.code, self.err.as_str()), (Some(0), ""), "{}", self.out);
        self.out
    }

    /// The standard error of a command that ended with this code.
    #[track_caller]
    pub(crate) fn failed(self, code: i32) -> String {
        assert_eq!(self.code, Some(code), "{}\n{}", self.out, self.err);
        assert!(!self.err.is_empty(), "it says nothing");
        self.err
    }
}

/// A folder of the project.
pub(crate) fn project(folder: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(folder)
}

/// A small generator of numbers for choosing moments and places (xorshift, Marsaglia 2003).
pub(crate) struct Random(pub(crate) u64);

impl Random {
    pub(crate) fn below(&mut self, most: u64) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0 % most
    }
}
