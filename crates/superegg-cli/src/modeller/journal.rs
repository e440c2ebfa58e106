//! The autosave journal: what changed the scene, written down as it happens, so that no crash loses it.
//!
//! A journal is text: a first line that says what it is, then records. A record is a line, `> ` and a command as it was typed, or `= `, a count of
//! bytes and a label, followed by so many bytes of commands that make a whole scene (a load), or `.`, which says that all before it is
//! saved. What is not ended by a line break was cut off by the crash, and does not count. A journal that nobody holds a lock on was left by a
//! session that did not end well.

use std::fs::{self, File, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread::JoinHandle;
use std::time::SystemTime;

const FIRST_LINE: &str = "# superegg journal 1\n";

/// What is written down.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Record<'a> {
    /// A line that changed the scene.
    Line(&'a str),
    /// A scene that took the place of the one before, by the lines that make it.
    Scene { label: &'a str, lines: &'a str },
    /// Everything is on disk.
    Saved,
}

impl Record<'_> {
    fn write(self, to: &mut Vec<u8>) {
        // Writing to a Vec cannot fail.
        let _ = match self {
            Self::Line(line) => writeln!(to, "> {}", line.trim()),
            Self::Scene { label, lines } => {
                writeln!(to, "= {} {}\n{lines}", lines.len(), label.replace('\n', " "))
            }
            Self::Saved => writeln!(to, "."),
        };
    }
}

/// The records of a journal, as far as they were written whole. `None` for bytes that are no journal.
pub(crate) fn read_records(text: &str) -> Option<Vec<Record<'_>>> {
    let mut rest = text.strip_prefix(FIRST_LINE)?;
    let mut records = Vec::new();
    while let Some((line, after)) = rest.split_once('\n') {
        rest = after;
        if let Some(line) = line.strip_prefix("> ") {
            records.push(Record::Line(line));
        } else if line == "." {
            records.push(Record::Saved);
        } else if let Some((bytes, label)) = line.strip_prefix("= ").and_then(|line| line.split_once(' ')) {
            let whole =
                bytes.parse().ok().and_then(|bytes: usize| Some((rest.get(..bytes)?, rest.get(bytes..)?)));
            let Some((lines, after)) =
                whole.and_then(|(lines, after)| Some((lines, after.strip_prefix('\n')?)))
            else {
                break;
            };
            records.push(Record::Scene { label, lines });
            rest = after;
        } else {
            break;
        }
    }
    Some(records)
}

/// The journal of a running session. Its file is made with the first record.
pub(crate) struct Journal {
    folder: Option<PathBuf>,
    open: Option<Open>,
    /// What could not be written yet.
    waiting: Vec<u8>,
    /// Whether it was said that it cannot be written.
    is_told: bool,
}

struct Open {
    path: PathBuf,
    file: File,
    /// The bytes that were written whole.
    length: u64,
    /// Wakes the thread that brings the file to the disk.
    sync: Sender<()>,
    syncing: JoinHandle<()>,
}

impl Journal {
    /// A journal in this folder, or none where there is no folder.
    pub(crate) fn new(folder: Option<PathBuf>) -> Self {
        Self { folder, open: None, waiting: FIRST_LINE.into(), is_told: false }
    }

    /// Writes a record down. Returns what to tell the user, once, where that fails; it is tried again with the next record.
    pub(crate) fn append(&mut self, record: Record<'_>) -> Option<String> {
        self.folder.as_ref()?;
        record.write(&mut self.waiting);
        self.write_waiting()
    }

