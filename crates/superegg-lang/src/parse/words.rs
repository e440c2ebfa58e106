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
        let characters = line.bytes().enumerate().map(|(byte, c)| (byte, byte, char::from(c)));
        return split(line, quoting, begins_word, characters);
    }
    let characters = line.char_indices().enumerate().map(|(column, (byte, c))| (byte, column, c));
    split(line, quoting, begins_word, characters)
}

/// The words of an ASCII line without comments and quotes, as most lines are; `None` for any other
/// line.
#[inline]
pub(crate) fn split_plain(line: &str) -> Option<Words<'_>> {
    let bytes = line.as_bytes();
    let kind = |at: usize| bytes.get(at).map(|byte| BYTE_KINDS[usize::from(*byte)]);
    let mut words = Words::new();
    let mut at = 0;
    loop {
        while kind(at) == Some(ByteKind::Blank) {
            at += 1;
        }
        let start = at;
        while kind(at) == Some(ByteKind::Word) {
            at += 1;
        }
        match kind(at) {
            Some(ByteKind::Special) => return None,
            None if at == start => return Some(words),
            None | Some(ByteKind::Blank | ByteKind::Word) => {
                words.push(Word { text: &line[start..at], columns: start..at });
            }
        }
    }
}

/// The classes of a line's bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum ByteKind {
    Blank,
    Word,
    /// A quote, the beginning of a comment, or part of a character that is not ASCII.
    Special,
}

const BYTE_KINDS: [ByteKind; 256] = {
    let mut kinds = [ByteKind::Word; 256];
    let mut byte = 0;
    while byte < 256 {
        kinds[byte] = match byte as u8 {
            b'\t'..=b'\r' | b' ' => ByteKind::Blank,
            b'"' | b'#' | 0x80.. => ByteKind::Special,
            _ => ByteKind::Word,
        };
        byte += 1;
    }
    kinds
};

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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn plain_lines_have_the_words_of_all_rules() {
        let mut state = 3_u64;
        let alphabet: Vec<char> = "ab1.-+ \t\r\u{b}\u{c}\u{1c}\u{7f}#\"é\u{a0}\u{2003}".chars().collect();
        let mut plain = 0;
        for _ in 0..20_000 {
            let mut line = String::new();
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            let kinds = if state >> 63 == 0 { 13 } else { alphabet.len() };
            for _ in 0..(state >> 40) % 12 {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
                line.push(alphabet[(state >> 33) as usize % kinds]);
            }
            let all = split_words(&line, Quoting::Plain, &|_, _| false);
            let found = split_plain(&line);
            assert_eq!(found.is_some(), line.is_ascii() && !line.contains(['#', '"']), "{line:?}");
            assert!(found.as_ref().is_none_or(|found| *found == all), "{line:?}");
            plain += usize::from(found.is_some());
        }
        assert!(plain > 5000, "{plain}");
    }
}
