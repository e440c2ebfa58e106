//! Messages from a session to its user.

use std::sync::Arc;

use anyhow::Result;
use superegg_lang::is_unseen;

use crate::console;

/// A message of one or more lines, without the final line break.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Message {
    /// The result of a command.
    Text(String),
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
            Message::Text(line) => console::print(line)?,
            Message::Done(line) => console::print(visible(&line))?,
            Message::Diagnostic(line) => console::warn(line),
            Message::Failed(line) => console::warn(visible(&format!("superegg: {line}"))),
        }
        Ok(())
    })
}

/// Escapes invisible characters except line breaks and tabs, so that no name can control the
/// terminal.
pub(crate) fn visible(text: &str) -> String {
    let mut shown = String::with_capacity(text.len());
    for c in text.chars() {
        if is_unseen(c) && c != '\n' && c != '\t' {
            shown.extend(c.escape_unicode());
        } else {
            shown.push(c);
        }
    }
    shown
}
