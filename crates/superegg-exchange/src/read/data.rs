//! Data files of LIGGGHTS and LAMMPS: a header of counts and bounds, then sections.

mod header;
mod lammps;
mod liggghts;

use std::io::SeekFrom;

use super::error::ReadError;
use super::format::Format;
use super::frame::Frame;
use super::import::{Import, Input};
use super::lines::Lines;
use super::options::ReadOptions;

/// Whether this is a data file, and of which program: LAMMPS names the style of its atoms and has
/// ellipsoids in a section of their own.
pub(super) fn recognize(head: &[u8]) -> Result<Option<Format>, ReadError> {
    let text = String::from_utf8_lossy(head);
    // The first line is a comment.
    let Some((_, rest)) = text.split_once('\n') else { return Ok(None) };
    let (mut has_atoms, mut has_bounds, mut is_lammps) = (false, false, false);
    for line in rest.lines() {
        let (content, hint) = line.split_once('#').unwrap_or((line, ""));
        let words: Vec<&str> = content.split_whitespace().collect();
        match words[..] {
            [count, "atoms"] => has_atoms = count.parse::<u64>().is_ok(),
            [count, "ellipsoids"] => is_lammps |= count != "0",
            [_, _, "xlo", "xhi"] | [.., "avec"] => has_bounds = true,
            ["Ellipsoids"] => is_lammps = true,
            ["Atoms"] if has_atoms && has_bounds => {
                let style = hint.trim();
                is_lammps |= !style.is_empty() && style != "superquadric";
                break;
            }
            _ => {}
        }
    }
    let format = if is_lammps { Format::LammpsData } else { Format::LiggghtsData };
    Ok((has_atoms && has_bounds).then_some(format))
}

/// Reads a data file.
pub(super) fn read(
    input: &mut dyn Input,
    format: Format,
    frame: &Frame,
    options: &ReadOptions,
) -> Result<Import, ReadError> {
    input.seek(SeekFrom::Start(frame.start))?;
    let mut lines = Lines::new(input, frame.start, frame.end, frame.first_line)?;
    let header = header::read(&mut lines)?;
    match format {
        Format::LammpsData => lammps::read(&mut lines, &header, options),
        _ => liggghts::read(&mut lines, &header, options),
    }
}
