//! The characters of texts in pictures: lines on a grid, drawn with a pen one unit wide.
//!
//! A word of a glyph is a stroke: its kind, then its points. A point is a column, from `a` for 0, and
//! a row; row 2 is the base line, row 6 the height of small letters, row 8 that of capitals.
//! The kinds are `-` for straight lines, `~` for lines with round corners, and `o` for a closed line
//! with round corners.

/// The row of the base line.
const BASE: i32 = 2;
/// The height of capitals, in units, without the width of the pen.
pub(super) const CAPITAL: f64 = 6.0;
/// The greatest distance of the round part of a line from its corner, in units.
const CORNER: f64 = 2.0;
/// The lines that stand for a round corner.
const CORNER_LINES: usize = 6;

/// The printable characters of ASCII in their order.
const GLYPHS: [&str; 95] = [
    // Space ! " # $ % & '
    "",
    "-a8a4 -a2a2",
    "-a8a6 -c8c6",
    "-b2b8 -d2d8 -a4e4 -a6e6",
    "~e7e8a8a5e5e2a2a3 -c9c1",
    "-a2e8 oa6b6b8a8 od2e2e4d4",
    "~e2a6a8d8d6a4a2d2e4",
    "-a8a6",
    // ( ) * + , - . /
    "~b9a8a2b1",
    "~a9b8b2a1",
    "-b4b8 -a5c7 -a7c5",
    "-a5e5 -c3c7",
    "-b2a1",
    "-a5d5",
    "-a2a2",
    "-a1d9",
    // 0 to 9
    "oa2e2e8a8",
    "-b7c8c2",
    "~a7a8e8e5a2 -a2e2",
    "~a7a8e8e5b5 ~b5e5e2a2a3",
    "-d2d8a4e4",
    "-e8a8a5 ~a5e5e2a2",
    "~e8a8a4 oa2e2e5a5",
    "-a8e8b2",
    "oa5e5e8a8 oa2e2e5a5",
    "oa5e5e8a8 ~e6e2a2",
    // : ; < = > ? @
    "-a3a3 -a6a6",
    "-b6b6 -b3a1",
    "-d8a5d2",
    "-a4d4 -a6d6",
    "-a8d5a2",
    "~a7a8d8d5b5b4 -b2b2",
    "~e2a2a8e8e4c4c6e6",
    // A to Z
    "-a2c8e2 -b4d4",
    "-a2a8 ~a8e8e5a5 ~a5e5e2a2",
    "~e7e8a8a2e2e3",
    "-a2a8 ~a8e8e2a2",
    "-e8a8a2e2 -a5d5",
    "-e8a8a2 -a5d5",
    "~e7e8a8a2e2e5 -e5c5",
    "-a2a8 -e2e8 -a5e5",
    "-b2b8 -a8c8 -a2c2",
    "~d8d2a2a3",
    "-a2a8 -a4e8 -b5e2",
    "-a8a2e2",
    "-a2a8c5e8e2",
    "-a2a8e2e8",
    "oa2e2e8a8",
    "-a2a8 ~a8e8e5a5",
    "oa2e2e8a8 -c4e2",
    "-a2a8 ~a8e8e5a5 -c5e2",
    "~e7e8a8a5e5e2a2a3",
    "-a8e8 -c8c2",
    "~a8a2e2e8",
    "-a8c2e8",
    "-a8b2c6d2e8",
    "-a2e8 -a8e2",
    "-a8c5e8 -c5c2",
    "-a8e8a2e2",
    // [ \ ] ^ _ `
    "-b9a9a1b1",
    "-a9d1",
    "-a9b9b1a1",
    "-a6c8e6",
    "-a1e1",
    "-a8b7",
    // a to z
    "~a6d6d2 ~d4a4a2d2",
    "-a2a8 ~a6d6d2a2",
    "~d5d6a6a2d2d3",
    "-d2d8 ~d6a6a2d2",
    "-a4d4 ~d4d6a6a2d2",
    "~c8b8b2 -a6c6",
    "~d6a6a2d2 ~d6d0a0",
    "-a2a8 ~a6d6d2",
    "-a2a6 -a8a8",
    "~b6b0a0 -b8b8",
    "-a2a8 -a3d6 -b4d2",
    "~a8a2b2",
    "-a2a6 ~a6c6c2 ~c6e6e2",
    "-a2a6 ~a6d6d2",
    "oa2d2d6a6",
    "-a0a6 ~a6d6d2a2",
    "-d0d6 ~d6a6a2d2",
    "-a2a6 ~a4a6c6",
    "~d6a6a4d4d2a2",
    "~b8b2c2 -a6c6",
    "~a6a2d2 -d6d2",
    "-a6c2e6",
    "-a6b2c5d2e6",
    "-a6d2 -a2d6",
    "-a6c2 -e6b0",
    "-a6d6a2d2",
    // { | } ~
    "~c9b9b5a5 ~a5b5b1c1",
    "-a9a1",
    "~a9b9b5c5 ~c5b5b1a1",
    "-a5b6d4e5",
];

