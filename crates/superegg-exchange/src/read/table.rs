//! Tables of named columns: CSV (commas or semicolons) or blanks between them.

use std::io::SeekFrom;

use super::column_map;
use super::error::ReadError;
use super::format::Format;
use super::frame::Frame;
use super::import::{Import, Input};
use super::layout::{Layout, Names, Position, Powers, Rotation, Size};
use super::lines::Lines;
use super::number;
use super::options::ReadOptions;
use super::rows::{Rows, split_quoted};

const POSITION: [[&str; 3]; 4] = [
    ["x", "y", "z"],
    ["px", "py", "pz"],
    ["position_x", "position_y", "position_z"],
    ["Points:0", "Points:1", "Points:2"],
];
const SEMI_AXES: [[&str; 3]; 3] = [["a", "b", "c"], ["rx", "ry", "rz"], ["a1", "a2", "a3"]];
const SHAPE: [&str; 3] = ["shapex", "shapey", "shapez"];
const EXPONENTS: [[&str; 2]; 1] = [["e", "n"]];
/// Names with different meanings in different programs.
const DOUBTFUL_EXPONENTS: [[&str; 2]; 3] = [["e1", "e2"], ["eps1", "eps2"], ["epsilon1", "epsilon2"]];
const LIGGGHTS_POWERS: [[&str; 2]; 2] = [["blockiness1", "blockiness2"], ["roundness1", "roundness2"]];
const POWERS: [[&str; 2]; 2] = [["n1", "n2"], ["block1", "block2"]];
const LIGGGHTS_QUATERNION: [&str; 4] = ["quat1", "quat2", "quat3", "quat4"];
const LAMMPS_QUATERNION: [&str; 4] = ["quatw", "quati", "quatj", "quatk"];
const QUATERNION: [[&str; 4]; 4] =
    [["qw", "qx", "qy", "qz"], ["q0", "q1", "q2", "q3"], LIGGGHTS_QUATERNION, LAMMPS_QUATERNION];
const COLOR: [[&str; 3]; 2] = [["r", "g", "b"], ["red", "green", "blue"]];

/// The first line of a table.
struct Header {
    names: Vec<String>,
    /// The byte between columns; blanks if `None`.
    separator: Option<u8>,
    /// Whether the line is a row: the columns are then named 1, 2, 3...
    is_row: bool,
}

impl Header {
    fn of(line: &[u8]) -> Self {
        let text = line.strip_prefix(b"\xef\xbb\xbf").unwrap_or(line).trim_ascii();
        let text = text.strip_prefix(b"#").unwrap_or(text);
        let separator = [b',', b';'].into_iter().find(|separator| text.contains(separator));
        let words = split(text, separator);
        let is_row = words.iter().all(|word| number::parse(word).is_some());
        let names = words.iter().enumerate().map(|(index, word)| match is_row {
            true => (index + 1).to_string(),
            false => String::from_utf8_lossy(word).into_owned(),
        });
        Self { names: names.collect(), separator, is_row }
    }
}

fn split(text: &[u8], separator: Option<u8>) -> Vec<&[u8]> {
    match separator {
        Some(separator) => split_quoted(text, separator),
        None => text.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty()).collect(),
    }
}

/// Whether this is a table: a line of names, a position among them, and a row. Where blanks are between columns, the row has as many
/// of them, with numbers for the position; with commas the names decide, and reading names a wrong row.
pub(super) fn recognize(head: &[u8]) -> Result<Option<Format>, ReadError> {
    let mut lines = head.split(|&byte| byte == b'\n').filter(|line| !line.trim_ascii().is_empty());
    let Some(first) = lines.next() else { return Ok(None) };
    let header = Header::of(first);
    let row = lines.next().map(|row| split(row, header.separator)).unwrap_or_default();
    let is_table = Names(&header.names).any(&POSITION).is_some_and(|columns| {
        header.separator.is_some() && !row.is_empty()
            || row.len() == header.names.len()
                && columns.iter().all(|&column| number::parse(row[column]).is_some())
    });
    Ok((!header.is_row && is_table).then_some(Format::Table))
}

