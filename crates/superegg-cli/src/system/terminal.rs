//! The abilities of the terminal, by the environment.

/// The values of TERM of terminals that only write one line below the other.
const PLAIN: [&str; 4] = ["", "dumb", "emacs", "cons25"];

/// Whether the terminal moves its cursor and edits lines.
pub(crate) fn has_cursor() -> bool {
    !cfg!(unix) || std::env::var("TERM").is_ok_and(|term| !PLAIN.contains(&term.as_str()))
}
