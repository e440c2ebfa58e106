//! A frame of a file.

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

impl Frame {
    /// The only frame of a file of `end` bytes.
    pub(super) fn whole(end: u64) -> Self {
        Self { step: None, start: 0, end, first_line: 1 }
    }
}
