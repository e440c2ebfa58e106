//! A folder of frames with the signature of each, so that an interrupted animation can be resumed.
//!
//! The list also says which files are ours: a frame replaces no file that the list does not have.

use std::collections::HashMap;
use std::fs::File;
use std::io::{Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};

use crate::files::fingerprint::hash;
use crate::files::temporary::remove_leftovers;
use crate::files::{self, Overwrite};

/// The list of the frames. Each line has a file name, the signature of the picture and the hash of
/// the file; the last line of a name is valid. A line is written before its file, so that a file
/// without one is of another maker.
const LIST: &str = "superegg_frames.txt";

/// A folder of numbered pictures with their signatures.
pub(crate) struct FrameFolder {
    path: PathBuf,
    /// [`LIST`], open for appending.
    list: File,
    /// Signature and hash of each file, by name, in the order of the list.
    known: Known,
    overwrite: Overwrite,
    /// The list and the folders that were created for it, innermost first; they are removed if no frame is written.
    made: Vec<PathBuf>,
}

type Known = HashMap<String, Vec<(u64, u64)>>;

impl FrameFolder {
    /// Opens or creates a folder. A folder that is created for one process alone is removed again if that writes no frame;
    /// other shards may use one that `is_shared`.
    ///
    /// # Errors
    /// The path is not a folder, or the list cannot be written.
    pub(crate) fn open(path: &Path, overwrite: Overwrite, is_shared: bool) -> Result<Self> {
        if path.exists() && !path.is_dir() {
            bail!("cannot write frames into '{}': it is not a folder", path.display());
        }
        let list_path = path.join(LIST);
        let made = list_path.ancestors().take_while(|path| !is_there(path) && !is_shared);
        let made = made.map(Path::to_owned).collect();
        std::fs::create_dir_all(path)
            .with_context(|| format!("cannot make the folder '{}'", path.display()))?;
        remove_leftovers(path);
        // The list of another program is no list of frames, whatever is forced.
        files::check_target(&list_path, Overwrite::Writable)?;
        files::check_not_pipe(&list_path)?;
        let (list, text) =
            open_list(&list_path).with_context(|| format!("cannot write '{}'", list_path.display()))?;
        Ok(Self { path: path.to_owned(), list, known: read_list(&text), overwrite, made })
    }

    /// The file name of a frame; [`FrameFolder::PATTERN`] for ffmpeg.
    pub(crate) fn name(frame: u32) -> String {
        format!("frame_{frame:04}.png")
    }

    /// The pattern of file names.
    pub(crate) const PATTERN: &str = "frame_%04d.png";

    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// Whether the frame exists with this signature and its file is unchanged.
    pub(crate) fn has(&self, frame: u32, signature: u64) -> bool {
        let name = Self::name(frame);
        self.known.get(&name).and_then(|lines| lines.last()).is_some_and(|(known, bytes)| {
            *known == signature && files::read(&self.path.join(&name)).is_ok_and(|read| hash(&read) == *bytes)
        })
    }

    /// Checks that a frame would replace no file of another maker, before it is rendered. Other
    /// processes may write frames of the same folder.
    ///
    /// # Errors
    /// There is such a file, or the frame is read-only.
    pub(crate) fn check_replaceable(&mut self, frame: u32) -> Result<()> {
        let name = Self::name(frame);
        let path = self.path.join(&name);
        files::check_target(&path, self.overwrite)?;
        if self.overwrite == Overwrite::Any || !path.exists() {
            return Ok(());
        }
        let found = hash(&files::read(&path)?);
        let is_ours = |known: &Known| {
            known.get(&name).is_some_and(|lines| lines.iter().any(|(_, bytes)| *bytes == found))
        };
        if is_ours(&self.known) {
            return Ok(());
        }
        self.known = read_list(&std::fs::read_to_string(self.path.join(LIST)).unwrap_or_default());
        if is_ours(&self.known) {
            return Ok(());
        }
        bail!(
            "'{}' is not a frame as superegg wrote it, and is not replaced; name another folder with -o, or --force replaces it",
            path.display()
        );
    }

