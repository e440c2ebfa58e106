//! A line of text to words.

use std::ops::Range;

/// A word of a line.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Word<'a> {
    /// Its text, without the quotes around it.
    pub(crate) text: &'a str,
    /// Its characters in the line, quotes included, counted from 0.
    pub(crate) columns: Range<usize>,
}

/// How the words of a line are told apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Quoting {
    /// A quote is a character like any other: names may have them.
    Plain,
    /// A word that begins with a double quote goes to the next one: file names may have blanks.
    Quoted,
}

/// The words of a line up to a `#`, which starts a comment anywhere but within quotes. A quote that is not closed goes to the end.
pub(crate) fn split_words(line: &str, quoting: Quoting) -> Vec<Word<'_>> {
    if line.is_ascii() {
        let characters = line.bytes().enumerate().map(|(byte, c)| (byte, byte, char::from(c)));
        return split(line, quoting, characters);
    }
    split(line, quoting, line.char_indices().enumerate().map(|(column, (byte, c))| (byte, column, c)))
}

/// The same of a line with its characters: the byte and the column of each.
fn split(
    line: &str,
    quoting: Quoting,
    characters: impl Iterator<Item = (usize, usize, char)>,
) -> Vec<Word<'_>> {
    let mut words = Vec::with_capacity(8);
    // Byte and column where the present word began, and whether with a quote.
    let mut start: Option<(usize, usize, bool)> = None;
    let mut end = 0;
    for (byte, column, c) in characters {
        match start {
            Some((first, first_column, true)) if c == '"' => {
                words.push(Word { text: &line[first + 1..byte], columns: first_column..column + 1 });
                start = None;
            }
            Some((first, first_column, false)) if c.is_whitespace() || c == '#' => {
                words.push(Word { text: &line[first..byte], columns: first_column..column });
                start = None;
            }
            None if !c.is_whitespace() && c != '#' => {
                start = Some((byte, column, c == '"' && quoting == Quoting::Quoted));
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
