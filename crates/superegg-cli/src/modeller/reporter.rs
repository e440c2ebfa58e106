//! Messages from a session to its user.

use std::sync::Arc;

use anyhow::Result;

use crate::console;

/// A message of one or more lines, without the final line break.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Message {
    /// The result of a command.
    Text(String),
    /// A text to read, which may be longer than the screen.
    Page(String),
    /// An error or warning about a line or a file.
    Diagnostic(String),
    /// Progress of background work. It replaces the previous progress message.
    Progress(String),
    /// Background work is complete.
    Done(String),
    /// Background work has failed.
    Failed(String),
}

/// Delivers a message; callable from any thread.
///
/// # Errors
/// The output is closed.
pub(crate) type Reporter = Arc<dyn Fn(Message) -> Result<()> + Send + Sync>;

/// A reporter for sessions without a prompt: results go to standard output, diagnostics and
/// failures to standard error, and progress is dropped.
pub(crate) fn console_reporter() -> Reporter {
    Arc::new(|message| {
        match message {
            Message::Progress(_) => {}
            Message::Text(text) | Message::Page(text) => console::print_raw(text)?,
            Message::Done(line) => console::print(line)?,
            Message::Diagnostic(line) => console::warn(line),
            Message::Failed(line) => console::fail(line),
        }
        Ok(())
    })
}
