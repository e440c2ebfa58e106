//! Partial files (`.part`): finished tiles are appended as they come, so that a stopped or killed
//! render can be resumed.

use std::fs::{File, TryLockError};
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::{LazyLock, Mutex, MutexGuard, PoisonError};

use anyhow::{Context, Result, bail, ensure};
use superegg_render::{Difference, Film, PartError, PartFile, PartHeader};

use crate::files;

/// The path of a picture's partial file: the name of the picture with `.part`.
pub(crate) fn checkpoint_path(picture: &Path) -> PathBuf {
    let mut name = picture.as_os_str().to_owned();
    name.push(".part");
    PathBuf::from(name)
}

/// Tile indices and the pixels of the tiles.
pub(crate) type Tiles = Vec<(usize, Film)>;

/// The content of a partial file.
pub(crate) struct CheckpointData {
    pub(crate) header: PartHeader,
    pub(crate) tiles: Tiles,
    /// The length up to the last valid record.
    end: u64,
    /// The number of damaged bytes before `end`.
    pub(crate) damaged_bytes: u64,
}

/// Reads a partial file.
///
/// # Errors
/// The file is unreadable, not a partial file, or longer than its picture allows.
pub(crate) fn read(path: &Path) -> Result<CheckpointData> {
    files::check_plain_file(path)?;
    let cannot_read = || format!("cannot read '{}'", path.display());
    let file = File::open(path).with_context(cannot_read)?;
    Ok(PartFile::read(&file).with_context(cannot_read)?.into())
}

/// Whether a partial file exists and stores the AOV layers of each pixel.
pub(crate) fn has_layers(path: &Path) -> bool {
    let mut bytes = Vec::new();
    let read = files::check_plain_file(path).is_ok()
        && File::open(path)
            .is_ok_and(|file| file.take(PartHeader::MOST_BYTES).read_to_end(&mut bytes).is_ok());
    read && PartHeader::read(&bytes).is_ok_and(|(header, _)| header.has_layers())
}

impl From<PartFile> for CheckpointData {
    fn from(PartFile { header, tiles, end, damaged }: PartFile) -> Self {
        Self { header, tiles, end, damaged_bytes: damaged }
    }
}

/// Describes a difference between two pictures; `one` and `two` say which value belongs to which.
pub(crate) fn describe_difference(
    Difference { name, values, .. }: &Difference,
    one: &str,
    two: &str,
) -> String {
    match values {
        Some((ours, theirs)) => {
            format!("{} is {ours} {one}, {theirs} {two}", name.replace('_', " "))
        }
        None if name == "scene" => "the scene has changed".to_owned(),
        None => format!("the {name} differ"),
    }
}

/// The partial file of a render in progress.
pub(crate) struct Checkpoint<'a> {
    path: PathBuf,
    /// Whether the file is temporary: the picture is the result. False for a shard, whose result is
    /// this file.
    is_temporary: bool,
    /// Whether a partial file of an earlier render exists.
    has_older: bool,
    /// Computed on first use, which takes a while for a large scene.
    header: LazyLock<PartHeader, Box<dyn FnOnce() -> PartHeader + Send + 'a>>,
    state: Mutex<State>,
}

/// The file of a checkpoint.
enum State {
    /// Not created yet; the indices of the tiles so far.
    Waiting(Vec<usize>),
    /// The file, locked and positioned at its end.
    Open(File),
    /// A write failed.
    Failed,
}

impl<'a> Checkpoint<'a> {
    /// A checkpoint whose file is created later, when the render turns out to be long.
    pub(crate) fn deferred(
        path: PathBuf,
        is_temporary: bool,
        header: impl FnOnce() -> PartHeader + Send + 'a,
    ) -> Self {
        let state = State::Waiting(Vec::new());
        let has_older = files::begins_with(&path, PartHeader::FAMILY);
        Self {
            path,
            is_temporary,
            has_older,
            header: LazyLock::new(Box::new(header)),
            state: Mutex::new(state),
        }
    }

    /// Creates the file.
    ///
    /// # Errors
    /// The file cannot be written.
    pub(crate) fn create_now(&self) -> Result<()> {
        *self.state() = State::Open(self.create(&[], &|_| Film::without_layers(0, 0))?);
        Ok(())
    }

