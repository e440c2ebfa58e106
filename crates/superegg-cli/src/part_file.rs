//! The partial file on disk: finished tiles are appended as they come, so that a render that is stopped or killed can go on.

use std::fs::{File, TryLockError};
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::{LazyLock, Mutex, MutexGuard, PoisonError};

use anyhow::{Context, Result, bail, ensure};
use superegg_render::{Difference, Film, PartError, PartHeader};

use crate::files;

/// The partial file of a picture: its name with `.part`.
pub(crate) fn beside(picture: &Path) -> PathBuf {
    let mut name = picture.as_os_str().to_owned();
    name.push(".part");
    PathBuf::from(name)
}

/// Tiles by their index.
pub(crate) type Tiles = Vec<(usize, Film)>;

/// A partial file as read.
pub(crate) struct ReadPart {
    pub(crate) header: PartHeader,
    pub(crate) tiles: Tiles,
    /// The length up to the last good record.
    end: u64,
    /// How many bytes before that are none.
    pub(crate) damaged: usize,
}

/// Why a partial file cannot be used.
enum ReadError {
    Io(io::Error),
    Part(PartError),
}

impl From<io::Error> for ReadError {
    fn from(error: io::Error) -> Self {
        Self::Io(error)
    }
}

impl From<PartError> for ReadError {
    fn from(error: PartError) -> Self {
        Self::Part(error)
    }
}

/// Reads a partial file whole; one that is longer than any of its picture is refused.
pub(crate) fn read(path: &Path) -> Result<ReadPart> {
    files::check_plain(path)?;
    let read = File::open(path).map_err(ReadError::from).and_then(|file| read_from(&file));
    read.map_err(|error| match error {
        ReadError::Io(error) => anyhow::Error::from(error),
        ReadError::Part(error) => error.into(),
    })
    .with_context(|| format!("cannot read '{}'", path.display()))
}

/// Whether there is a partial file of a picture, and its pixels have more than their light.
pub(crate) fn has_layers(path: &Path) -> bool {
    let mut bytes = Vec::new();
    let read = files::check_plain(path).is_ok()
        && File::open(path)
            .is_ok_and(|file| file.take(PartHeader::MOST_BYTES).read_to_end(&mut bytes).is_ok());
    read && PartHeader::read(&bytes).is_ok_and(|(header, _)| header.has_layers())
}

fn read_from(mut file: &File) -> Result<ReadPart, ReadError> {
    let mut bytes = Vec::new();
    file.take(PartHeader::MOST_BYTES).read_to_end(&mut bytes)?;
    let most = PartHeader::read(&bytes)?.0.most_bytes();
    file.take(most).read_to_end(&mut bytes)?;
    if file.read(&mut [0])? > 0 {
        return Err(
            io::Error::new(io::ErrorKind::FileTooLarge, "it is longer than its picture can be").into()
        );
    }
    let part = superegg_render::PartFile::read(&bytes)?;
    let tiles = part.tiles().collect();
    Ok(ReadPart { tiles, end: part.end as u64, damaged: part.damaged, header: part.header })
}

/// What a difference between two pictures means to a person.
pub(crate) fn told(Difference { name, values }: &Difference, one: &str, two: &str) -> String {
    match values {
        Some((ours, theirs)) => {
            format!("{} is {ours} {one}, {theirs} {two}", name.replace('_', " "))
        }
        None if name == "scene" => "the scene has changed".to_owned(),
        None => format!("the {name} differ"),
    }
}

/// Where finished tiles are kept while a picture is made.
pub(crate) struct PartFile<'a> {
    path: PathBuf,
    /// Whether the picture is what matters, and this file only spares work.
    is_spare: bool,
    /// Whether an earlier render left a partial file of this name.
    has_older: bool,
    /// Made when it is needed: of a large scene that takes a while.
    header: LazyLock<PartHeader, Box<dyn FnOnce() -> PartHeader + Send + 'a>>,
    state: Mutex<State>,
}

enum State {
    /// There is no file yet. The tiles that were added.
    Waiting(Vec<usize>),
    /// The file, locked, at its end.
    Open(File),
    /// It could not be written.
    Failed,
}

