//! The lines of a stretch of a stream, read block by block.

use std::io::SeekFrom;

use memchr::{memchr, memchr_iter, memmem};

use super::error::ReadError;
use super::import::Input;

/// The number of bytes of a block.
const BLOCK: usize = 1 << 18;
/// The longest line.
const LONGEST: usize = 1 << 20;

/// Reads lines of a stretch of a stream, with their numbers.
pub(super) struct Lines<'a> {
    input: &'a mut dyn Input,
    /// The bytes that are read and not yet given out.
    block: Vec<u8>,
    next: usize,
    /// The position of the block in the stream.
    position: u64,
    end: u64,
    /// The number of the next line.
    line: u64,
}

impl<'a> Lines<'a> {
    /// The lines from `start` to `end`, or to the end of the stream.
    pub(super) fn new(
        input: &'a mut dyn Input,
        start: u64,
        end: u64,
        first_line: u64,
    ) -> Result<Self, ReadError> {
        let length = input.seek(SeekFrom::End(0))?;
        input.seek(SeekFrom::Start(start))?;
        Ok(Self {
            input,
            block: Vec::new(),
            next: 0,
            position: start,
            end: end.min(length),
            line: first_line,
        })
    }

    /// The position of the end.
    pub(super) fn end(&self) -> u64 {
        self.end
    }

    /// The number of the line that was read last.
    pub(super) fn line(&self) -> u64 {
        self.line.saturating_sub(1)
    }

    /// Reads more bytes behind those that are left. Returns false at the end.
    fn fill(&mut self) -> Result<bool, ReadError> {
        self.block.drain(..self.next);
        self.position += self.next as u64;
        self.next = 0;
        let held = self.block.len();
        let left = self.end.saturating_sub(self.position + held as u64);
        if left == 0 {
            return Ok(false);
        }
        let more = left.min(BLOCK as u64) as usize;
        self.block.resize(held + more, 0);
        let read = self.input.read(&mut self.block[held..])?;
        self.block.truncate(held + read);
        if read == 0 {
            self.end = self.position + held as u64;
        }
        Ok(read > 0)
    }

    /// The next line without its end; `None` after the last one.
    pub(super) fn next(&mut self) -> Result<Option<&[u8]>, ReadError> {
        let mut searched = self.next;
        let length = loop {
            if let Some(found) = memchr(b'\n', &self.block[searched..]) {
                break searched + found - self.next + 1;
            }
            let held = self.block.len() - self.next;
            if held > LONGEST {
                return Err(ReadError::line(self.line, "the line is longer than a megabyte"));
            }
            if !self.fill()? {
                if held == 0 {
                    return Ok(None);
                }
                break held;
            }
            searched = self.next + held;
        };
        let line = &self.block[self.next..self.next + length];
        self.next += length;
        self.line += 1;
        let line = line.strip_suffix(b"\n").unwrap_or(line);
        Ok(Some(line.strip_suffix(b"\r").unwrap_or(line)))
    }

    /// Skips lines until one begins with `prefix`, or to the end.
    pub(super) fn skip_to(&mut self, prefix: &[u8]) -> Result<(), ReadError> {
        let finder = memmem::Finder::new(prefix);
        loop {
            let held = &self.block[self.next..];
            let starts = finder.find_iter(held);
            let found = starts.into_iter().find(|&at| match at {
                0 => true,
                _ => held[at - 1] == b'\n',
            });
            // A prefix may lie across two blocks. Without one, all but the last line is skipped.
            let skipped = found.unwrap_or_else(|| memchr::memrchr(b'\n', held).map_or(0, |at| at + 1));
            self.line += memchr_iter(b'\n', &held[..skipped]).count() as u64;
            self.next += skipped;
            if found.is_some() {
                return Ok(());
            }
            if !self.fill()? {
                let rest = &self.block[self.next..];
                if !rest.starts_with(prefix) {
                    self.next = self.block.len();
                }
                return Ok(());
            }
            if self.block.len() - self.next > LONGEST + BLOCK {
                return Err(ReadError::line(self.line, "the line is longer than a megabyte"));
            }
        }
    }

    /// The position and number of the next line if it begins with `prefix`. The line is passed.
    pub(super) fn at_prefix(&mut self, prefix: &[u8]) -> Result<Option<(u64, u64)>, ReadError> {
        let (position, line) = (self.position + self.next as u64, self.line);
        let Some(text) = self.next()? else { return Ok(None) };
        Ok(text.starts_with(prefix).then_some((position, line)))
    }
}