/// A character as lines.
pub(super) struct Glyph {
    /// The lines, point by point: to the right and up from the base line, in units.
    pub(super) strokes: Vec<Vec<[f64; 2]>>,
    /// The distance to the next character, in units.
    pub(super) advance: f64,
}

impl Glyph {
    /// A character; '?' for one that is not in ASCII.
    pub(super) fn of(c: char) -> Self {
        let words = GLYPHS[index_of(c)];
        let strokes: Vec<Vec<[f64; 2]>> = words.split_whitespace().map(stroke).collect();
        let widest = strokes.iter().flatten().map(|point| point[0]).fold(0.0, f64::max);
        // Figures are equally wide, so that numbers stand in columns.
        let width = if c.is_ascii_digit() { 4.0 } else { widest };
        // The pen, and a gap.
        Self { strokes, advance: width + 2.0 }
    }
}

/// The width of a text, in units, without the gap behind its last character.
pub(super) fn text_width(text: &str) -> f64 {
    text.chars().map(|c| Glyph::of(c).advance).sum::<f64>() - if text.is_empty() { 0.0 } else { 1.0 }
}

fn index_of(c: char) -> usize {
    let index = |c: char| (c as usize).checked_sub(' ' as usize).filter(|index| *index < GLYPHS.len());
    index(c).or(index('?')).unwrap_or_default()
}

/// The points of a stroke, with round corners as short lines.
fn stroke(word: &str) -> Vec<[f64; 2]> {
    let (kind, rest) = word.as_bytes().split_first().map_or((b'-', &[][..]), |(kind, rest)| (*kind, rest));
    let coordinate = |byte: u8, zero: u8| f64::from(i32::from(byte) - i32::from(zero));
    let points: Vec<[f64; 2]> = rest
        .as_chunks::<2>()
        .0
        .iter()
        .map(|&[column, row]| [coordinate(column, b'a'), coordinate(row, b'0') - f64::from(BASE)])
        .collect();
    match kind {
        b'o' => rounded(&points, true),
        b'~' => rounded(&points, false),
        _ => points,
    }
}

/// A line with round corners: parabolas between points near each corner.
fn rounded(points: &[[f64; 2]], is_closed: bool) -> Vec<[f64; 2]> {
    let count = points.len();
    let mut line = Vec::new();
    for (index, corner) in points.iter().enumerate() {
        let is_end = !is_closed && (index == 0 || index + 1 == count);
        if is_end {
            line.push(*corner);
            continue;
        }
        let previous = (index + count - 1) % count;
        let next = (index + 1) % count;
        // A side between two corners is shared by them.
        let is_free = |other: usize| !is_closed && (other == 0 || other + 1 == count);
        let near = |other: usize| {
            let to = points[other];
            let length = (to[0] - corner[0]).hypot(to[1] - corner[1]);
            let part = (CORNER / length).min(if is_free(other) { 1.0 } else { 0.5 });
            mix(*corner, to, part)
        };
        let (from, to) = (near(previous), near(next));
        for step in 0..=CORNER_LINES {
            let t = step as f64 / CORNER_LINES as f64;
            line.push(mix(mix(from, *corner, t), mix(*corner, to, t), t));
        }
    }
    if is_closed {
        line.extend(line.first().copied());
    }
    line
}

fn mix(from: [f64; 2], to: [f64; 2], t: f64) -> [f64; 2] {
    [from[0] + t * (to[0] - from[0]), from[1] + t * (to[1] - from[1])]
}

#[cfg(test)]
mod tests {
    use std::collections::HashMap;

    use super::*;

    #[test]
    fn every_character_of_ascii_is_well_formed_and_looks_like_no_other() {
        let mut seen = HashMap::new();
        for c in ' '..='~' {
            let words = GLYPHS[index_of(c)];
            for word in words.split_whitespace() {
                assert!(word.starts_with(['-', '~', 'o']) && word.len() >= 5 && word.len() % 2 == 1, "{c}");
                let is_point = |point: &[u8]| (b'a'..=b'e').contains(&point[0]) && point[1].is_ascii_digit();
                assert!(word.as_bytes()[1..].chunks(2).all(is_point), "{c}: {word}");
            }
            if let Some(other) = seen.insert(words, c) {
                // The digit and the capital differ in nothing.
                assert_eq!((other, c), ('0', 'O'));
            }
            for [x, y] in Glyph::of(c).strokes.into_iter().flatten() {
                assert!((0.0..=4.0).contains(&x) && (-2.0..=7.0).contains(&y), "{c}");
            }
        }
    }

    #[test]
    fn other_characters_are_question_marks() {
        let lines = |c| Glyph::of(c).strokes;
        for c in ['é', '\n', '\0', '\u{7f}', '漢'] {
            assert_eq!(lines(c), lines('?'));
        }
        assert_eq!(text_width(""), 0.0);
        assert_eq!(text_width("00"), 11.0);
    }
}