impl<'a> PartFile<'a> {
    /// One that is begun when a render turns out to be long.
    pub(crate) fn later(
        path: PathBuf,
        is_spare: bool,
        header: impl FnOnce() -> PartHeader + Send + 'a,
    ) -> Self {
        let state = State::Waiting(Vec::new());
        let has_older = files::begins_with(&path, PartHeader::FAMILY);
        Self { path, is_spare, has_older, header: LazyLock::new(Box::new(header)), state: Mutex::new(state) }
    }

    /// Begins it now.
    ///
    /// # Errors
    /// It cannot be written.
    pub(crate) fn begin_now(&self) -> Result<()> {
        *self.state() = State::Open(self.begin(&[], &|_| Film::without_layers(0, 0))?);
        Ok(())
    }

    /// Goes on with the file that another render left. Returns what it has; `None` where there is no file, or not even a whole header.
    ///
    /// # Errors
    /// It cannot be read, or is of another picture or share.
    pub(crate) fn resume(&self) -> Result<Option<ReadPart>> {
        self.try_resume().with_context(|| format!("cannot go on from '{}'", self.path.display()))
    }

    fn try_resume(&self) -> Result<Option<ReadPart>> {
        const ANEW: &str = "without --resume the picture is begun anew";
        if self.path.exists() {
            files::check_plain(&self.path)?;
        }
        let file = match File::options().read(true).write(true).open(&self.path) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
            opened => opened?,
        };
        lock(&file)?;
        let part = match read_from(&file) {
            Ok(part) => part,
            Err(ReadError::Part(PartError::BrokenOff)) => return Ok(None),
            Err(ReadError::Part(error)) => bail!("{error}; {ANEW}"),
            Err(ReadError::Io(error)) => return Err(error.into()),
        };
        if let Some(difference) = part.header.difference(&self.header) {
            bail!("it is of another picture: {}; {ANEW}", told(&difference, "there", "here"));
        }
        let (theirs, ours) = (part.header.shard, self.header.shard);
        ensure!(theirs == ours, "it is share {theirs}, not {ours}; {ANEW}");
        // What comes next has to follow a good record.
        file.set_len(part.end)?;
        (&file).seek(SeekFrom::End(0))?;
        *self.state() = State::Open(file);
        Ok(Some(part))
    }

    /// Whether an earlier render left a partial file of this name.
    pub(crate) fn has_older(&self) -> bool {
        self.has_older
    }

    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Makes the file with these tiles. One that the user did not name takes the place of a partial file only.
    fn begin(&self, tiles: &[usize], pixels_of: &dyn Fn(usize) -> Film) -> Result<File> {
        let begin = || {
            files::check_no_pipe(&self.path)?;
            let mut file =
                File::options().read(true).write(true).create(true).truncate(false).open(&self.path)?;
            lock(&file)?;
            let mut first = Vec::new();
            (&file).take(PartHeader::MOST_BYTES).read_to_end(&mut first)?;
            ensure!(
                !self.is_spare || PartHeader::read(&first).err() != Some(PartError::NotAPart),
                "there is another file of that name"
            );
            file.set_len(0)?;
            file.seek(SeekFrom::Start(0))?;
            file.write_all(&self.header.to_bytes())?;
            let record = |&tile: &usize| self.header.record(tile, &pixels_of(tile));
            tiles.iter().try_for_each(|tile| file.write_all(&record(tile)))?;
            Ok(file)
        };
        begin().with_context(|| format!("cannot write '{}'", self.path.display()))
    }

    /// Keeps a finished tile.
    ///
    /// # Errors
    /// It cannot be written. That is said once; after it no tile is kept.
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
                    if self.is_spare {
                        // The picture may need its room.
                        let _ = std::fs::remove_file(&self.path);
                    }
                })
            }
            State::Failed => Ok(()),
        }
    }

    /// Begins it with the tiles that there are, unless it is begun; `pixels_of` knows those that were added.
    ///
    /// # Errors
    /// It cannot be written; then no tile is kept.
    pub(crate) fn begin_late(&self, pixels_of: &dyn Fn(usize) -> Film) -> Result<()> {
        // Before the lock: those who have tiles would wait for it.
        LazyLock::force(&self.header);
        let mut state = self.state();
        let State::Waiting(tiles) = &*state else { return Ok(()) };
        let begun = self.begin(tiles, pixels_of);
        let (next, result) = match begun {
            Ok(file) => (State::Open(file), Ok(())),
            Err(error) => (State::Failed, Err(error)),
        };
        *state = next;
        result
    }

    /// Makes sure that there is a file, for the work will not go on. An earlier one is not given up for so few tiles that none was begun.
    ///
    /// # Errors
    /// It cannot be written.
    pub(crate) fn keep(&self, pixels_of: &dyn Fn(usize) -> Film) -> Result<()> {
        if self.has_older { Ok(()) } else { self.begin_late(pixels_of) }
    }

    /// Whether it is on disk with all tiles that were added.
    pub(crate) fn is_kept(&self) -> bool {
        matches!(&*self.state(), State::Open(_))
    }

    /// Brings the file to the disk.
    ///
    /// # Errors
    /// It cannot be written.
    pub(crate) fn sync(&self) -> Result<()> {
        let State::Open(file) = &*self.state() else { return Ok(()) };
        file.sync_all().with_context(|| format!("cannot write '{}'", self.path.display()))
    }

    /// Takes the file away: the picture is written.
    ///
    /// # Errors
    /// It cannot be removed.
    pub(crate) fn remove(self) -> Result<()> {
        let state = self.state.into_inner().unwrap_or_else(PoisonError::into_inner);
        let State::Open(file) = state else { return Ok(()) };
        // Not every system removes a file that is open.
        drop(file);
        std::fs::remove_file(&self.path).with_context(|| format!("cannot remove '{}'", self.path.display()))
    }
}

