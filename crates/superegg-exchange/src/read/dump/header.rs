//! The header of a frame: the sections before its rows.

use superegg_geom::glam::DVec3;

use super::super::error::ReadError;
use super::super::lines::Lines;
use super::super::particles::SimulationBox;

/// The header before the rows of a frame.
pub(super) struct Header {
    /// The number of rows.
    pub(super) count: u64,
    pub(super) bounds: Option<SimulationBox>,
    /// The names of the columns.
    pub(super) columns: Vec<String>,
}

/// How the bounds of the box are written: a trait of the program.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Style {
    /// Sixteen digits and an exponent, as LAMMPS writes them.
    Lammps,
    /// Edges and origin, as OVITO writes them.
    General,
    /// As other programs, and hands, write them.
    Plain,
}

impl Style {
    /// The style of the section that begins with the line `bounds`, before its first number.
    pub(super) fn of(bounds: &str, number: &str) -> Self {
        let is_lammps = number.split_once("e").is_some_and(|(digits, power)| {
            digits.trim_start_matches('-').len() == 18 && power.starts_with(['+', '-'])
        });
        if is_lammps {
            Self::Lammps
        } else if bounds.contains("abc") {
            Self::General
        } else {
            Self::Plain
        }
    }
}

/// The names behind `ITEM: ATOMS`.
pub(super) fn column_names(text: &str) -> Vec<String> {
    text.split_whitespace().map(str::to_owned).collect()
}

/// Reads the header and leaves the stream at the first row.
pub(super) fn read(lines: &mut Lines<'_>) -> Result<Header, ReadError> {
    let (mut count, mut bounds) = (None, None);
    loop {
        let Some(text) = next_text(lines)? else {
            return Err(ReadError::line(lines.line(), "the file ends before the rows of the frame"));
        };
        let Some(item) = text.strip_prefix("ITEM: ") else {
            return Err(ReadError::line(lines.line(), "expected a section such as ITEM: ATOMS"));
        };
        let item = item.trim();
        if let Some(columns) = item.strip_prefix("ATOMS") {
            let count = count.ok_or_else(|| {
                ReadError::line(lines.line(), "ITEM: NUMBER OF ATOMS is missing before the rows")
            })?;
            return Ok(Header { count, bounds, columns: column_names(columns) });
        } else if item == "NUMBER OF ATOMS" {
            count = Some(number_line(lines)?);
        } else if let Some(kind) = item.strip_prefix("BOX BOUNDS") {
            let kind = kind.to_owned();
            bounds = read_bounds(lines, &kind)?;
        } else if ["TIMESTEP", "UNITS", "TIME", "LABEL"].contains(&item) {
            next_text(lines)?;
        } else {
            let message = format!("'ITEM: {item}' is no section of a dump of particles");
            return Err(ReadError::line(lines.line(), message));
        }
    }
}

fn next_text(lines: &mut Lines<'_>) -> Result<Option<String>, ReadError> {
    let text = lines.next()?.map(|text| String::from_utf8_lossy(text).into_owned());
    Ok(text)
}

fn number_line(lines: &mut Lines<'_>) -> Result<u64, ReadError> {
    let text = next_text(lines)?.unwrap_or_default();
    text.trim().parse().map_err(|_| ReadError::line(lines.line(), "expected the number of particles"))
}

/// The bounds of the box: orthogonal, tilted (xy xz yz), or by edges and origin (abc origin).
fn read_bounds(lines: &mut Lines<'_>, kind: &str) -> Result<Option<SimulationBox>, ReadError> {
    let words: Vec<&str> = kind.split_whitespace().collect();
    let periodic = |index: usize| {
        let at = words.len().checked_sub(3).and_then(|first| words.get(first + index));
        at.is_some_and(|word| word.starts_with('p'))
    };
    let periodic = [periodic(0), periodic(1), periodic(2)];
    let mut rows = Vec::new();
    for _ in 0..3 {
        let text = next_text(lines)?.unwrap_or_default();
        let numbers: Option<Vec<f64>> = text.split_whitespace().map(|word| word.parse().ok()).collect();
        let wanted = if words.contains(&"abc") { 4 } else { 2 };
        let numbers =
            numbers.filter(|numbers| numbers.len() >= wanted && numbers.iter().all(|x| x.is_finite()));
        let Some(numbers) = numbers else {
            return Err(ReadError::line(lines.line(), "expected the bounds of the box"));
        };
        rows.push(numbers);
    }
    if words.contains(&"abc") {
        let edge = |row: usize| DVec3::new(rows[row][0], rows[row][1], rows[row][2]);
        let origin = DVec3::new(rows[0][3], rows[1][3], rows[2][3]);
        return Ok(Some(SimulationBox { origin, edges: [edge(0), edge(1), edge(2)], periodic }));
    }
    let tilt = |row: usize| rows[row].get(2).copied().unwrap_or(0.0);
    let (xy, xz, yz) = (tilt(0), tilt(1), tilt(2));
    // The bounds enclose the tilted box.
    let reach = |tilts: &[f64]| {
        let least = tilts.iter().copied().fold(0.0, f64::min);
        let most = tilts.iter().copied().fold(0.0, f64::max);
        (least, most)
    };
    let (x_least, x_most) = reach(&[xy, xz, xy + xz]);
    let (y_least, y_most) = reach(&[yz]);
    let least = DVec3::new(rows[0][0] - x_least, rows[1][0] - y_least, rows[2][0]);
    let most = DVec3::new(rows[0][1] - x_most, rows[1][1] - y_most, rows[2][1]);
    let size = most - least;
    let edges = [DVec3::X * size.x, DVec3::new(xy, size.y, 0.0), DVec3::new(xz, yz, size.z)];
    Ok(Some(SimulationBox { origin: least, edges, periodic }))
}
