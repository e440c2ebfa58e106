//! Standard output and standard error, without panics.

use std::fmt::Display;
use std::io::{self, Write};

use anyhow::{Context, Result};

/// Prints a line on standard output.
///
/// # Errors
/// Standard output cannot be written: the pipe is closed or the disk is full.
pub(crate) fn print(text: impl Display) -> Result<()> {
    writeln!(io::stdout().lock(), "{text}").context("cannot write to standard output")
}

/// Prints a line on standard error. A failure is ignored: there is no other output to report it on.
pub(crate) fn warn(text: impl Display) {
    let _ = writeln!(io::stderr().lock(), "{text}");
}
