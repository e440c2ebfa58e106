//! Data files of LIGGGHTS: id type density a b c n1 n2 x y z, without a rotation.

use super::super::error::ReadError;
use super::super::import::Import;
use super::super::layout::{Layout, Names, Position, Powers, Rotation, Size};
use super::super::lines::Lines;
use super::super::options::ReadOptions;
use super::super::rows::Rows;
use super::header::{Header, Section, row_numbers};

const COLUMNS: [&str; 11] =
    ["id", "type", "density", "shapex", "shapey", "shapez", "blockiness1", "blockiness2", "x", "y", "z"];
/// The number of columns that the program's own `write_data` writes.
const WITHOUT_SHAPE: usize = 10;
/// The number of columns of the image flags that may follow.
const FLAGS: usize = 3;

/// Reads the section of atoms.
pub(super) fn read(
    lines: &mut Lines<'_>,
    header: &Header,
    options: &ReadOptions,
) -> Result<Import, ReadError> {
    let names = COLUMNS.map(str::to_owned).to_vec();
    let extra = Names(&names)
        .extra(&options.extra, options.all_extra)
        .map_err(|(name, message)| ReadError::part(name, message))?;
    let layout = Layout {
        id: Some(0),
        position: Position::Plain([8, 9, 10]),
        size: Size::SemiAxes([3, 4, 5]),
        powers: Powers::Blockiness([6, 7]),
        rotation: Rotation::Identity,
        color: None,
        extra,
        skips_points: false,
        names,
    };
    let mut rows = Rows::new(&layout, options, 0).in_frame(header.bounds, None);
    let mut section = header.section.clone();
    while let Some(line) = lines.next()? {
        if let Some(next) = Section::of(line) {
            section = next;
        } else if section.name == "Atoms" && !line.trim_ascii().is_empty() {
            let added = atom(line).and_then(|numbers| rows.add_numbers(&numbers));
            added.map_err(|message| ReadError::line(lines.line(), message))?;
        }
    }
    if rows.count() as u64 != header.atoms {
        let (found, wanted) = (rows.count(), header.atoms);
        return Err(ReadError::part("Atoms", format!("the section has {found} rows instead of {wanted}")));
    }
    let mut import = rows.finish()?;
    import.warnings.push("the format has no rotation; no particle is turned".to_owned());
    Ok(import)
}

/// The eleven numbers of a row.
fn atom(line: &[u8]) -> Result<Vec<f64>, String> {
    let mut numbers = row_numbers(line)?;
    let found = numbers.len();
    if found == WITHOUT_SHAPE || found == WITHOUT_SHAPE + FLAGS {
        return Err(format!(
            "the row has {found} columns: write_data of LIGGGHTS leaves out the shape of superquadrics; read a \
             dump of the particles instead"
        ));
    }
    if found != COLUMNS.len() && found != COLUMNS.len() + FLAGS {
        return Err(format!(
            "the row has {found} columns; expected {} ({})",
            COLUMNS.len(),
            COLUMNS.join(" ")
        ));
    }
    numbers.truncate(COLUMNS.len());
    Ok(numbers)
}
