//! Text dumps of LIGGGHTS, LAMMPS and OVITO: frames of `ITEM:` sections.
//!
//! The three programs use the same layout, and partly the same column names with other meanings.
//! Frames are read as a stream, block by block: a file of any size takes the memory of its result.

mod columns;
mod header;

use std::io::SeekFrom;

use super::error::ReadError;
use super::format::Format;
use super::frame::Frame;
use super::import::{Import, Input};
use super::lines::Lines;
use super::options::ReadOptions;
use super::rows::Rows;
use header::Style;

/// The first words of a frame.
const FRAME: &[u8] = b"ITEM: TIMESTEP";

/// Which dump this is, by the columns and the bounds of its first frame; `None` if it is no dump.
pub(super) fn recognize(head: &[u8]) -> Result<Option<Format>, ReadError> {
    let text = head.strip_prefix(b"\xef\xbb\xbf").unwrap_or(head);
    if !text.trim_ascii_start().starts_with(b"ITEM: ") {
        return Ok(None);
    }
    let text = String::from_utf8_lossy(text);
    let mut style = Style::Plain;
    let mut lines = text.lines();
    while let Some(line) = lines.next() {
        if let Some(bounds) = line.strip_prefix("ITEM: BOX BOUNDS") {
            let numbers = lines.next().unwrap_or_default();
            style = Style::of(bounds, numbers.split_whitespace().next().unwrap_or_default());
        } else if let Some(names) = line.strip_prefix("ITEM: ATOMS") {
            return columns::format_of(&header::column_names(names), style).map(Some);
        }
    }
    Err(ReadError::File("the dump has no section ITEM: ATOMS".to_owned()))
}

/// The frames of a dump.
pub(super) fn frames(input: &mut dyn Input) -> Result<Vec<Frame>, ReadError> {
    let mut frames: Vec<Frame> = Vec::new();
    let mut lines = Lines::new(input, 0, u64::MAX, 1)?;
    lines.skip_to(FRAME)?;
    while let Some((start, line)) = lines.at_prefix(FRAME)? {
        if let Some(last) = frames.last_mut() {
            last.end = start;
        }
        let step = lines.next()?.and_then(|text| std::str::from_utf8(text).ok()?.trim().parse().ok());
        frames.push(Frame { step, start, end: lines.end(), first_line: line });
        lines.skip_to(FRAME)?;
    }
    if frames.is_empty() {
        return Err(ReadError::File("the dump has no frame (ITEM: TIMESTEP)".to_owned()));
    }
    Ok(frames)
}

/// Reads one frame.
pub(super) fn read(
    input: &mut dyn Input,
    frame: &Frame,
    format: Format,
    options: &ReadOptions,
) -> Result<Import, ReadError> {
    input.seek(SeekFrom::Start(frame.start))?;
    let mut lines = Lines::new(input, frame.start, frame.end, frame.first_line)?;
    let header = header::read(&mut lines)?;
    let (layout, column_warnings) = columns::layout(header.columns, format, options)?;
    // A row has at least two bytes for each column.
    let most = (frame.end - frame.start) / (2 * layout.names.len().max(1) as u64);
    let mut rows = Rows::new(&layout, options, header.count.min(most)).in_frame(header.bounds, frame.step);
    while (rows.count() as u64) < header.count {
        let Some(text) = lines.next()? else {
            let (found, count, first) = (rows.count(), header.count, frame.first_line);
            let message = format!("the frame at line {first} ends after {found} of {count} rows");
            return Err(ReadError::line(lines.line(), message));
        };
        rows.add(text).map_err(|message| ReadError::line(lines.line(), message))?;
    }
    end(&mut lines, header.count)?;
    let mut import = rows.finish()?;
    import.warnings.splice(0..0, column_warnings);
    Ok(import)
}

/// Checks that nothing but blank lines and the units and time of the next frame follow the rows.
fn end(lines: &mut Lines<'_>, count: u64) -> Result<(), ReadError> {
    while let Some(text) = lines.next()? {
        let text = text.trim_ascii();
        if text == b"ITEM: UNITS" || text == b"ITEM: TIME" {
            lines.next()?;
        } else if !text.is_empty() {
            let message = format!("there are more rows than the {count} of the frame");
            return Err(ReadError::line(lines.line(), message));
        }
    }
    Ok(())
}
