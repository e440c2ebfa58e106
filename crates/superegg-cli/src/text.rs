//! Words of messages.

use std::fmt::Display;

/// A count with its noun: "1 error", "2 errors".
pub(crate) fn counted(count: impl Display, noun: &str) -> String {
    let count = count.to_string();
    let plural = if count == "1" { "" } else { "s" };
    format!("{count} {noun}{plural}")
}