/// Reads a table.
pub(super) fn read(input: &mut dyn Input, frame: &Frame, options: &ReadOptions) -> Result<Import, ReadError> {
    input.seek(SeekFrom::Start(frame.start))?;
    let mut lines = Lines::new(input, frame.start, frame.end, frame.first_line)?;
    let header = loop {
        match lines.next()? {
            Some(line) if line.trim_ascii().is_empty() => {}
            Some(line) => break Header::of(line),
            None => return Err(ReadError::File("the table is empty".to_owned())),
        }
    };
    let Header { names, separator, is_row } = header;
    let layout = layout(names, options)?;
    if is_row {
        // The line is the first row.
        lines = Lines::new(input, frame.start, frame.end, frame.first_line)?;
    }
    let mut rows = Rows::new(&layout, options, 0).separated_by(separator);
    while let Some(text) = lines.next()? {
        let row = text.trim_ascii();
        if !row.is_empty() && !row.starts_with(b"#") {
            rows.add(text).map_err(|message| ReadError::line(lines.line(), message))?;
        }
    }
    let mut import = rows.finish()?;
    import.warnings.extend(unread(&layout));
    Ok(import)
}

/// A warning about columns that are not read.
fn unread(layout: &Layout) -> Option<String> {
    let wanted = layout.wanted();
    let names: Vec<&str> = layout
        .names
        .iter()
        .zip(wanted)
        .filter(|(_, wanted)| !wanted)
        .map(|(name, _)| name.as_str())
        .collect();
    (!names.is_empty()).then(|| format!("columns that are not read: {}", names.join(", ")))
}

/// The meaning of the columns: of those that the options name, else by their usual names.
fn layout(names: Vec<String>, options: &ReadOptions) -> Result<Layout, ReadError> {
    let held = Names(&names);
    let map = options.columns.as_ref();
    let position = held.any(&POSITION);
    if position.is_none() && !map.is_some_and(column_map::has_position) {
        let message = format!(
            "the table has no columns x, y, z; --columns position=X,Y,Z names them; the file has: {}",
            names.join(", ")
        );
        return Err(ReadError::part("position", message));
    }
    let extra = held
        .extra(&options.extra, options.all_extra)
        .map_err(|(name, message)| ReadError::part(name, message))?;
    let color = held.any(&COLOR);
    let mut layout = Layout {
        id: held.one("id"),
        position: Position::Plain(position.unwrap_or([0; 3])),
        size: size(held, color.is_none()),
        powers: powers(held),
        rotation: held.any(&QUATERNION).map_or(Rotation::Identity, Rotation::Quaternion),
        color,
        extra,
        skips_points: false,
        names,
    };
    if let Some(map) = map {
        column_map::assign(map, &mut layout)?;
    }
    refuse_doubts(&layout)?;
    Ok(layout)
}

fn size(names: Names<'_>, may_be_radius: bool) -> Size {
    if let Some(columns) = names.any(&SEMI_AXES) {
        return Size::SemiAxes(columns);
    }
    if let Some(columns) = names.all(SHAPE) {
        let is_liggghts = names.all(LIGGGHTS_QUATERNION).is_some() || names.any(&LIGGGHTS_POWERS).is_some();
        if is_liggghts {
            return Size::SemiAxes(columns);
        }
        if names.all(LAMMPS_QUATERNION).is_some() {
            return Size::Diameters(columns);
        }
    }
    let radius = names.one("radius").or_else(|| names.one("r").filter(|_| may_be_radius));
    let diameter = || names.one("diameter").or_else(|| names.one("d")).map_or(Size::Point, Size::Diameter);
    radius.map_or_else(diameter, Size::Radius)
}

fn powers(names: Names<'_>) -> Powers {
    if let Some(columns) = names.any(&EXPONENTS) {
        return Powers::Exponents(columns);
    }
    let columns = names.any(&LIGGGHTS_POWERS).or_else(|| names.any(&POWERS));
    columns.map_or(Powers::Round, Powers::Blockiness)
}

/// Refuses names that mean different things in different programs.
fn refuse_doubts(layout: &Layout) -> Result<(), ReadError> {
    let names = Names(&layout.names);
    if layout.powers == Powers::Round
        && let Some([first, second]) = DOUBTFUL_EXPONENTS.into_iter().find(|pair| names.all(*pair).is_some())
    {
        let message = format!(
            "programs differ on which of {first} and {second} shapes the xy section (e) and which the profile \
             along z (n); --columns exponents=E,N says it"
        );
        return Err(ReadError::part(first, message));
    }
    if layout.size == Size::Point && names.all(SHAPE).is_some() {
        let message = "shapex, shapey, shapez are semi-axes in LIGGGHTS and diameters in LAMMPS; --columns \
                       semi-axes=shapex,shapey,shapez or diameters=shapex,shapey,shapez says which";
        return Err(ReadError::part("shapex", message));
    }
    Ok(())
}