    /// Writes the line of a frame, then the frame, completely or not at all. An interruption between
    /// the two only renders the frame again.
    pub(crate) fn write(&mut self, frame: u32, signature: u64, png: &[u8]) -> Result<()> {
        let (name, hash) = (Self::name(frame), hash(png));
        let line = format!("{name} {signature:016x} {hash:016x}\n");
        let written = self.list.write_all(line.as_bytes());
        written.with_context(|| format!("cannot write '{}'", self.path.join(LIST).display()))?;
        files::write(&self.path.join(&name), png)?;
        self.known.entry(name).or_default().push((signature, hash));
        self.made.clear();
        Ok(())
    }
}

impl Drop for FrameFolder {
    fn drop(&mut self) {
        for path in &self.made {
            // The list is empty. A folder with other files stays.
            let _ = if path.ends_with(LIST) { std::fs::remove_file(path) } else { std::fs::remove_dir(path) };
        }
    }
}

/// Whether there is a file or folder. The empty path is the working folder.
fn is_there(path: &Path) -> bool {
    path.as_os_str().is_empty() || path.exists()
}

/// The lines of each name of a list.
fn read_list(text: &str) -> Known {
    let mut known = Known::new();
    for (name, numbers) in text.lines().filter_map(read_line) {
        known.entry(name).or_default().push(numbers);
    }
    known
}

/// Opens the list for appending and returns its text. Ends an incomplete last line.
fn open_list(path: &Path) -> std::io::Result<(File, String)> {
    let mut list = File::options().read(true).append(true).create(true).open(path)?;
    let mut bytes = Vec::new();
    list.seek(SeekFrom::Start(0))?;
    list.read_to_end(&mut bytes)?;
    if bytes.last().is_some_and(|last| *last != b'\n') {
        list.write_all(b"\n")?;
    }
    Ok((list, String::from_utf8_lossy(&bytes).into_owned()))
}

/// Parses a line of the list.
fn read_line(line: &str) -> Option<(String, (u64, u64))> {
    let mut words = line.split(' ');
    let name = words.next()?;
    let mut number =
        || words.next().filter(|word| word.len() == 16).and_then(|word| u64::from_str_radix(word, 16).ok());
    let numbers = (number()?, number()?);
    Some((name.to_owned(), numbers))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_frame_is_there_only_as_it_was_written() {
        let parent = tempfile::tempdir().unwrap();
        let open = |path: &Path| FrameFolder::open(path, Overwrite::Writable, false);
        let mut folder = open(&parent.path().join("a/b")).unwrap();
        folder.write(7, 1, b"one").unwrap();
        folder.write(7, 2, b"two").unwrap();
        folder.write(12345, 3, b"three").unwrap();
        let path = folder.path().to_owned();
        // An incomplete line.
        std::fs::write(
            path.join(LIST),
            std::fs::read_to_string(path.join(LIST)).unwrap() + "frame_0008.png 00",
        )
        .unwrap();
        let mut folder = open(&path).unwrap();
        assert!(folder.has(7, 2) && !folder.has(7, 1) && folder.has(12345, 3) && !folder.has(8, 0));
        folder.write(8, 5, b"five").unwrap();
        assert!(open(&path).unwrap().has(8, 5));
        std::fs::write(path.join("frame_0007.png"), b"twp").unwrap();
        let mut folder = open(&path).unwrap();
        assert!(!folder.has(7, 2));
        for (frame, is_ours) in [(6, true), (7, false), (8, true), (12345, true)] {
            assert_eq!(folder.check_replaceable(frame).is_ok(), is_ours, "{frame}");
        }
        assert!(FrameFolder::open(&path, Overwrite::Any, false).unwrap().check_replaceable(7).is_ok());
        // The frame of an earlier line, as after an interruption before the file was replaced.
        std::fs::write(path.join("frame_0007.png"), b"one").unwrap();
        assert!(folder.check_replaceable(7).is_ok());
    }
}
