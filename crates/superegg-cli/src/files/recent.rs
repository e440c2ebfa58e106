//! The scene files of earlier sessions, the latest first: a file of paths, one a line.

use std::path::{Path, PathBuf};

use anyhow::Result;

use crate::files;

/// Most files that are kept.
const MOST_RECENT: usize = 12;

/// The recent files, and the file that keeps them.
#[derive(Debug, Default)]
pub(crate) struct RecentFiles {
    /// `None` where the system has no folder for it.
    path: Option<PathBuf>,
    files: Vec<PathBuf>,
}

impl RecentFiles {
    pub(crate) fn read(path: Option<PathBuf>) -> Self {
        let text = path.as_ref().and_then(|path| std::fs::read_to_string(path).ok()).unwrap_or_default();
        let files = text.lines().filter(|line| !line.is_empty()).map(PathBuf::from);
        Self { path, files: files.take(MOST_RECENT).collect() }
    }

    pub(crate) fn files(&self) -> &[PathBuf] {
        &self.files
    }

    /// Puts a file first, and keeps the list together with what other sessions have added.
    ///
    /// # Errors
    /// The list cannot be written.
    pub(crate) fn add(&mut self, file: &Path) -> Result<()> {
        let file = std::path::absolute(file).unwrap_or_else(|_| file.to_owned());
        // A path of several lines, or of no text, cannot be kept.
        if file.to_str().is_none_or(|text| text.contains(['\n', '\r'])) {
            return Ok(());
        }
        if self.path.is_some() {
            *self = Self::read(self.path.take());
        }
        self.files.retain(|other| *other != file);
        self.files.insert(0, file);
        self.files.truncate(MOST_RECENT);
        let Some(path) = &self.path else { return Ok(()) };
        if let Some(folder) = path.parent() {
            std::fs::create_dir_all(folder)?;
        }
        let text: String = self.files.iter().map(|file| format!("{}\n", file.display())).collect();
        files::write(path, text.as_bytes())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_latest_file_is_first_and_sessions_share_the_list() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("state").join("recent");
        let mut one = RecentFiles::read(Some(path.clone()));
        let mut other = RecentFiles::read(Some(path.clone()));
        for name in ["/a.scn", "/b.scn", "/a.scn", "/two\nlines.scn"] {
            one.add(Path::new(name)).unwrap();
        }
        other.add(Path::new("/c.scn")).unwrap();
        let names =
            |files: &RecentFiles| files.files().iter().map(|p| p.display().to_string()).collect::<Vec<_>>();
        assert_eq!(names(&other), ["/c.scn", "/a.scn", "/b.scn"]);
        assert_eq!(names(&RecentFiles::read(Some(path.clone()))), ["/c.scn", "/a.scn", "/b.scn"]);
        (0..50).for_each(|i| other.add(&Path::new("/").join(i.to_string())).unwrap());
        assert_eq!(RecentFiles::read(Some(path)).files().len(), MOST_RECENT);
    }
}
