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
    let mut shown: String = word.chars().take(LONGEST).flat_map(visible_char).collect();
    if word.chars().nth(LONGEST).is_some() {
        shown.push_str("...");
    }
    shown
}

fn visible_char(c: char) -> impl Iterator<Item = char> {
    let escaped = is_unseen(c).then(|| c.escape_unicode());
    let plain = (!is_unseen(c)).then_some(c);
    escaped.into_iter().flatten().chain(plain)
}

/// A text for a terminal: characters that are invisible or control the terminal become `\u{...}`,
/// except line breaks and tabs. Names come from files, and every output of names goes through this.
///
/// ```
/// assert_eq!(superegg_lang::visible("a\u{1b}[2Jb\u{202e}\tc\n"), "a\\u{1b}[2Jb\\u{202e}\tc\n");
/// ```
pub fn visible(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '\n' | '\t' => escaped.push(c),
            _ => escaped.extend(visible_char(c)),
        }
    }
    escaped
}

/// Whether a character is invisible or can control a terminal: control characters, fillers and
/// zero-width ones, and those that end lines or change the direction of writing.
pub fn is_unseen(c: char) -> bool {
    c.is_control()
        || matches!(
            c,
            '\u{ad}' | '\u{34f}' | '\u{61c}' | '\u{115f}' | '\u{1160}' | '\u{17b4}' | '\u{17b5}'
                | '\u{180b}'..='\u{180f}'
                | '\u{200b}'..='\u{200f}'
                | '\u{2028}'..='\u{202e}'
                | '\u{2060}'..='\u{206f}'
                | '\u{3164}'
                | '\u{fe00}'..='\u{fe0f}'
                | '\u{feff}'
                | '\u{ffa0}'
                | '\u{fff0}'..='\u{fffb}'
                | '\u{1d173}'..='\u{1d17a}'
                | '\u{e0000}'..='\u{e0fff}'
        )
}

/// The start of the right column.
const RIGHT: usize = 32;
/// Lines of a wider terminal are no longer than is easy to read.
const WIDEST: usize = 120;
/// In a narrower terminal lines are not wrapped further.
const NARROWEST: usize = 40;

/// The width of lines in a terminal of so many columns; the last one stays free.
pub(crate) fn line_width(columns: u16) -> usize {
    usize::from(columns).saturating_sub(1).clamp(NARROWEST, WIDEST)
}

/// Two columns, the right one wrapped. If `left` is too long, `right` starts on the next line.
pub(crate) fn two_columns(left: &str, right: &str, width: usize) -> String {
    let column = RIGHT.min(width / 2);
    let gap = if left.chars().count() + 2 > column { "\n" } else { "" };
    beside(&format!("{left}{gap}"), right, column, width)
}

/// Appends `right` to `left`, wrapped, with every line starting at `column`.
pub(crate) fn beside(left: &str, right: &str, column: usize, width: usize) -> String {
    let mut text = left.to_owned();
    let mut at = left.rsplit('\n').next().map_or(0, |line| line.chars().count());
    let mut is_first = true;
    for word in right.split_whitespace() {
        let length = word.chars().count();
        if !is_first && at + 1 + length > width {
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
