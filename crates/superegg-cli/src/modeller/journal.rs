//! The autosave journal: every change of the scene, written as it happens, so that a crash loses
//! nothing.
//!
//! A journal is text: a first line with the format and the folder from which the names of files are seen, then records.
//! There are four kinds:
//!
//! - `> ` and a command as it was typed;
//! - `= `, a number of bytes and a label, then that many bytes of commands that define a whole
//!   scene;
//! - `+ `, likewise, with commands that were carried out as one change;
//! - `.`: everything before it is saved.
//!
//! A record without its final line break was cut by a crash and is ignored. A journal without a
//! lock belongs to a session that did not end normally.

use std::fs::{self, File, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread::JoinHandle;
use std::time::SystemTime;

use crate::text::counted;

/// The begin of the first line, before the folder.
const SIGNATURE: &str = "# superegg journal 2 ";
/// The first line of journals without a folder.
const OLD_FIRST_LINE: &str = "# superegg journal 1\n";

/// The first line of a journal of a session that began in this folder.
fn first_line(folder: &Path) -> String {
    match folder.to_str().filter(|folder| !folder.contains('\n')) {
        Some(folder) => format!("{SIGNATURE}{folder}\n"),
        None => OLD_FIRST_LINE.to_owned(),
    }
}

/// The folder of a journal, empty if it has none, and its records; `None` if the text is not a journal.
fn split_first_line(text: &str) -> Option<(&Path, &str)> {
    match text.strip_prefix(SIGNATURE) {
        Some(rest) => rest.split_once('\n').map(|(folder, records)| (Path::new(folder), records)),
        None => text.strip_prefix(OLD_FIRST_LINE).map(|records| (Path::new(""), records)),
    }
}

/// A record of the journal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Record<'a> {
    /// A line that changed the scene.
    Line(&'a str),
    /// A scene that replaced the previous one, as the lines that define it.
    Scene { label: &'a str, lines: &'a str },
    /// Lines that were carried out as one change.
    Lines { label: &'a str, lines: &'a str },
    /// Every change before it is saved.
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
            Self::Lines { label, lines } => {
                writeln!(to, "+ {} {}\n{lines}", lines.len(), label.replace('\n', " "))
            }
            Self::Saved => writeln!(to, "."),
        };
    }
}

/// The complete records of a journal; `None` if the text is not a journal.
pub(crate) fn read_records(text: &str) -> Option<Vec<Record<'_>>> {
    let (_, mut rest) = split_first_line(text)?;
    let mut records = Vec::new();
    while let Some((line, after)) = rest.split_once('\n') {
        rest = after;
        if let Some(line) = line.strip_prefix("> ") {
            records.push(Record::Line(line));
        } else if line == "." {
            records.push(Record::Saved);
        } else if let Some((bytes, label)) =
            line.strip_prefix(['=', '+']).and_then(|line| line.strip_prefix(' ')?.split_once(' '))
        {
            let whole =
                bytes.parse().ok().and_then(|bytes: usize| Some((rest.get(..bytes)?, rest.get(bytes..)?)));
            let Some((lines, after)) =
                whole.and_then(|(lines, after)| Some((lines, after.strip_prefix('\n')?)))
            else {
                break;
            };
            records.push(if line.starts_with('=') {
                Record::Scene { label, lines }
            } else {
                Record::Lines { label, lines }
            });
            rest = after;
        } else {
            break;
        }
    }
    Some(records)
}

/// The journal of a running session. The first record creates its file.
pub(crate) struct Journal {
    folder: Option<PathBuf>,
    open: Option<Open>,
    /// Bytes that are not written yet.
    unwritten: Vec<u8>,
    /// Whether there are no records yet.
    is_empty: bool,
    /// Whether the user knows that the journal cannot be written.
    is_reported: bool,
}

/// The file of a journal, locked.
struct Open {
    path: PathBuf,
    file: File,
    /// The length of the complete records in bytes.
    length: u64,
    /// Wakes the thread that syncs the file to the disk.
    sync: Sender<()>,
    syncing: JoinHandle<()>,
}

