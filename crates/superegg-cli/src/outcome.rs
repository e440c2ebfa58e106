//! How a command ends, and the exit codes.

/// The exit code of success.
pub(crate) const EXIT_FINE: u8 = 0;
/// The exit code of errors in the input.
pub(crate) const EXIT_ERRORS: u8 = 1;
/// The exit code of wrong usage, and of files that cannot be read or written.
pub(crate) const EXIT_USAGE: u8 = 2;

/// How a command ended, unless it failed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Outcome {
    /// The command succeeded.
    Fine,
    /// The input had errors, which have been reported.
    ErrorsInInput,
    /// A signal stopped the command; the exit code.
    Stopped(u8),
}

impl Outcome {
    /// The outcome of a command that did its work on input that may have errors.
    pub(crate) fn of_input(has_errors: bool) -> Self {
        if has_errors { Self::ErrorsInInput } else { Self::Fine }
    }
}
