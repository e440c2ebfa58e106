//! Data files of LAMMPS: atoms of the style ellipsoid (or hybrid with it) and their ellipsoids, or
//! atoms of the style sphere. Sizes are full diameters.

use std::collections::HashMap;

use superegg_geom::glam::DVec3;

use super::super::error::ReadError;
use super::super::import::Import;
use super::super::layout::{Layout, Names, Position, Powers, Rotation, Size};
use super::super::lines::Lines;
use super::super::options::ReadOptions;
use super::super::rows::Rows;
use super::header::{Header, Section, row_numbers};

const COLUMNS: [&str; 14] = [
    "id", "type", "x", "y", "z", "shapex", "shapey", "shapez", "quatw", "quati", "quatj", "quatk", "block1",
    "block2",
];

/// The styles of atoms that have a size.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Style {
    /// id type ellipsoidflag density x y z
    Ellipsoid,
    /// id type x y z and the columns of other styles
    Hybrid,
    /// id type diameter density x y z
    Sphere,
}

/// An atom.
struct Atom {
    kind: f64,
    position: DVec3,
    /// The size and the rotation: those of a sphere, or of its ellipsoid.
    body: Option<[f64; 9]>,
}

/// Reads the sections of atoms and ellipsoids.
pub(super) fn read(
    lines: &mut Lines<'_>,
    header: &Header,
    options: &ReadOptions,
) -> Result<Import, ReadError> {
    let mut atoms: Vec<(f64, u64, Atom)> = Vec::new();
    let mut ellipsoids: HashMap<u64, (u64, [f64; 9])> = HashMap::new();
    let mut section = header.section.clone();
    while let Some(line) = lines.next()? {
        if let Some(next) = Section::of(line) {
            section = next;
            continue;
        }
        if line.trim_ascii().is_empty() {
            continue;
        }
        let line = line.to_vec();
        let at_line = |message: String| ReadError::line(lines.line(), message);
        if section.name == "Atoms" {
            let style = style(&section.hint, header).map_err(at_line)?;
            let (id, atom) = row_numbers(&line).and_then(|numbers| atom(&numbers, style)).map_err(at_line)?;
            atoms.push((id, lines.line(), atom));
        } else if section.name == "Ellipsoids" {
            let (id, body) = row_numbers(&line).and_then(|numbers| ellipsoid(&numbers)).map_err(at_line)?;
            if ellipsoids.insert(id.to_bits(), (lines.line(), body)).is_some() {
                return Err(at_line(format!("the ellipsoid of atom {id} stands twice")));
            }
        }
    }
    for (name, found, wanted) in
        [("Atoms", atoms.len(), header.atoms), ("Ellipsoids", ellipsoids.len(), header.ellipsoids)]
    {
        if found as u64 != wanted {
            return Err(ReadError::part(name, format!("the section has {found} rows instead of {wanted}")));
        }
    }
    join(atoms, ellipsoids, header, options)
}

/// Joins atoms and their ellipsoids.
fn join(
    atoms: Vec<(f64, u64, Atom)>,
    mut ellipsoids: HashMap<u64, (u64, [f64; 9])>,
    header: &Header,
    options: &ReadOptions,
) -> Result<Import, ReadError> {
    let layout = layout(options)?;
    let mut rows = Rows::new(&layout, options, atoms.len() as u64).in_frame(header.bounds, None);
    let mut points = 0;
    for (id, line, atom) in atoms {
        let own = ellipsoids.remove(&id.to_bits());
        let line = own.map_or(line, |(line, _)| line);
        let Some(body) = own.map(|(_, body)| body).or(atom.body) else {
            points += 1;
            continue;
        };
        let mut numbers = vec![id, atom.kind];
        numbers.extend(atom.position.to_array());
        numbers.extend(body);
        rows.add_numbers(&numbers).map_err(|message| ReadError::line(line, message))?;
    }
    if let Some((line, _)) = ellipsoids.into_values().min_by_key(|(line, _)| *line) {
        return Err(ReadError::line(line, "there is no atom of this id"));
    }
    let mut import = rows.finish()?;
    if points > 0 {
        import.warnings.push(format!("{points} atoms have no ellipsoid: points; they are left out"));
    }
    Ok(import)
}

fn layout(options: &ReadOptions) -> Result<Layout, ReadError> {
    let names = COLUMNS.map(str::to_owned).to_vec();
    let extra = Names(&names)
        .extra(&options.extra, options.all_extra)
        .map_err(|(name, message)| ReadError::part(name, message))?;
    Ok(Layout {
        id: Some(0),
        position: Position::Plain([2, 3, 4]),
        size: Size::Diameters([5, 6, 7]),
        powers: Powers::Blockiness([12, 13]),
        rotation: Rotation::Quaternion([8, 9, 10, 11]),
        color: None,
        extra,
        skips_points: false,
        names,
    })
}

/// The style of atoms, by the comment behind `Atoms` or the header.
fn style(hint: &str, header: &Header) -> Result<Style, String> {
    match hint.split_whitespace().next() {
        Some("ellipsoid") => Ok(Style::Ellipsoid),
        Some("hybrid") => Ok(Style::Hybrid),
        Some("sphere") => Ok(Style::Sphere),
        None if header.ellipsoids > 0 => Ok(Style::Ellipsoid),
        Some(other) => {
            Err(format!("atoms of the style '{other}' have no size; expected ellipsoid or sphere"))
        }
        None => {
            Err("the style of the atoms is not given; write Atoms # ellipsoid or Atoms # sphere".to_owned())
        }
    }
}

fn atom(numbers: &[f64], style: Style) -> Result<(f64, Atom), String> {
    let atom = match (style, numbers) {
        (Style::Ellipsoid, &[id, kind, _, _, x, y, z] | &[id, kind, _, _, x, y, z, _, _, _]) => {
            (id, Atom { kind, position: DVec3::new(x, y, z), body: None })
        }
        (Style::Sphere, &[id, kind, size, _, x, y, z] | &[id, kind, size, _, x, y, z, _, _, _]) => {
            let body = [size, size, size, 1.0, 0.0, 0.0, 0.0, 2.0, 2.0];
            (id, Atom { kind, position: DVec3::new(x, y, z), body: Some(body) })
        }
        (Style::Hybrid, &[id, kind, x, y, z, ..]) => {
            (id, Atom { kind, position: DVec3::new(x, y, z), body: None })
        }
        (Style::Ellipsoid, _) => {
            return Err(columns(numbers, "7 or 10 (id type ellipsoidflag density x y z)"));
        }
        (Style::Sphere, _) => return Err(columns(numbers, "7 or 10 (id type diameter density x y z)")),
        (Style::Hybrid, _) => return Err(columns(numbers, "at least 5 (id type x y z)")),
    };
    Ok(atom)
}

/// A row of the section Ellipsoids; block1 and block2 since 2026.
fn ellipsoid(numbers: &[f64]) -> Result<(f64, [f64; 9]), String> {
    match *numbers {
        [id, a, b, c, w, x, y, z] => Ok((id, [a, b, c, w, x, y, z, 2.0, 2.0])),
        [id, a, b, c, w, x, y, z, n1, n2] => Ok((id, [a, b, c, w, x, y, z, n1, n2])),
        _ => {
            Err(columns(numbers, "8 or 10 (id shapex shapey shapez quatw quati quatj quatk [block1 block2])"))
        }
    }
}

fn columns(numbers: &[f64], wanted: &str) -> String {
    format!("the row has {} columns; expected {wanted}", numbers.len())
}
