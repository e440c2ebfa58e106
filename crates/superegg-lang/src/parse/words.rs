//! Splitting of a line into words.

use std::ops::Range;

use smallvec::SmallVec;

/// A word of a line.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Word<'a> {
    /// The text, without enclosing quotes.
    pub(crate) text: &'a str,
    /// The columns in the line, in characters from 0, including quotes.
    pub(crate) columns: Range<usize>,
}

/// The words of a line. Most lines have few.
pub(crate) type Words<'a> = SmallVec<[Word<'a>; 8]>;

/// The role of double quotes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Quoting {
    /// A quote is an ordinary character: names may contain it.
    Plain,
    /// A word that begins with a quote ends at the next one: file names may contain blanks.
    Quoted,
}

/// Whether a `#` after a blank begins a word, given the words before it and the text after it.
pub(crate) type BeginsWord<'f> = dyn Fn(&[Word<'_>], &str) -> bool + 'f;

/// The words of a line. `#` starts a comment, except within quotes and where `begins_word` allows
/// a word to begin with it. An open quote extends to the end.
pub(crate) fn split_words<'a>(line: &'a str, quoting: Quoting, begins_word: &BeginsWord<'_>) -> Words<'a> {
    if line.is_ascii() {
        if quoting == Quoting::Plain && memchr::memchr(b'#', line.as_bytes()).is_none() {
            return split_at_blanks(line);
        }
        let characters = line.bytes().enumerate().map(|(byte, c)| (byte, byte, char::from(c)));
        return split(line, quoting, begins_word, characters);
    }
    let characters = line.char_indices().enumerate().map(|(column, (byte, c))| (byte, column, c));
    split(line, quoting, begins_word, characters)
}

/// The words of an ASCII line without comments and quotes, as most lines are.
fn split_at_blanks(line: &str) -> Words<'_> {
    let bytes = line.as_bytes();
    let find = |start: usize, wants_blank: bool| {
        let found = bytes[start..].iter().position(|byte| is_blank(char::from(*byte)) == wants_blank);
        found.map_or(bytes.len(), |length| start + length)
    };
    let mut words = Words::new();
    let mut end = 0;
    loop {
        let start = find(end, false);
        if start == bytes.len() {
            return words;
        }
        end = find(start, true);
        words.push(Word { text: &line[start..end], columns: start..end });
    }
}

/// Whether a character is white space. Most are ASCII.
#[inline]
fn is_blank(c: char) -> bool {
    if c.is_ascii() { matches!(c, '\t'..='\r' | ' ') } else { c.is_whitespace() }
}

/// As [`split_words`], with the byte, column and character of each character of the line.
fn split<'a>(
    line: &'a str,
    quoting: Quoting,
    begins_word: &BeginsWord<'_>,
    characters: impl Iterator<Item = (usize, usize, char)>,
) -> Words<'a> {
    let mut words = Words::new();
    // Byte and column of the start of the current word, and whether it starts with a quote.
    let mut start: Option<(usize, usize, bool)> = None;
    let mut end = 0;
    for (byte, column, c) in characters {
        match start {
            Some((first, first_column, true)) if c == '"' => {
                words.push(Word { text: &line[first + 1..byte], columns: first_column..column + 1 });
                start = None;
            }
            Some((first, first_column, false)) if is_blank(c) || c == '#' => {
                words.push(Word { text: &line[first..byte], columns: first_column..column });
                start = None;
            }
            None if !is_blank(c) && c != '#' => {
                start = Some((byte, column, c == '"' && quoting == Quoting::Quoted));
            }
            None if c == '#' && begins_word(&words, &line[byte + 1..]) => {
                start = Some((byte, column, false));
            }
            _ => {}
        }
        if c == '#' && start.is_none() {
            return words;
        }
        end = column + 1;
    }
    if let Some((first, first_column, is_quoted)) = start {
        words.push(Word { text: &line[first + usize::from(is_quoted)..], columns: first_column..end });
    }
    words
}
