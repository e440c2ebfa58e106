//! A folder of frames that knows what each was made of, so that work which was broken off goes on.

use std::collections::HashMap;
use std::fs::File;
use std::io::{Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};

use crate::files;

/// The list of the frames in a folder: lines of a file's name, the signature of what it shows and the hash of its bytes, the last line of a name counts.
const LIST: &str = "superegg_frames.txt";

/// A folder of numbered pictures, and what each of them shows.
pub(crate) struct FrameFolder {
    path: PathBuf,
    list: File,
    /// Signature and hash of each file by its name.
    known: HashMap<String, (u64, u64)>,
}

impl FrameFolder {
    /// Opens a folder, or makes it.
    pub(crate) fn open(path: &Path) -> Result<Self> {
        if path.exists() && !path.is_dir() {
            bail!("cannot write frames into '{}': it is not a folder", path.display());
        }
        std::fs::create_dir_all(path)
            .with_context(|| format!("cannot make the folder '{}'", path.display()))?;
        let at = path.join(LIST);
        let (list, text) = open_list(&at).with_context(|| format!("cannot write '{}'", at.display()))?;
        let known = text.lines().filter_map(read_line).collect();
        Ok(Self { path: path.to_owned(), list, known })
    }

    /// The name of a frame's file; ffmpeg knows it as [`FrameFolder::PATTERN`].
    pub(crate) fn name(frame: u32) -> String {
        format!("frame_{frame:04}.png")
    }

    /// How names are made of numbers.
    pub(crate) const PATTERN: &str = "frame_%04d.png";

    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// Whether the frame is there and shows this: its file is the one that was written then, to the byte.
    pub(crate) fn has(&self, frame: u32, signature: u64) -> bool {
        let name = Self::name(frame);
        self.known.get(&name).is_some_and(|(known, bytes)| {
            *known == signature
                && std::fs::read(self.path.join(&name)).is_ok_and(|read| hash(&read) == *bytes)
        })
    }

    /// Writes a frame, whole or not at all, and then what it shows: broken off between the two, it is made again.
    pub(crate) fn write(&mut self, frame: u32, signature: u64, png: &[u8]) -> Result<()> {
        let name = Self::name(frame);
        files::write(&self.path.join(&name), png)?;
        let line = format!("{name} {signature:016x} {:016x}\n", hash(png));
        let written = self.list.write_all(line.as_bytes());
        written.with_context(|| format!("cannot write '{}'", self.path.join(LIST).display()))
    }
}

/// The list, to be added to, and what it says so far. A line that was broken off is ended.
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

fn read_line(line: &str) -> Option<(String, (u64, u64))> {
    let mut words = line.split(' ');
    let name = words.next()?;
    let mut number =
        || words.next().filter(|word| word.len() == 16).and_then(|word| u64::from_str_radix(word, 16).ok());
    let numbers = (number()?, number()?);
    Some((name.to_owned(), numbers))
}

/// The 64-bit FNV-1a hash (Fowler, Noll, Vo), which stays the same from version to version: against chance, not against malice.
pub(crate) fn hash(bytes: &[u8]) -> u64 {
    bytes
        .iter()
        .fold(0xcbf2_9ce4_8422_2325, |hash, byte| (hash ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_hash_is_the_published_one() {
        assert_eq!(
            (hash(b""), hash(b"a"), hash(b"foobar")),
            (0xcbf29ce484222325, 0xaf63dc4c8601ec8c, 0x85944171f73967e8)
        );
    }

    #[test]
    fn a_frame_is_there_only_as_it_was_written() {
        let place = tempfile::tempdir().unwrap();
        let mut folder = FrameFolder::open(&place.path().join("a/b")).unwrap();
        folder.write(7, 1, b"one").unwrap();
        folder.write(7, 2, b"two").unwrap();
        folder.write(12345, 3, b"three").unwrap();
        let path = folder.path().to_owned();
        // A line that was broken off.
        std::fs::write(
            path.join(LIST),
            std::fs::read_to_string(path.join(LIST)).unwrap() + "frame_0008.png 00",
        )
        .unwrap();
        let mut folder = FrameFolder::open(&path).unwrap();
        assert!(folder.has(7, 2) && !folder.has(7, 1) && folder.has(12345, 3) && !folder.has(8, 0));
        folder.write(8, 5, b"five").unwrap();
        assert!(FrameFolder::open(&path).unwrap().has(8, 5));
        std::fs::write(path.join("frame_0007.png"), b"twp").unwrap();
        assert!(!FrameFolder::open(&path).unwrap().has(7, 2));
    }
}