    /// Continues the file of an earlier render and returns its content; `None` without a file or
    /// without a complete header.
    ///
    /// # Errors
    /// The file is unreadable, or belongs to another picture or shard.
    pub(crate) fn resume(&self) -> Result<Option<CheckpointData>> {
        self.try_resume().with_context(|| format!("cannot resume from '{}'", self.path.display()))
    }

    fn try_resume(&self) -> Result<Option<CheckpointData>> {
        const HINT: &str = "without --resume the render starts again";
        if self.path.exists() {
            files::check_plain_file(&self.path)?;
        }
        let file = match File::options().read(true).write(true).open(&self.path) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
            opened => opened?,
        };
        lock(&file)?;
        let part = match PartFile::read(&file) {
            Ok(part) => CheckpointData::from(part),
            Err(PartError::BrokenOff) => return Ok(None),
            Err(error) => bail!("{error}; {HINT}"),
        };
        if let Some(difference) = part.header.difference(&self.header) {
            bail!("it is of another picture: {}; {HINT}", describe_difference(&difference, "there", "here"));
        }
        let (theirs, ours) = (part.header.shard, self.header.shard);
        ensure!(theirs == ours, "it is shard {theirs}, not {ours}; {HINT}");
        // The next record must follow a valid one.
        file.set_len(part.end)?;
        (&file).seek(SeekFrom::End(0))?;
        *self.state() = State::Open(file);
        Ok(Some(part))
    }

    /// Whether a partial file of an earlier render exists.
    pub(crate) fn has_older(&self) -> bool {
        self.has_older
    }

    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Creates the file with these tiles. A temporary file replaces nothing but another partial
    /// file.
    fn create(&self, tiles: &[usize], pixels_of: &dyn Fn(usize) -> Film) -> Result<File> {
        let create = || {
            files::check_not_pipe(&self.path)?;
            files::check_link(&self.path)?;
            let mut file =
                File::options().read(true).write(true).create(true).truncate(false).open(&self.path)?;
            lock(&file)?;
            let mut first = Vec::new();
            (&file).take(PartHeader::MOST_BYTES).read_to_end(&mut first)?;
            ensure!(
                !self.is_temporary || PartHeader::read(&first).err() != Some(PartError::NotAPart),
                "there is another file of that name"
            );
            file.set_len(0)?;
            file.seek(SeekFrom::Start(0))?;
            file.write_all(&self.header.to_bytes())?;
            let record = |&tile: &usize| self.header.record(tile, &pixels_of(tile));
            tiles.iter().try_for_each(|tile| file.write_all(&record(tile)))?;
            Ok(file)
        };
        create().with_context(|| format!("cannot write '{}'", self.path.display()))
    }

    /// Adds a finished tile.
    ///
    /// # Errors
    /// The file cannot be written. Later calls succeed and do nothing.
    pub(crate) fn add(&self, tile: usize, pixels: &Film) -> Result<()> {
        let mut state = self.state();
        match &mut *state {
            State::Waiting(tiles) => {
                tiles.push(tile);
                Ok(())
            }
            State::Open(file) => {
                let written = file.write_all(&self.header.record(tile, pixels));
                written.with_context(|| format!("cannot write '{}'", self.path.display())).inspect_err(|_| {
                    *state = State::Failed;
                    if self.is_temporary {
                        // The picture may need the space.
                        let _ = std::fs::remove_file(&self.path);
                    }
                })
            }
            State::Failed => Ok(()),
        }
    }

    /// Creates the file with the tiles so far, if it does not exist yet. `pixels_of` returns the
    /// pixels of an added tile.
    ///
    /// # Errors
    /// The file cannot be written. Later calls succeed and do nothing.
    pub(crate) fn create_if_missing(&self, pixels_of: &dyn Fn(usize) -> Film) -> Result<()> {
        // Compute it before the lock, on which threads with finished tiles would wait.
        LazyLock::force(&self.header);
        let mut state = self.state();
        let State::Waiting(tiles) = &*state else { return Ok(()) };
        let (next, result) = match self.create(tiles, pixels_of) {
            Ok(file) => (State::Open(file), Ok(())),
            Err(error) => (State::Failed, Err(error)),
        };
        *state = next;
        result
    }

    /// Creates the file of a render that stops, if it does not exist yet. It does not replace the
    /// file of an earlier render, which has more tiles.
    ///
    /// # Errors
    /// The file cannot be written.
    pub(crate) fn keep(&self, pixels_of: &dyn Fn(usize) -> Film) -> Result<()> {
        if self.has_older { Ok(()) } else { self.create_if_missing(pixels_of) }
    }

    /// Whether the file exists and has all added tiles.
    pub(crate) fn is_complete(&self) -> bool {
        matches!(&*self.state(), State::Open(_))
    }

    /// Syncs the file to the disk.
    ///
    /// # Errors
    /// The file cannot be written.
    pub(crate) fn sync(&self) -> Result<()> {
        let State::Open(file) = &*self.state() else { return Ok(()) };
        file.sync_all().with_context(|| format!("cannot write '{}'", self.path.display()))
    }

    /// Removes the file after the picture is written.
    ///
    /// # Errors
    /// The file cannot be removed.
    pub(crate) fn remove(self) -> Result<()> {
        let state = self.state.into_inner().unwrap_or_else(PoisonError::into_inner);
        let State::Open(file) = state else { return Ok(()) };
        // Some systems cannot remove an open file.
        drop(file);
        std::fs::remove_file(&self.path).with_context(|| format!("cannot remove '{}'", self.path.display()))
    }
}

