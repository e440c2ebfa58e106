//! Reads whole files up to a maximum length, and writes files completely or not at all.

use std::fs::File;
use std::io::{self, Read, Write};
use std::path::Path;

use anyhow::{Context, Result, bail};
use atomic_write_file::AtomicWriteFile;

/// The maximum input length in bytes. It also stops the reading of an endless device.
const MOST_BYTES: u64 = 1 << 28;

/// Whether a path is `-`: standard input or output.
pub(crate) fn is_standard_stream(path: &Path) -> bool {
    path == Path::new("-")
}

/// Reads a file, or standard input for `-`.
///
/// # Errors
/// The file is unreadable, a folder or too long, or it changed during the read.
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
    if before.is_file() && before.len() > MOST_BYTES {
        return Err(too_long());
    }
    let bytes = read_limited(&mut file)?;
    // The system generates some files of length 0 when they are read.
    let is_changed = before.is_file()
        && before.len() > 0
        && (bytes.len() as u64 != before.len() || file.metadata()?.modified().ok() != before.modified().ok());
    if is_changed {
        return Err(io::Error::other("it changed while it was read; try again"));
    }
    Ok(bytes)
}

/// Whether a file is readable and begins with these bytes.
pub(crate) fn begins_with(path: &Path, signature: &[u8]) -> bool {
    let mut first = Vec::new();
    let read = File::open(path).and_then(|file| file.take(signature.len() as u64).read_to_end(&mut first));
    read.is_ok() && first == signature
}

/// Rejects a device or a pipe, on which a read can block or never end.
pub(crate) fn check_plain_file(path: &Path) -> Result<()> {
    let metadata = path.metadata().with_context(|| format!("cannot read '{}'", path.display()))?;
    if !metadata.is_file() && !metadata.is_dir() {
        bail!("cannot read '{}': it is a device or a pipe, not a file", path.display());
    }
    Ok(())
}

/// Rejects a path that cannot be created or written, before the work for it starts.
pub(crate) fn check_creatable(path: &Path) -> Result<()> {
    let cannot_write = || format!("cannot write '{}'", path.display());
    match path.metadata() {
        Ok(_) => File::options().append(true).open(path).map(drop).with_context(cannot_write),
        Err(error) if error.kind() == io::ErrorKind::NotFound && !path.is_symlink() => {
            // `write` also creates a temporary file beside the target.
            let beside = folder_of(path).join(format!(".superegg-{}", std::process::id()));
            File::create_new(&beside).and_then(|_| std::fs::remove_file(&beside)).with_context(cannot_write)
        }
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(()),
        Err(error) => Err(error).with_context(cannot_write),
    }
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

/// Rejects an output that is a folder, lies in no folder or is the `input`, before the work for it
/// starts.
pub(crate) fn check_output(path: Option<&Path>, input: &Path) -> Result<()> {
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

/// Writes a file completely or not at all: the old file stays until the new one is complete, and
/// after a failure. `-` is standard output. Devices, pipes and the targets of dangling links cannot
/// be replaced, so they are written directly.
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
    // Replace the target of a link, not the link.
    let target = path.canonicalize().unwrap_or_else(|_| path.to_owned());
    let mut file = AtomicWriteFile::open(target)?;
    file.write_all(bytes)?;
    file.commit()
}
