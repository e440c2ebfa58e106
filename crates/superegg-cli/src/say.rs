//! Printing that neither panics nor stops the work.

use std::fmt::Display;
use std::io::{self, Write};

use anyhow::{Context, Result};

/// A line on standard output.
///
/// # Errors
/// It cannot be written: the pipe is closed, the disk full.
pub(crate) fn out(text: impl Display) -> Result<()> {
    writeln!(io::stdout().lock(), "{text}").context("cannot write to standard output")
}

/// A line on standard error. Where that cannot be written there is nowhere to say so.
pub(crate) fn complain(text: impl Display) {
    let _ = writeln!(io::stderr().lock(), "{text}");
}
