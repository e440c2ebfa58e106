//! Formatting of messages: shortened words, lists, columns.

/// Joins alternatives: "4, 7 or 8".
pub(crate) fn one_of<S: AsRef<str>>(words: &[S]) -> String {
    let words: Vec<&str> = words.iter().map(AsRef::as_ref).collect();
    match &words[..] {
        [] => String::new(),
        [word] => (*word).to_owned(),
        [first @ .., last] => format!("{} or {last}", first.join(", ")),
    }
}

/// A word for a message: at most 40 characters, with invisible ones escaped.
pub(crate) fn shorten(word: &str) -> String {
    const LONGEST: usize = 40;
    let mut shown: String = word.chars().take(LONGEST).flat_map(visible).collect();
    if word.chars().nth(LONGEST).is_some() {
        shown.push_str("...");
    }
    shown
}

fn visible(c: char) -> impl Iterator<Item = char> {
    let escaped = is_unseen(c).then(|| c.escape_unicode());
    let plain = (!is_unseen(c)).then_some(c);
    escaped.into_iter().flatten().chain(plain)
}

/// Whether a character is invisible or can control a terminal: control characters, zero-width ones,
/// and those that change the direction of writing.
pub fn is_unseen(c: char) -> bool {
    c.is_control()
        || matches!(c, '\u{200b}'..='\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2060}'..='\u{2069}' | '\u{feff}')
}

/// Lines are wrapped to fit a terminal of 80 columns.
const WIDTH: usize = 79;
/// The start of the right column.
const RIGHT: usize = 32;

/// Two columns, the right one wrapped. If `left` is too long, `right` starts on the next line.
pub(crate) fn two_columns(left: &str, right: &str) -> String {
    let gap = if left.chars().count() + 2 > RIGHT { "\n" } else { "" };
    beside(&format!("{left}{gap}"), right, RIGHT)
}

/// Appends `right` to `left`, wrapped, with every line starting at `column`.
pub(crate) fn beside(left: &str, right: &str, column: usize) -> String {
    let mut text = left.to_owned();
    let mut at = left.rsplit('\n').next().map_or(0, |line| line.chars().count());
    let mut is_first = true;
    for word in right.split_whitespace() {
        let length = word.chars().count();
        if !is_first && at + 1 + length > WIDTH {
            text.push('\n');
            at = 0;
            is_first = true;
        }
        let gap = if is_first { column.saturating_sub(at) } else { 1 };
        text.push_str(&" ".repeat(gap));
        text.push_str(word);
        at += gap + length;
        is_first = false;
    }
    text
}
