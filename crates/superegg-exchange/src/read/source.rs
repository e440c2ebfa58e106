//! A file opened for reading: its format and its frames.

use std::io::{Read, SeekFrom};

use super::error::ReadError;
use super::format::Format;
use super::options::ReadOptions;
use super::{Import, Input, dump};

/// The number of bytes that decide the format.
const HEAD: u64 = 1 << 16;
/// The largest file of a format that is read as a whole, in bytes.
const MOST_BYTES: u64 = 8 << 30;

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
///
/// ```
/// use std::io::Cursor;
/// use superegg_exchange::read::{Content, Format, ReadOptions, open};
///
/// let dump = "ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n1\nITEM: BOX BOUNDS ff ff ff\n-1 1\n-1 1\n-1 1\n\
///             ITEM: ATOMS id x y z shapex shapey shapez quat1 quat2 quat3 quat4 blockiness1 blockiness2\n\
///             7 0 0 0 .1 .2 .3 1 0 0 0 8 2\n";
/// let options = ReadOptions::default();
/// let mut source = open(Cursor::new(dump), &options)?;
/// assert_eq!((source.format(), source.frames().len()), (Format::LiggghtsDump, 1));
/// let Content::Particles(grains) = source.read(0, &options)?.content else { panic!() };
/// assert_eq!(grains.exponents, [[1.0, 0.25]]);
/// # Ok::<(), superegg_exchange::read::ReadError>(())
/// ```
pub fn open<R: Input>(mut input: R, options: &ReadOptions) -> Result<Source<R>, ReadError> {
    let mut head = Vec::new();
    input.seek(SeekFrom::Start(0))?;
    input.by_ref().take(HEAD).read_to_end(&mut head)?;
    let format = match options.from {
        Some(format) => format,
        None => recognize(&head, options)?,
    };
    let frames = match format {
        Format::LiggghtsDump | Format::LammpsDump | Format::OvitoDump => dump::frames(&mut input)?,
        _ => {
            let end = input.seek(SeekFrom::End(0))?;
            vec![Frame { step: None, start: 0, end, first_line: 1 }]
        }
    };
    Ok(Source { input, format, frames })
}

/// The format of a file with these first bytes, if it is one of another program; also where the
/// meaning of its numbers is in doubt.
pub fn sniff(head: &[u8]) -> Option<Format> {
    match recognize(head, &ReadOptions::default()) {
        Ok(format) => Some(format),
        Err(ReadError::Ambiguous { candidates, .. }) => {
            candidates.first().and_then(|name| Format::by_name(name))
        }
        Err(_) => None,
    }
}

/// The format of a file with these first bytes.
fn recognize(head: &[u8], _options: &ReadOptions) -> Result<Format, ReadError> {
    if let Some(format) = dump::recognize(head) {
        return format;
    }
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
    pub fn read(&mut self, frame: usize, options: &ReadOptions) -> Result<Import, ReadError> {
        let Some(frame) = self.frames.get(frame) else {
            let message = format!("there is no frame {frame}; the file has {}", self.frames.len());
            return Err(ReadError::File(message));
        };
        match self.format {
            Format::LiggghtsDump | Format::LammpsDump | Format::OvitoDump => {
                dump::read(&mut self.input, frame, self.format, options)
            }
            _ => {
                let _bytes = self.bytes()?;
                Err(ReadError::Unrecognized)
            }
        }
    }

    /// The whole file.
    fn bytes(&mut self) -> Result<Vec<u8>, ReadError> {
        let length = self.input.seek(SeekFrom::End(0))?;
        if length > MOST_BYTES {
            return Err(ReadError::File(format!("the file is larger than {MOST_BYTES} bytes")));
        }
        self.input.seek(SeekFrom::Start(0))?;
        let mut bytes = Vec::with_capacity(length as usize);
        self.input.by_ref().take(MOST_BYTES).read_to_end(&mut bytes)?;
        Ok(bytes)
    }
}
