//! The files that a session may overwrite: those that it loaded or saved, as long as they are as it left them, and those of our making.

use std::collections::HashMap;
use std::fs::Metadata;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use crate::files;

/// What every file that we write begins with.
const OUR_MARK: &[u8] = b"# superegg ";

/// How a file looked when the session last read or wrote it.
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

#[derive(Debug, Default)]
pub(crate) struct KnownFiles(HashMap<PathBuf, Stamp>);

impl KnownFiles {
    /// Remembers a file that was just read or written whole.
    pub(crate) fn remember(&mut self, path: &Path) {
        if let (Ok(path), Ok(metadata)) = (path.canonicalize(), path.metadata()) {
            self.0.insert(path, Stamp::of(&metadata));
        }
    }

    /// Why a file should not be overwritten, if so: it is not ours, not known, has changed since, or is not to be written.
    pub(crate) fn check_overwrite(&self, path: &Path) -> Result<(), String> {
        let Ok(metadata) = path.metadata() else { return Ok(()) };
        if !metadata.is_file() {
            return Ok(());
        }
        if metadata.permissions().readonly() {
            return Err(format!("'{}' is read-only", path.display()));
        }
        let known = path.canonicalize().ok().and_then(|path| self.0.get(&path));
        let why = match known {
            Some(stamp) if *stamp == Stamp::of(&metadata) => return Ok(()),
            Some(_) => "has changed since this session read or wrote it",
            None if metadata.len() == 0 || files::begins_with(path, OUR_MARK) => return Ok(()),
            None => "was neither made by Superegg nor loaded in this session",
        };
        Err(format!("'{}' {why}", path.display()))
    }
}
