//! The files that a session may overwrite: files that it loaded or saved and that are unchanged
//! since, and files that Superegg wrote.

use std::collections::HashMap;
use std::fs::Metadata;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use crate::files;

/// The first bytes of every scene file that the program writes.
const SIGNATURE: &[u8] = b"# superegg ";

/// Length and modification time of a file when the session last read or wrote it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Stamp {
    bytes: u64,
    modified: Option<SystemTime>,
}

impl Stamp {
    fn of(metadata: &Metadata) -> Self {
        Self { bytes: metadata.len(), modified: metadata.modified().ok() }
    }
}

/// The stamp of each file, by canonical path.
#[derive(Debug, Default)]
pub(crate) struct KnownFiles(HashMap<PathBuf, Stamp>);

impl KnownFiles {
    /// Records the state of a file right after it was read or written.
    pub(crate) fn remember(&mut self, path: &Path) {
        if let (Ok(path), Ok(metadata)) = (path.canonicalize(), path.metadata()) {
            self.0.insert(path, Stamp::of(&metadata));
        }
    }

    /// Checks that a file may be overwritten.
    ///
    /// # Errors The reason: the file is read-only, has changed, or neither Superegg nor this
    /// session wrote it.
    pub(crate) fn check_overwrite(&self, path: &Path) -> Result<(), String> {
        let Ok(metadata) = path.metadata() else { return Ok(()) };
        if !metadata.is_file() {
            return Ok(());
        }
        if metadata.permissions().readonly() {
            return Err(format!("'{}' is read-only", path.display()));
        }
        let known = path.canonicalize().ok().and_then(|path| self.0.get(&path));
        let reason = match known {
            Some(stamp) if *stamp == Stamp::of(&metadata) => return Ok(()),
            Some(_) => "has changed since this session read or wrote it",
            None if metadata.len() == 0 || files::begins_with(path, SIGNATURE) => return Ok(()),
            None => "was neither made by Superegg nor loaded in this session",
        };
        Err(format!("'{}' {reason}", path.display()))
    }
}