impl Journal {
    /// A journal in a folder, of a session that began in the folder `of_session`. Without a folder nothing is recorded.
    pub(crate) fn new(folder: Option<PathBuf>, of_session: &Path) -> Self {
        let unwritten = first_line(of_session).into();
        Self { folder, open: None, unwritten, is_empty: true, is_reported: false }
    }

    /// Writes a record. Returns a message for the user on the first failure, and on the first
    /// success after it. A record that fails is written with the next one.
    pub(crate) fn append(&mut self, record: Record<'_>) -> Option<String> {
        self.folder.as_ref()?;
        record.write(&mut self.unwritten);
        self.is_empty = false;
        self.write_unwritten()
    }

    fn write_unwritten(&mut self) -> Option<String> {
        match self.flush() {
            Ok(()) => {
                let has_recovered = std::mem::take(&mut self.is_reported);
                has_recovered.then(|| "the autosave works again".to_owned())
            }
            Err(error) => {
                let is_new = !std::mem::replace(&mut self.is_reported, true);
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
        if let Err(error) = open.file.write_all(&self.unwritten) {
            // An incomplete record would hide the records after it.
            open.file.set_len(open.length)?;
            io::Seek::seek(&mut open.file, io::SeekFrom::Start(open.length))?;
            return Err(error);
        }
        open.length += self.unwritten.len() as u64;
        self.unwritten.clear();
        // The thread runs until the journal is closed.
        let _ = open.sync.send(());
        Ok(())
    }

    /// Whether there are no records yet.
    pub(crate) fn is_empty(&self) -> bool {
        self.is_empty
    }

    /// Continues from the records of another session. This journal must be empty.
    pub(crate) fn take_over(&mut self, text: &str) -> Option<String> {
        self.unwritten = text.as_bytes().into();
        self.is_empty = false;
        self.write_unwritten()
    }

    /// Whether the file has every record.
    pub(crate) fn is_written(&self) -> bool {
        self.open.is_some() && self.unwritten.is_empty()
    }

    /// Closes the journal and keeps its file for the next start.
    pub(crate) fn keep(&mut self) {
        self.open.take().map(Open::close);
    }

    /// Closes the journal and removes its file.
    pub(crate) fn discard(&mut self) {
        if let Some(path) = self.open.take().map(Open::close) {
            // A file that cannot be removed is offered at the next start.
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
        // Without file locks, sessions that run at the same time can be offered to each other.
        let _ = file.try_lock();
        let (sync, wake) = channel();
        let same = file.try_clone()?;
        let syncing = std::thread::spawn(move || sync_when_woken(&same, &wake));
        Ok(Self { path, file, length: 0, sync, syncing })
    }

    /// Waits until the file is on the disk and releases the lock. Returns the path.
    fn close(self) -> PathBuf {
        drop(self.sync);
        // The thread does not panic.
        let _ = self.syncing.join();
        self.path
    }
}

/// Syncs the file after each record. Records that arrive during a sync share the next one.
fn sync_when_woken(file: &File, wake: &Receiver<()>) {
    while wake.recv().is_ok() {
        while wake.try_recv().is_ok() {}
        // The system has the bytes; the next write reports a disk error.
        let _ = file.sync_data();
    }
}

/// A session that ended without a save, and its journal.
#[derive(Debug)]
pub(crate) struct UnsavedSession {
    path: PathBuf,
    /// Held so that no other session recovers it.
    _lock: File,
    pub(crate) text: String,
    modified: Option<SystemTime>,
}

impl UnsavedSession {
    /// The folder from which the names of files are seen; empty if it is not known.
    pub(crate) fn folder(&self) -> &Path {
        split_first_line(&self.text).map_or(Path::new(""), |(folder, _)| folder)
    }

    /// Describes the number of changes, the age and the last change.
    pub(crate) fn describe(&self) -> String {
        let age = self.modified.and_then(|at| SystemTime::now().duration_since(at).ok());
        let when = match age.map_or(0, |age| age.as_secs()) {
            0..60 => "just now".to_owned(),
            seconds @ 60..3600 => format!("{} min ago", seconds / 60),
            seconds @ 3600..86_400 => format!("{} h ago", seconds / 3600),
            seconds => format!("{} days ago", seconds / 86_400),
        };
        let last = self.last_change().map(|line| format!(", the last: {line}")).unwrap_or_default();
        format!("{}, {when}{last}", counted(self.change_count(), "change"))
    }

    /// The number of changes.
    fn change_count(&self) -> usize {
        let records = read_records(&self.text).unwrap_or_default();
        records.iter().filter(|record| **record != Record::Saved).count()
    }

    /// The last line that changed something, or the label of a whole scene.
    fn last_change(&self) -> Option<&str> {
        match read_records(&self.text)?.into_iter().rfind(|record| *record != Record::Saved)? {
            Record::Line(line) => Some(line),
            Record::Scene { label, .. } | Record::Lines { label, .. } => Some(label),
            Record::Saved => None,
        }
    }

    /// Removes the journal.
    pub(crate) fn remove(self) {
        // A file that cannot be removed is offered again.
        let _ = fs::remove_file(self.path);
    }
}

/// The sessions with unsaved changes, newest first. Skips the journals of running sessions and
/// removes the journals without unsaved changes.
pub(crate) fn unsaved_sessions(folder: &Path) -> Vec<UnsavedSession> {
    let Ok(entries) = fs::read_dir(folder) else { return Vec::new() };
    let mut found = Vec::new();
    for path in entries.flatten().map(|entry| entry.path()) {
        if path.extension().is_none_or(|extension| extension != "journal") || !path.is_file() {
            continue;
        }
        let Ok(lock) = File::open(&path) else { continue };
        if lock.try_lock().is_err() {
            continue;
        }
        // A crash can cut within a character.
        let Ok(bytes) = fs::read(&path) else { continue };
        let text = String::from_utf8_lossy(&bytes).into_owned();
        let Some(records) = read_records(&text) else { continue };
        if records.last().is_none_or(|last| *last == Record::Saved) {
            let _ = fs::remove_file(&path);
            continue;
        }
        let modified = lock.metadata().and_then(|metadata| metadata.modified()).ok();
        found.push(UnsavedSession { path, _lock: lock, text, modified });
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
            Record::Lines { label: "include b.scn", lines: "prm c\n" },
            Record::Line("undo"),
        ];
        let first_line = first_line(Path::new("/a b"));
        let mut bytes = first_line.as_bytes().to_vec();
        let mut ends = Vec::new();
        for record in records {
            record.write(&mut bytes);
            ends.push(bytes.len());
        }
        for cut in first_line.len()..=bytes.len() {
            let whole = ends.iter().filter(|end| **end <= cut).count();
            let text = String::from_utf8_lossy(&bytes[..cut]);
            assert_eq!(read_records(&text).unwrap(), records[..whole], "cut at {cut}");
        }
        assert!(read_records("prm a\n").is_none());
        assert_eq!(read_records("# superegg journal 1\n> undo\n").unwrap(), [Record::Line("undo")]);
    }

    #[test]
    fn unsaved_sessions_are_found_and_running_or_saved_ones_are_not() {
        let folder = tempfile::tempdir().unwrap();
        let journal = || Journal::new(Some(folder.path().to_owned()), Path::new("/a b"));
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
        let found = unsaved_sessions(folder.path());
        assert_eq!(found.len(), 1);
        assert_eq!(
            (found[0].text.as_str(), found[0].change_count()),
            ("# superegg journal 2 /a b\n> prm left\n> prm more\n", 2)
        );
        assert_eq!(found[0].folder(), Path::new("/a b"));
        assert!(unsaved_sessions(folder.path()).is_empty(), "it is locked");
        found.into_iter().for_each(UnsavedSession::remove);
        running.discard();
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
    }

    #[test]
    fn a_failed_write_is_reported_once_and_repeated_later() {
        let parent = tempfile::tempdir().unwrap();
        let folder = parent.path().join("journals");
        fs::write(&folder, "a file in the way").unwrap();
        let mut journal = Journal::new(Some(folder.clone()), Path::new(""));
        assert!(journal.append(Record::Line("prm a")).unwrap().contains("cannot be written"));
        assert_eq!(journal.append(Record::Line("prm b")), None);
        fs::remove_file(&folder).unwrap();
        assert!(journal.append(Record::Line("prm c")).unwrap().contains("works again"));
        journal.keep();
        assert_eq!(unsaved_sessions(&folder)[0].change_count(), 3);
    }
}