/// Keeps others from writing into the same file.
fn lock(file: &File) -> Result<()> {
    match file.try_lock() {
        Err(TryLockError::WouldBlock) => bail!("another superegg is writing it"),
        // Not every file system has locks.
        _ => Ok(()),
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
    fn a_part_is_begun_when_it_is_needed_and_goes_with_its_picture() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.part");
        let part = PartFile::later(path.clone(), true, || header(1));
        part.add(1, &pixels()).unwrap();
        assert!(!path.exists() && !part.is_kept());
        part.keep(&|_| pixels()).unwrap();
        part.add(1, &pixels()).unwrap();
        assert!(part.is_kept());
        let found = read(&path).unwrap();
        assert_eq!((found.tiles, found.damaged), (vec![(1, pixels())], 0));
        let other = PartFile::later(path.clone(), true, || header(1));
        assert!(other.try_resume().is_err_and(|error| error.to_string().contains("another superegg")));
        part.remove().unwrap();
        assert!(!path.exists() && other.try_resume().unwrap().is_none());
    }

    #[test]
    fn an_older_part_is_not_given_up_for_a_moment_of_work() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.part");
        std::fs::write(&path, header(2).to_bytes()).unwrap();
        let part = PartFile::later(path.clone(), true, || header(1));
        part.add(1, &pixels()).unwrap();
        part.keep(&|_| pixels()).unwrap();
        assert!(part.has_older() && !part.is_kept());
        part.remove().unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), header(2).to_bytes());
    }

    #[test]
    fn a_file_that_is_something_else_is_left() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.part");
        std::fs::write(&path, "notes").unwrap();
        let part = PartFile::later(path.clone(), true, || header(1));
        assert!(part.begin_now().is_err() && part.resume().is_err());
        part.add(1, &pixels()).unwrap();
        assert!(format!("{:#}", part.keep(&|_| pixels()).unwrap_err()).contains("another file of that name"));
        assert_eq!(std::fs::read(&path).unwrap(), b"notes");
        // What the user named is written, as any output is.
        PartFile::later(path.clone(), false, || header(1)).begin_now().unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), header(1).to_bytes());
    }

    #[test]
    fn endless_files_are_not_read_on() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.part");
        let mut bytes = header(1).to_bytes();
        bytes.resize(header(1).most_bytes() as usize * 2 + PartHeader::MOST_BYTES as usize, 0);
        std::fs::write(&path, bytes).unwrap();
        assert!(format!("{:#}", read(&path).err().unwrap()).contains("longer than its picture"));
    }
}
