//! Reads whole files up to a maximum length, and writes files completely or not at all.

use std::fs::File;
use std::io::{self, BufWriter, Read, Write};
use std::path::Path;

use anyhow::{Context, Result, bail};

use crate::files::temporary::{TemporaryFile, folder_of, remove_leftovers};

/// The maximum input length in bytes. It also stops the reading of an endless stream.
const MOST_BYTES: u64 = 1 << 28;

/// Whether a path is `-`: standard input or output.
pub(crate) fn is_standard_stream(path: &Path) -> bool {
    path == Path::new("-")
}

/// Reads a file, or standard input for `-`.
///
/// # Errors
/// The file is unreadable, a folder, a device, a pipe or too long, or it changed during the read.
pub(crate) fn read(path: &Path) -> Result<Vec<u8>> {
    let cannot_read = || format!("cannot read '{}'", path.display());
    if is_standard_stream(path) {
        return read_limited(io::stdin().lock()).with_context(cannot_read);
    }
    check_plain_file(path)?;
    read_file(path).with_context(cannot_read)
}

fn read_file(path: &Path) -> io::Result<Vec<u8>> {
    let mut file = File::open(path)?;
    let before = file.metadata()?;
    if before.is_dir() {
        return Err(io::Error::new(io::ErrorKind::IsADirectory, "it is a folder"));
    }
    if before.len() > MOST_BYTES {
        return Err(too_long());
    }
    let bytes = read_limited(&mut file)?;
    // Some file systems do not know the length of a file before it is read.
    let is_changed = before.len() > 0
        && (bytes.len() as u64 != before.len() || file.metadata()?.modified().ok() != before.modified().ok());
    if is_changed {
        return Err(io::Error::other("it changed while it was read; try again"));
    }
    Ok(bytes)
}

/// Whether a file is readable and begins with these bytes.
pub(crate) fn begins_with(path: &Path, signature: &[u8]) -> bool {
    let mut first = Vec::new();
    let mut read = || File::open(path)?.take(signature.len() as u64).read_to_end(&mut first);
    check_plain_file(path).is_ok() && read().is_ok() && first == signature
}

/// Rejects a device or a pipe, on which a read can block or never end, and files that the system
/// makes up as they are read. A link to a file is a file.
pub(crate) fn check_plain_file(path: &Path) -> Result<()> {
    /// The folders of such files.
    const MADE_UP: [&str; 2] = ["/proc", "/sys"];
    let cannot_read = || format!("cannot read '{}'", path.display());
    let metadata = path.metadata().with_context(cannot_read)?;
    if metadata.is_dir() {
        return Ok(());
    }
    if !metadata.is_file() {
        bail!("{}: it is a device or a pipe, not a file; - reads standard input", cannot_read());
    }
    let is_made_up =
        |canonical: &Path| cfg!(unix) && MADE_UP.iter().any(|folder| canonical.starts_with(folder));
    if is_made_up(&path.canonicalize().with_context(cannot_read)?) {
        bail!("{}: it is a file of the operating system, not one on a disk", cannot_read());
    }
    Ok(())
}

/// Rejects a path that cannot be created or written, before the work for it starts.
pub(crate) fn check_creatable(path: &Path) -> Result<()> {
    let cannot_write = || format!("cannot write '{}'", path.display());
    if path.exists() && !path.is_file() {
        return File::options().append(true).open(path).map(drop).with_context(cannot_write);
    }
    // `write` also creates a temporary file beside the target.
    TemporaryFile::beside(path).map(drop).with_context(cannot_write)
}

/// Rejects a link to nothing: a write would create a file at a place that the user does not see.
pub(crate) fn check_link(path: &Path) -> Result<()> {
    if path.is_symlink() && !path.exists() {
        let target = path.read_link().unwrap_or_default();
        bail!(
            "cannot write '{}': it is a link to '{}', which does not exist; remove the link",
            path.display(),
            target.display()
        );
    }
    Ok(())
}

/// Rejects a pipe, a socket or a disk, on which a write can block.
pub(crate) fn check_not_pipe(path: &Path) -> Result<()> {
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
    source.take(MOST_BYTES + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > MOST_BYTES {
        return Err(too_long());
    }
    Ok(bytes)
}

fn too_long() -> io::Error {
    io::Error::new(io::ErrorKind::FileTooLarge, "it is longer than 256 MiB")
}

/// Whether an output may replace a file that is protected against it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Overwrite {
    /// Only files that may be written.
    Writable,
    /// Also read-only files, and files of another maker.
    Any,
}

/// Rejects an output that is a folder, lies in no folder, is the `input`, is read-only or a link to
/// nothing, before the work for it starts. Removes the temporary files that killed commands left in
/// its folder.
pub(crate) fn check_output(path: Option<&Path>, input: &Path, overwrite: Overwrite) -> Result<()> {
    let Some(path) = path.filter(|path| !is_standard_stream(path)) else { return Ok(()) };
    check_target(path, overwrite)?;
    if path.is_file() && path.canonicalize().ok() == input.canonicalize().ok() {
        bail!("'{}' is the scene itself; name another file with -o", path.display());
    }
    remove_leftovers(folder_of(path));
    Ok(())
}

/// Rejects an output that is a folder, lies in no folder, is read-only or a link to nothing.
pub(crate) fn check_target(path: &Path, overwrite: Overwrite) -> Result<()> {
    if path.is_dir() {
        bail!("cannot write '{}': it is a folder", path.display());
    }
    let folder = folder_of(path);
    if !folder.is_dir() {
        bail!("cannot write '{}': there is no folder '{}'", path.display(), folder.display());
    }
    check_link(path)?;
    let is_read_only = || path.is_file() && path.metadata().is_ok_and(|file| file.permissions().readonly());
    if overwrite == Overwrite::Writable && is_read_only() {
        bail!("cannot write '{}': it is read-only; --force replaces it", path.display());
    }
    Ok(())
}

/// Writes a file completely or not at all: the old file stays until the new one is complete, and
/// after a failure. `-` is standard output. Devices and pipes cannot be replaced, so they are written
/// directly.
pub(crate) fn write(path: &Path, bytes: &[u8]) -> Result<()> {
    write_with(path, |output| output.write_all(bytes))
}

/// As [`write()`], of what a function writes.
pub(crate) fn write_with(path: &Path, write: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> Result<()> {
    let cannot_write = || format!("cannot write '{}'", path.display());
    if is_standard_stream(path) {
        let mut output = io::stdout().lock();
        return write(&mut output).and_then(|()| output.flush()).with_context(cannot_write);
    }
    check_link(path)?;
    let written = if path.exists() && !path.is_file() {
        File::options().write(true).open(path).and_then(|mut file| write(&mut file))
    } else {
        replace(path, write)
    };
    written.with_context(cannot_write)
}

fn replace(path: &Path, write: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> io::Result<()> {
    let mut output = BufWriter::with_capacity(1 << 18, TemporaryFile::beside(path)?);
    write(&mut output)?;
    output.flush()?;
    output.into_inner().map_err(io::IntoInnerError::into_error)?.commit()
}
