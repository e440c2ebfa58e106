//! How a session speaks to whoever runs it.

use std::sync::Arc;

use anyhow::Result;
use superegg_lang::is_unseen;

/// What it says. Each is a line or more, without the last line break.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Said {
    /// An answer.
    Text(String),
    /// What is wrong with a line or file.
    Complaint(String),
    /// How far work behind the prompt is; the next one may take the place of it.
    Progress(String),
    /// Work behind the prompt is done.
    Done(String),
    /// Work behind the prompt went wrong.
    Failed(String),
}

/// Says it, from any thread.
///
/// # Errors
/// Nobody can hear it any more.
pub(crate) type Voice = Arc<dyn Fn(Said) -> Result<()> + Send + Sync>;

/// Text with characters that are not seen, but for line breaks and tabs, as escapes, so that no name can steer a terminal.
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
