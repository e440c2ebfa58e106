//! Temporary files: they replace their target when they are complete, and are recognized and removed
//! later if their writer was killed.

use std::fs::{File, TryLockError};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::time::SystemTime;

/// The beginning of the name: then follow two numbers with a dash between, and an extension.
const PREFIX: &str = ".superegg-";
/// How often a new name is tried.
const MOST_ATTEMPTS: u32 = 100;

/// A new file beside its target, locked as long as it is written. It is removed unless it is committed.
pub(crate) struct TemporaryFile {
    file: File,
    path: PathBuf,
    target: PathBuf,
    is_committed: bool,
}

impl TemporaryFile {
    /// Creates an empty file in the folder of a target, with the extension of the target. If the
    /// target is a link, its own target is meant.
    ///
    /// # Errors
    /// The folder cannot be written.
    pub(crate) fn beside(target: &Path) -> io::Result<Self> {
        let target = target.canonicalize().unwrap_or_else(|_| target.to_owned());
        let extension = target.extension().and_then(|extension| extension.to_str());
        let extension = extension.filter(|extension| is_extension(extension)).unwrap_or("tmp");
        for attempt in 0..MOST_ATTEMPTS {
            let now = SystemTime::UNIX_EPOCH.elapsed().map_or(0, |since| since.as_nanos());
            let number = now + u128::from(attempt);
            let path =
                folder_of(&target).join(format!("{PREFIX}{}-{number}.{extension}", std::process::id()));
            let file = match File::options().read(true).write(true).create_new(true).open(&path) {
                Err(error) if error.kind() == io::ErrorKind::AlreadyExists => continue,
                created => created?,
            };
            // Without locks on this file system nobody removes the file either.
            let is_mine = !matches!(file.try_lock(), Err(TryLockError::WouldBlock));
            // Another process may have taken it for a leftover before it was locked.
            if is_mine && path.exists() {
                return Ok(Self { file, path, target, is_committed: false });
            }
        }
        Err(io::Error::new(io::ErrorKind::AlreadyExists, "there is no free name for a temporary file"))
    }

    /// The path, for another program that writes the file.
    pub(crate) fn path_for_writer(&self) -> &Path {
        // Elsewhere a lock shuts out other programs.
        #[cfg(not(unix))]
        let _ = self.file.unlock();
        &self.path
    }

    /// Replaces the target, which keeps its permissions and, where possible, its owner.
    ///
    /// # Errors
    /// The file cannot be written. The target is then as it was.
    pub(crate) fn commit(mut self) -> io::Result<()> {
        if let Ok(metadata) = self.target.metadata() {
            #[cfg(unix)]
            {
                use std::os::unix::fs::MetadataExt;
                // Only root can give files away.
                let _ = std::os::unix::fs::fchown(&self.file, Some(metadata.uid()), Some(metadata.gid()));
            }
            // Some file systems have no permissions.
            let _ = self.file.set_permissions(metadata.permissions());
        }
        self.file.sync_all()?;
        std::fs::rename(&self.path, &self.target)?;
        self.is_committed = true;
        Ok(())
    }
}

impl Write for TemporaryFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.file.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

impl Drop for TemporaryFile {
    fn drop(&mut self) {
        if !self.is_committed {
            // One that stays is removed by a later command.
            let _ = std::fs::remove_file(&self.path);
        }
    }
}

/// Removes the temporary files of a folder whose writers were killed: those with a name of
/// [`TemporaryFile::beside`] that nobody has locked.
pub(crate) fn remove_leftovers(folder: &Path) {
    for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
        let is_ours = entry.file_name().to_str().is_some_and(is_temporary)
            && entry.file_type().is_ok_and(|kind| kind.is_file());
        if !is_ours {
            continue;
        }
        let Ok(file) = File::options().write(true).open(entry.path()) else { continue };
        if file.try_lock().is_ok() {
            // One that stays is removed by a later command.
            let _ = std::fs::remove_file(entry.path());
        }
    }
}

/// Whether a name is one of [`TemporaryFile::beside`].
fn is_temporary(name: &str) -> bool {
    let is_number = |text: &str| !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit());
    let parts = name.strip_prefix(PREFIX).and_then(|rest| rest.split_once('.'));
    let Some((numbers, extension)) = parts else { return false };
    numbers.split_once('-').is_some_and(|(process, number)| is_number(process) && is_number(number))
        && is_extension(extension)
}

fn is_extension(text: &str) -> bool {
    !text.is_empty() && text.len() <= 16 && text.bytes().all(|byte| byte.is_ascii_alphanumeric())
}

/// The folder of a path; the working folder for a name alone.
pub(super) fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_there_whole_or_not_at_all_and_leftovers_are_recognized() {
        let folder = tempfile::tempdir().unwrap();
        let target = folder.path().join("a.scn");
        let names = || -> Vec<String> {
            let entries = std::fs::read_dir(folder.path()).unwrap();
            entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect()
        };
        drop(TemporaryFile::beside(&target).unwrap());
        assert!(names().is_empty());
        let mut file = TemporaryFile::beside(&target).unwrap();
        file.write_all(b"prm a\n").unwrap();
        assert!(names().iter().all(|name| is_temporary(name) && name.ends_with(".scn")));
        remove_leftovers(folder.path());
        assert_eq!(names().len(), 1, "it is in use");
        file.commit().unwrap();
        assert_eq!(
            (names(), std::fs::read(&target).unwrap()),
            (vec!["a.scn".to_owned()], b"prm a\n".to_vec())
        );
        for name in [".superegg-12-345.png", ".superegg-1-2.tmp"] {
            std::fs::write(folder.path().join(name), "").unwrap();
        }
        let others = [
            ".superegg-12.png",
            ".superegg-a-1.png",
            ".superegg-1-2",
            "superegg-1-2.png",
            ".superegg-1-2.p.q",
        ];
        others.iter().for_each(|name| std::fs::write(folder.path().join(name), "").unwrap());
        remove_leftovers(folder.path());
        assert_eq!(names().len(), 1 + others.len());
    }
}
