//! A file opened for reading: its format and its frames.

use std::io::{Read, SeekFrom};

use super::error::ReadError;
use super::format::Format;
use super::options::ReadOptions;
use super::{Import, Input};

/// The number of bytes that decide the format.
const HEAD: u64 = 1 << 16;
/// The largest file of a format that is read as a whole, in bytes.
pub(super) const MOST_BYTES: u64 = 8 << 30;

/// A frame of a file: its step, and where it lies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// The time step or time, if the file says it.
    pub step: Option<f64>,
    /// The first byte.
    pub(super) start: u64,
    /// The byte after the last one.
    pub(super) end: u64,
    /// The number of its first line, counted from 1; 1 for binary files.
    pub(super) first_line: u64,
}

/// A file whose format and frames are known.
#[derive(Debug)]
pub struct Source<R> {
    input: R,
    format: Format,
    frames: Vec<Frame>,
}

/// Recognizes the format of a stream by its content and lists its frames. A format in `options`
/// is taken as it is.
///
/// # Errors
/// The stream cannot be read, no format fits, or several do that mean different things.
pub fn open<R: Input>(mut input: R, options: &ReadOptions) -> Result<Source<R>, ReadError> {
    let mut head = Vec::new();
    input.seek(SeekFrom::Start(0))?;
    input.by_ref().take(HEAD).read_to_end(&mut head)?;
    let format = match options.from {
        Some(format) => format,
        None => recognize(&head, options)?,
    };
    let end = input.seek(SeekFrom::End(0))?;
    let frames = vec![Frame { step: None, start: 0, end, first_line: 1 }];
    Ok(Source { input, format, frames })
}

/// The format of a file with these first bytes.
fn recognize(_head: &[u8], _options: &ReadOptions) -> Result<Format, ReadError> {
    Err(ReadError::Unrecognized)
}

impl<R: Input> Source<R> {
    /// The format.
    pub fn format(&self) -> Format {
        self.format
    }

    /// The frames in their order; at least one.
    pub fn frames(&self) -> &[Frame] {
        &self.frames
    }

    /// Reads one frame.
    ///
    /// # Errors
    /// There is no such frame, the stream cannot be read, or the content is wrong.
    pub fn read(&mut self, frame: usize, _options: &ReadOptions) -> Result<Import, ReadError> {
        let Some(&Frame { start, end, .. }) = self.frames.get(frame) else {
            let message = format!("there is no frame {frame}; the file has {}", self.frames.len());
            return Err(ReadError::File(message));
        };
        if end - start > MOST_BYTES {
            return Err(ReadError::File(format!("the file is larger than {MOST_BYTES} bytes")));
        }
        Err(ReadError::Unrecognized)
    }
}
