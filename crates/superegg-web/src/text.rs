//! Lines and columns of a text, as editors in JavaScript count them.

/// The lines of a text, without their ends.
pub(crate) fn lines_of(text: &str) -> impl Iterator<Item = &str> {
    text.split('\n').map(|line| line.strip_suffix('\r').unwrap_or(line))
}

/// The number of UTF-16 units of a text.
pub(crate) fn units(text: &str) -> usize {
    text.chars().map(char::len_utf16).sum()
}

/// The number of UTF-16 units of the first characters of a text.
pub(crate) fn units_of(text: &str, characters: usize) -> usize {
    text.chars().take(characters).map(char::len_utf16).sum()
}