/// Locks the file against other processes.
fn lock(file: &File) -> Result<()> {
    match file.try_lock() {
        Err(TryLockError::WouldBlock) => bail!("another superegg is writing it"),
        // Not every file system has locks.
        Ok(()) | Err(TryLockError::Error(_)) => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use superegg_render::{Pixel, RenderSettings, Shard};
    use superegg_scene::{Picture, Scene};

    use super::*;

    fn header(samples: u32) -> PartHeader {
        let picture = Picture { width: 36, height: 5, samples, ..Picture::default() };
        let settings = RenderSettings::of(&Scene::default()).with_picture(picture);
        PartHeader::new("1", "prm egg", None, 1, &settings, Shard::WHOLE)
    }

    /// The pixels of the second tile.
    fn pixels() -> Film {
        Film::of_pixels(4, 5, [Pixel { samples: 7, ..Pixel::EMPTY }; 4 * 5])
    }

    #[test]
    fn a_file_is_created_when_it_is_needed_and_removed_with_its_picture() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.part");
        let part = Checkpoint::deferred(path.clone(), true, || header(1));
        part.add(1, &pixels()).unwrap();
        assert!(!path.exists() && !part.is_complete());
        part.keep(&|_| pixels()).unwrap();
        part.add(1, &pixels()).unwrap();
        assert!(part.is_complete());
        let found = read(&path).unwrap();
        assert_eq!((found.tiles, found.damaged_bytes), (vec![(1, pixels())], 0));
        let other = Checkpoint::deferred(path.clone(), true, || header(1));
        assert!(other.try_resume().is_err_and(|error| error.to_string().contains("another superegg")));
        part.remove().unwrap();
        assert!(!path.exists() && other.try_resume().unwrap().is_none());
    }

    #[test]
    fn an_older_file_is_not_replaced_for_a_moment_of_work() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.part");
        std::fs::write(&path, header(2).to_bytes()).unwrap();
        let part = Checkpoint::deferred(path.clone(), true, || header(1));
        part.add(1, &pixels()).unwrap();
        part.keep(&|_| pixels()).unwrap();
        assert!(part.has_older() && !part.is_complete());
        part.remove().unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), header(2).to_bytes());
    }

    #[test]
    fn a_file_that_is_something_else_is_left() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.part");
        std::fs::write(&path, "notes").unwrap();
        let part = Checkpoint::deferred(path.clone(), true, || header(1));
        assert!(part.create_now().is_err() && part.resume().is_err());
        part.add(1, &pixels()).unwrap();
        assert!(format!("{:#}", part.keep(&|_| pixels()).unwrap_err()).contains("another file of that name"));
        assert_eq!(std::fs::read(&path).unwrap(), b"notes");
        // A file that the user named is replaced, like any output.
        Checkpoint::deferred(path.clone(), false, || header(1)).create_now().unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), header(1).to_bytes());
    }

    #[test]
    fn endless_files_are_rejected() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.part");
        let mut bytes = header(1).to_bytes();
        bytes.resize(header(1).most_bytes() as usize * 2 + PartHeader::MOST_BYTES as usize, 0);
        std::fs::write(&path, bytes).unwrap();
        assert!(format!("{:#}", read(&path).err().unwrap()).contains("longer than its picture"));
    }
}
