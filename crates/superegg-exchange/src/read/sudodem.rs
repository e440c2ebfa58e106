//! Text of SudoDEM's `outputParticles` and `outputParticlesbyIds`: a line that begins with # and
//! lists the columns, then twelve numbers a superellipsoid, four a sphere, fifteen a
//! poly-superellipsoid. There eps1 = e and eps2 = n.

use std::io::SeekFrom;

use super::error::ReadError;
use super::format::Format;
use super::frame::Frame;
use super::import::{Import, Input};
use super::layout::{Layout, Names, Position, Powers, Rotation, Size};
use super::lines::Lines;
use super::number;
use super::options::ReadOptions;
use super::rows::Rows;

const COLUMNS: [&str; 12] = ["rx", "ry", "rz", "eps1", "eps2", "x", "y", "z", "qw", "qx", "qy", "qz"];
/// The number of columns of a sphere: r x y z.
const SPHERE: usize = 4;
/// The number of columns of a poly-superellipsoid: two radii an axis.
const POLY: usize = 15;

/// Whether the first line lists the columns of SudoDEM.
pub(super) fn recognize(head: &[u8]) -> Result<Option<Format>, ReadError> {
    let line = head.split(|&byte| byte == b'\n').next().unwrap_or_default();
    let text = String::from_utf8_lossy(line);
    let is_header = ["rx", "ry", "rz", "eps1", "eps2"].iter().all(|name| text.contains(name));
    Ok(is_header.then_some(Format::Sudodem))
}

/// Reads the particles.
pub(super) fn read(input: &mut dyn Input, frame: &Frame, options: &ReadOptions) -> Result<Import, ReadError> {
    input.seek(SeekFrom::Start(frame.start))?;
    let mut lines = Lines::new(input, frame.start, frame.end, frame.first_line)?;
    let mut layout = layout(COLUMNS.map(str::to_owned).to_vec(), options)?;
    let mut is_first = true;
    let mut rows_text = Vec::new();
    let mut skipped = 0;
    // The header may list the columns in another order.
    while let Some(text) = lines.next()? {
        let words = String::from_utf8_lossy(text);
        if std::mem::take(&mut is_first) && words.contains("eps1") {
            let names: Vec<String> = words
                .trim_start_matches('#')
                .split([' ', '\t', ','])
                .filter(|name| !name.is_empty())
                .map(own)
                .collect();
            if let Some(found) = named_layout(names, options)? {
                layout = found;
            }
            continue;
        }
        let row = text.trim_ascii();
        if row.is_empty() || row.starts_with(b"#") {
            continue;
        }
        let count = row.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty()).count();
        if count == POLY && layout.names.len() != POLY {
            skipped += 1;
            continue;
        }
        let numbers = row_numbers(text, count, &layout);
        let line = lines.line();
        rows_text.push((line, numbers.map_err(|message| ReadError::line(line, message))?));
    }
    let mut rows = Rows::new(&layout, options, rows_text.len() as u64);
    for (line, numbers) in &rows_text {
        rows.add_numbers(numbers).map_err(|message| ReadError::line(*line, message))?;
    }
    let mut import = rows.finish()?;
    if skipped > 0 {
        import.warnings.push(format!(
            "{skipped} poly-superellipsoids (15 columns) are no superquadrics; they are left out"
        ));
    }
    Ok(import)
}

fn own(name: &str) -> String {
    name.trim().to_owned()
}

/// The numbers of a row in the order of the layout; a sphere has its radius three times.
fn row_numbers(text: &[u8], count: usize, layout: &Layout) -> Result<Vec<f64>, String> {
    let words = text.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty());
    let parsed = words.enumerate().map(|(index, word)| {
        let name = layout.names.get(index).map_or("", String::as_str);
        number::parse(word).ok_or_else(|| {
            format!("column {} ('{name}'): '{}' is not a number", index + 1, String::from_utf8_lossy(word))
        })
    });
    let numbers: Vec<f64> = parsed.collect::<Result<_, String>>()?;
    if let (SPHERE, &[r, x, y, z]) = (count, &numbers[..]) {
        let values = [r, r, r, 1.0, 1.0, x, y, z, 1.0, 0.0, 0.0, 0.0];
        let mut sphere = vec![0.0; layout.names.len()];
        let names = Names(&layout.names);
        for (name, value) in COLUMNS.into_iter().zip(values) {
            if let Some(column) = names.one(name) {
                sphere[column] = value;
            }
        }
        return Ok(sphere);
    }
    if count == layout.names.len() {
        return Ok(numbers);
    }
    Err(format!("the row has {count} columns; expected {} (or {SPHERE} for a sphere)", layout.names.len()))
}

/// The layout of columns with these names; `None` if they are not all there.
fn named_layout(names: Vec<String>, options: &ReadOptions) -> Result<Option<Layout>, ReadError> {
    // The components of the quaternion have two sets of names.
    let names: Vec<String> = names
        .into_iter()
        .map(|name| match name.as_str() {
            "q0" => "qw".to_owned(),
            "q1" => "qx".to_owned(),
            "q2" => "qy".to_owned(),
            "q3" => "qz".to_owned(),
            _ => name,
        })
        .collect();
    if Names(&names).all(COLUMNS).is_none() { Ok(None) } else { layout(names, options).map(Some) }
}

fn layout(names: Vec<String>, options: &ReadOptions) -> Result<Layout, ReadError> {
    let held = Names(&names);
    let columns = held.all(COLUMNS).unwrap_or_else(|| std::array::from_fn(|index| index));
    let [rx, ry, rz, e, n, x, y, z, qw, qx, qy, qz] = columns;
    let extra = held
        .extra(&options.extra, options.all_extra)
        .map_err(|(name, message)| ReadError::part(name, message))?;
    Ok(Layout {
        id: held.one("id"),
        position: Position::Plain([x, y, z]),
        size: Size::SemiAxes([rx, ry, rz]),
        powers: Powers::Exponents([e, n]),
        rotation: Rotation::Quaternion([qw, qx, qy, qz]),
        color: None,
        extra,
        skips_points: false,
        names,
    })
}
