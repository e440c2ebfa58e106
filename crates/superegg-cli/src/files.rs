//! Files: read whole within a limit, written whole or not at all.

use std::fs::File;
use std::io::{self, Read, Write};
use std::path::Path;

use anyhow::{Context, Result, bail};
use atomic_write_file::AtomicWriteFile;

/// No scene or list of rays is larger; a device that never ends is not read on.
const LONGEST_INPUT: u64 = 1 << 28;

/// The name that stands for standard input or output.
pub(crate) fn is_standard_stream(path: &Path) -> bool {
    path == Path::new("-")
}

/// The bytes of a file, or of standard input for `-`.
pub(crate) fn read(path: &Path) -> Result<Vec<u8>> {
    let bytes = if is_standard_stream(path) { read_limited(io::stdin().lock()) } else { read_file(path) };
    bytes.with_context(|| format!("cannot read '{}'", path.display()))
}

fn read_file(path: &Path) -> io::Result<Vec<u8>> {
    let mut file = File::open(path)?;
    let before = file.metadata()?;
    if before.is_dir() {
        return Err(io::Error::new(io::ErrorKind::IsADirectory, "it is a folder"));
    }
    if before.is_file() && before.len() > LONGEST_INPUT {
        return Err(too_long());
    }
    let bytes = read_limited(&mut file)?;
    // A file of no length may be one that the system makes as it is read.
    let is_changed = before.is_file()
        && before.len() > 0
        && (bytes.len() as u64 != before.len() || file.metadata()?.modified().ok() != before.modified().ok());
    if is_changed {
        return Err(io::Error::other("it changed while it was read; try again"));
    }
    Ok(bytes)
}

/// Whether a file can be read and begins with these bytes.
pub(crate) fn begins_with(path: &Path, mark: &[u8]) -> bool {
    let mut first = Vec::new();
    let read = File::open(path).and_then(|file| file.take(mark.len() as u64).read_to_end(&mut first));
    read.is_ok() && first == mark
}

/// Refuses what would make a session wait, or read for ever: it takes plain files only.
pub(crate) fn check_plain(path: &Path) -> Result<()> {
    let metadata = path.metadata().with_context(|| format!("cannot read '{}'", path.display()))?;
    if !metadata.is_file() && !metadata.is_dir() {
        bail!("cannot read '{}': it is a device or a pipe, not a file", path.display());
    }
    Ok(())
}

/// Refuses a name that no file can have, and a file or folder that cannot be written, before the work for it is done.
pub(crate) fn check_can_be_made(path: &Path) -> Result<()> {
    let cannot = || format!("cannot write '{}'", path.display());
    match path.metadata() {
        Ok(_) => File::options().append(true).open(path).map(drop).with_context(cannot),
        Err(error) if error.kind() == io::ErrorKind::NotFound && !path.is_symlink() => {
            // The library that writes files begins with one beside it, too.
            let beside = folder_of(path).join(format!(".superegg-{}", std::process::id()));
            File::create_new(&beside).and_then(|_| std::fs::remove_file(&beside)).with_context(cannot)
        }
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(()),
        Err(error) => Err(error).with_context(cannot),
    }
}

/// Refuses what would make a session wait for a reader.
pub(crate) fn check_no_pipe(path: &Path) -> Result<()> {
    #[cfg(unix)]
    if let Ok(metadata) = path.metadata() {
        use std::os::unix::fs::FileTypeExt;
        let kind = metadata.file_type();
        if kind.is_fifo() || kind.is_socket() || kind.is_block_device() {
            bail!("cannot write '{}': it is a pipe, a socket or a disk", path.display());
        }
    }
    Ok(())
}

fn read_limited(source: impl Read) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    source.take(LONGEST_INPUT + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > LONGEST_INPUT {
        return Err(too_long());
    }
    Ok(bytes)
}

fn too_long() -> io::Error {
    io::Error::new(io::ErrorKind::FileTooLarge, "it is longer than 256 MiB")
}

/// Refuses a place where a file cannot be written, or where it would take the place of the `input`, before the work for it is done.
pub(crate) fn check_writable_place(path: Option<&Path>, input: &Path) -> Result<()> {
    let Some(path) = path.filter(|path| !is_standard_stream(path)) else { return Ok(()) };
    if path.is_dir() {
        bail!("cannot write '{}': it is a folder", path.display());
    }
    let folder = folder_of(path);
    if !folder.is_dir() {
        bail!("cannot write '{}': there is no folder '{}'", path.display(), folder.display());
    }
    if path.is_file() && path.canonicalize().ok() == input.canonicalize().ok() {
        bail!("'{}' is the scene itself; name another file with -o", path.display());
    }
    Ok(())
}

fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}

/// Writes a file as a whole: what was there stays until the new file is complete, and after any failure. `-` is standard output; a
/// device, a pipe and what a dangling link names are written straight, for they cannot be replaced.
pub(crate) fn write(path: &Path, bytes: &[u8]) -> Result<()> {
    let is_replaceable = path.is_file() || !(path.exists() || path.is_symlink());
    let written = if is_standard_stream(path) {
        io::stdout().lock().write_all(bytes)
    } else if is_replaceable {
        replace(path, bytes)
    } else {
        File::create(path).and_then(|mut file| file.write_all(bytes))
    };
    written.with_context(|| format!("cannot write '{}'", path.display()))
}

fn replace(path: &Path, bytes: &[u8]) -> io::Result<()> {
    // A link is followed: what it leads to is replaced, not the link.
    let target = path.canonicalize().unwrap_or_else(|_| path.to_owned());
    let mut file = AtomicWriteFile::open(target)?;
    file.write_all(bytes)?;
    file.commit()
}