    fn write_waiting(&mut self) -> Option<String> {
        match self.flush() {
            Ok(()) => {
                let worked_again = std::mem::take(&mut self.is_told);
                worked_again.then(|| "the autosave works again".to_owned())
            }
            Err(error) => {
                let is_new = !std::mem::replace(&mut self.is_told, true);
                is_new.then(|| {
                    let folder = self.folder.as_deref().unwrap_or(Path::new("")).display();
                    format!(
                        "the autosave cannot be written in '{folder}': {error}; save the scene to be safe"
                    )
                })
            }
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        if self.open.is_none() {
            self.open = Some(Open::new(self.folder.as_deref().unwrap_or(Path::new("")))?);
        }
        let Some(open) = &mut self.open else { return Ok(()) };
        if let Err(error) = open.file.write_all(&self.waiting) {
            // Half a record would hide those after it.
            open.file.set_len(open.length)?;
            io::Seek::seek(&mut open.file, io::SeekFrom::Start(open.length))?;
            return Err(error);
        }
        open.length += self.waiting.len() as u64;
        self.waiting.clear();
        // The thread lives as long as the journal.
        let _ = open.sync.send(());
        Ok(())
    }

    /// Whether nothing has been written down yet.
    pub(crate) fn is_empty(&self) -> bool {
        self.open.is_none() && self.waiting == FIRST_LINE.as_bytes()
    }

    /// Goes on where another session's journal ended, in place of an empty one.
    pub(crate) fn take_over(&mut self, text: &str) -> Option<String> {
        self.waiting = text.as_bytes().into();
        self.write_waiting()
    }

    /// Whether every record is in the file.
    pub(crate) fn is_written(&self) -> bool {
        self.open.is_some() && self.waiting.is_empty()
    }

    /// Leaves the file for the next start.
    pub(crate) fn keep(&mut self) {
        self.open.take().map(Open::close);
    }

    /// The session ended well: the file goes.
    pub(crate) fn discard(&mut self) {
        if let Some(path) = self.open.take().map(Open::close) {
            // One that stays is offered at the next start.
            let _ = fs::remove_file(path);
        }
    }
}

impl Open {
    fn new(folder: &Path) -> io::Result<Self> {
        fs::create_dir_all(folder)?;
        let start = SystemTime::UNIX_EPOCH.elapsed().map_or(0, |since| since.as_nanos());
        let path = folder.join(format!("{start}-{}.journal", std::process::id()));
        let mut options = OpenOptions::new();
        options.write(true).create_new(true);
        #[cfg(unix)]
        std::os::unix::fs::OpenOptionsExt::mode(&mut options, 0o600);
        let file = options.open(&path)?;
        // Where files cannot be locked, sessions that run at the same time may be offered to each other.
        let _ = file.try_lock();
        let (sync, wake) = channel();
        let same = file.try_clone()?;
        let syncing = std::thread::spawn(move || sync_when_woken(&same, &wake));
        Ok(Self { path, file, length: 0, sync, syncing })
    }

    /// Waits until the file is on the disk, and lets go of it. Returns where it is.
    fn close(self) -> PathBuf {
        drop(self.sync);
        // The thread does not panic.
        let _ = self.syncing.join();
        self.path
    }
}

/// Brings the file to the disk after each record, or after several that came while it was at it.
fn sync_when_woken(file: &File, wake: &Receiver<()>) {
    while wake.recv().is_ok() {
        while wake.try_recv().is_ok() {}
        // The bytes are in the system's hands; a disk that fails is told of at the next write.
        let _ = file.sync_data();
    }
}

/// A journal that a session left.
#[derive(Debug)]
pub(crate) struct LeftBehind {
    path: PathBuf,
    /// Held, so that no other session takes it.
    _lock: File,
    pub(crate) text: String,
    pub(crate) modified: Option<SystemTime>,
}

impl LeftBehind {
    /// How many changes it has.
    pub(crate) fn change_count(&self) -> usize {
        let records = read_records(&self.text).unwrap_or_default();
        records.iter().filter(|record| **record != Record::Saved).count()
    }

    /// The last line that changed something, if it was a line.
    pub(crate) fn last_change(&self) -> Option<&str> {
        match read_records(&self.text)?.into_iter().rfind(|record| *record != Record::Saved)? {
            Record::Line(line) => Some(line),
            Record::Scene { label, .. } => Some(label),
            Record::Saved => None,
        }
    }

