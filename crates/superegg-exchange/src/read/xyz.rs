//! Point clouds in text: rows of x y z, with colours behind them, or the XYZ files of chemistry
//! (a count, a comment, then a name and x y z a row).

use std::io::{Read, SeekFrom};

use super::error::ReadError;
use super::format::Format;
use super::frame::Frame;
use super::import::{Import, Input};
use super::layout::{Layout, Names, Position, Powers, Rotation, Size};
use super::lines::Lines;
use super::number;
use super::options::ReadOptions;
use super::rows::Rows;

/// The numbers of columns that are taken for points: more may be vectors of another program.
const COUNTS: [usize; 5] = [3, 4, 6, 7, 9];
/// The number of rows that decide the format.
const DECIDING: usize = 20;

/// How the rows are written.
struct Shape {
    /// The number of lines before the first row.
    skipped: usize,
    columns: usize,
    separator: Option<u8>,
    has_names: bool,
    /// The number of rows, if the file says it.
    count: Option<u64>,
}

fn words(line: &[u8], separator: Option<u8>) -> Vec<&[u8]> {
    line.split(|byte| byte.is_ascii_whitespace() || Some(*byte) == separator)
        .filter(|word| !word.is_empty())
        .collect()
}

fn is_comment(line: &[u8]) -> bool {
    let line = line.trim_ascii();
    line.is_empty() || line.starts_with(b"#") || line.starts_with(b"//")
}

impl Shape {
    /// The shape of a file with these first lines; `None` if it is no list of points.
    fn of(head: &[u8], is_forced: bool) -> Option<Self> {
        let mut lines: Vec<&[u8]> = head.split(|&byte| byte == b'\n').collect();
        // The last line may be cut off.
        if lines.len() > 1 {
            lines.pop();
        }
        let skipped = lines.iter().take_while(|line| is_comment(line)).count();
        let first = lines.get(skipped)?;
        let separator = [b',', b';'].into_iter().find(|separator| first.contains(separator));
        let first = words(first, separator);
        if let [count] = first[..] {
            let count: u64 = std::str::from_utf8(count).ok()?.parse().ok()?;
            return Self::of_chemistry(lines.get(skipped + 2), skipped + 2, count);
        }
        let columns = first.len();
        let fits = |line: &&[u8]| {
            let words = words(line, separator);
            words.len() == columns && words.iter().all(|word| number::parse(word).is_some())
        };
        let rows = lines[skipped..].iter().filter(|line| !is_comment(line)).take(DECIDING);
        let is_right_count = COUNTS.contains(&columns) || is_forced && columns >= 3;
        (is_right_count && (is_forced || rows.into_iter().all(fits))).then_some(Self {
            skipped,
            columns,
            separator,
            has_names: false,
            count: None,
        })
    }

    /// The shape of a file of chemistry with this first row.
    fn of_chemistry(row: Option<&&[u8]>, skipped: usize, count: u64) -> Option<Self> {
        let first = words(row?, None);
        let has_names = number::parse(first.first()?).is_none();
        let from = usize::from(has_names);
        let coordinates = first.get(from..from + 3)?;
        let are_numbers = coordinates.iter().all(|word| number::parse(word).is_some());
        are_numbers.then_some(Self {
            skipped,
            columns: first.len(),
            separator: None,
            has_names,
            count: Some(count),
        })
    }
}

/// Whether this is a list of points.
pub(super) fn recognize(head: &[u8]) -> Result<Option<Format>, ReadError> {
    Ok(Shape::of(head, false).map(|_| Format::Xyz))
}

/// Reads the points.
pub(super) fn read(input: &mut dyn Input, frame: &Frame, options: &ReadOptions) -> Result<Import, ReadError> {
    let mut head = Vec::new();
    input.seek(SeekFrom::Start(frame.start))?;
    input.take(1 << 16).read_to_end(&mut head)?;
    let Some(shape) = Shape::of(&head, true) else {
        return Err(ReadError::File("expected rows of at least three numbers".to_owned()));
    };
    let layout = layout(&shape, &head, options)?;
    let mut lines = Lines::new(input, frame.start, frame.end, frame.first_line)?;
    for _ in 0..shape.skipped {
        lines.next()?;
    }
    let mut rows = Rows::new(&layout, options, 0).separated_by(shape.separator);
    while let Some(text) = lines.next()? {
        let is_complete = shape.count.is_some_and(|count| rows.count() as u64 == count);
        if is_complete {
            break;
        }
        if !is_comment(text) {
            rows.add(text).map_err(|message| ReadError::line(lines.line(), message))?;
        }
    }
    if let Some(count) = shape.count.filter(|count| (rows.count() as u64) < *count) {
        let message = format!("the file ends after {} of {count} points", rows.count());
        return Err(ReadError::line(lines.line(), message));
    }
    rows.finish()
}

/// The meaning of the columns: x y z, then colours if there are three columns that can be some.
fn layout(shape: &Shape, head: &[u8], options: &ReadOptions) -> Result<Layout, ReadError> {
    let from = usize::from(shape.has_names);
    let mut names: Vec<String> = if shape.has_names { vec!["name".to_owned()] } else { Vec::new() };
    names.extend(["x", "y", "z"].map(str::to_owned));
    let color = (shape.count.is_none() && shape.columns == 6 && are_colors(shape, head)).then_some([3, 4, 5]);
    if color.is_some() {
        names.extend(["red", "green", "blue"].map(str::to_owned));
    }
    let unnamed = names.len()..shape.columns;
    names.extend(unnamed.map(|column| (column + 1).to_string()));
    let extra = Names(&names)
        .extra(&options.extra, options.all_extra)
        .map_err(|(name, message)| ReadError::part(name, message))?;
    Ok(Layout {
        id: None,
        position: Position::Plain([from, from + 1, from + 2]),
        size: Size::Point,
        powers: Powers::Round,
        rotation: Rotation::Identity,
        color,
        extra,
        skips_points: false,
        names,
    })
}

/// Whether the last three of six columns can be colours: no number below 0 (normals have some), and
/// integers if one is above 1.
fn are_colors(shape: &Shape, head: &[u8]) -> bool {
    let mut lines: Vec<&[u8]> = head.split(|&byte| byte == b'\n').collect();
    if lines.len() > 1 {
        lines.pop();
    }
    let rows = lines.into_iter().skip(shape.skipped).filter(|line| !is_comment(line));
    let parts: Vec<f64> = rows
        .flat_map(|line| words(line, shape.separator).into_iter().skip(3).take(3))
        .map(|word| number::parse(word).unwrap_or(f64::NAN))
        .collect();
    let are_fractions = parts.iter().all(|part| (0.0..=1.0).contains(part));
    let are_bytes = parts.iter().all(|part| (0.0..=255.0).contains(part) && part.fract() == 0.0);
    are_fractions || are_bytes
}