    pub(crate) fn remove(self) {
        // One that cannot be removed is offered again, which is well.
        let _ = fs::remove_file(self.path);
    }
}

/// The journals in a folder with changes that were not saved, the newest first. Those of sessions that still run are left out, and those with
/// nothing to lose are cleared away.
pub(crate) fn left_behind(folder: &Path) -> Vec<LeftBehind> {
    let Ok(entries) = fs::read_dir(folder) else { return Vec::new() };
    let mut found = Vec::new();
    for path in entries.flatten().map(|entry| entry.path()) {
        if path.extension().is_none_or(|extension| extension != "journal") {
            continue;
        }
        let Ok(lock) = File::open(&path) else { continue };
        if lock.try_lock().is_err() {
            continue;
        }
        // A crash may have cut a character in two.
        let Ok(bytes) = fs::read(&path) else { continue };
        let text = String::from_utf8_lossy(&bytes).into_owned();
        let Some(records) = read_records(&text) else { continue };
        if records.last().is_none_or(|last| *last == Record::Saved) {
            let _ = fs::remove_file(&path);
            continue;
        }
        let modified = lock.metadata().and_then(|metadata| metadata.modified()).ok();
        found.push(LeftBehind { path, _lock: lock, text, modified });
    }
    found.sort_by(|a, b| (b.modified, &b.path).cmp(&(a.modified, &a.path)));
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_journal_cut_anywhere_is_read_as_far_as_it_goes() {
        let records = [
            Record::Line("prm größe # said"),
            Record::Scene { label: "load a b.scn", lines: "prm a\n> prm b\n.\n" },
            Record::Saved,
            Record::Scene { label: "x", lines: "" },
            Record::Line("undo"),
        ];
        let mut bytes = FIRST_LINE.as_bytes().to_vec();
        let mut ends = Vec::new();
        for record in records {
            record.write(&mut bytes);
            ends.push(bytes.len());
        }
        for cut in FIRST_LINE.len()..=bytes.len() {
            let whole = ends.iter().filter(|end| **end <= cut).count();
            let text = String::from_utf8_lossy(&bytes[..cut]);
            assert_eq!(read_records(&text).unwrap(), records[..whole], "cut at {cut}");
        }
        assert!(read_records("prm a\n").is_none());
    }

    #[test]
    fn what_was_left_is_found_and_what_runs_or_is_saved_is_not() {
        let folder = tempfile::tempdir().unwrap();
        let journal = || Journal::new(Some(folder.path().to_owned()));
        let mut running = journal();
        assert_eq!(running.append(Record::Line("prm running")), None);
        let mut saved = journal();
        saved.append(Record::Line("prm saved"));
        saved.append(Record::Saved);
        saved.keep();
        let mut left = journal();
        left.append(Record::Line("prm left"));
        left.append(Record::Line("prm more"));
        left.keep();
        let found = left_behind(folder.path());
        assert_eq!(found.len(), 1);
        assert_eq!(
            (found[0].text.as_str(), found[0].change_count()),
            ("# superegg journal 1\n> prm left\n> prm more\n", 2)
        );
        assert!(left_behind(folder.path()).is_empty(), "it is held");
        found.into_iter().for_each(LeftBehind::remove);
        running.discard();
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
    }

    #[test]
    fn what_cannot_be_written_is_told_once_and_written_later() {
        let place = tempfile::tempdir().unwrap();
        let folder = place.path().join("journals");
        fs::write(&folder, "a file in the way").unwrap();
        let mut journal = Journal::new(Some(folder.clone()));
        assert!(journal.append(Record::Line("prm a")).unwrap().contains("cannot be written"));
        assert_eq!(journal.append(Record::Line("prm b")), None);
        fs::remove_file(&folder).unwrap();
        assert!(journal.append(Record::Line("prm c")).unwrap().contains("works again"));
        journal.keep();
        assert_eq!(left_behind(&folder)[0].change_count(), 3);
    }
}
