//! The columns of a dump: which program wrote them, and what they mean.

use super::super::column_map;
use super::super::error::ReadError;
use super::super::format::Format;
use super::super::layout::{Layout, Names, Position, Powers, Rotation, Size};
use super::super::options::ReadOptions;
use super::header::Style;

const SHAPE: [&str; 3] = ["shapex", "shapey", "shapez"];
const QUATERNION: [&str; 4] = ["quat1", "quat2", "quat3", "quat4"];
const NAMED_QUATERNION: [&str; 4] = ["quatw", "quati", "quatj", "quatk"];
const ROUNDNESS: [&str; 2] = ["SuperquadricRoundnessPhi", "SuperquadricRoundnessTheta"];
/// The names of LIGGGHTS for the powers n1, n2; the second ones are older.
const BLOCKINESS: [[&str; 2]; 2] = [["blockiness1", "blockiness2"], ["roundness1", "roundness2"]];
/// The names of LAMMPS.
const BLOCK: [&str; 2] = ["block1", "block2"];
const PLAIN: [[&str; 3]; 2] = [["x", "y", "z"], ["xu", "yu", "zu"]];
const SCALED: [[&str; 3]; 2] = [["xs", "ys", "zs"], ["xsu", "ysu", "zsu"]];
/// Parts of the names that users give to the arrays c_NAME[i] of LAMMPS.
const SHAPE_WORDS: [&str; 3] = ["shape", "diam", "size"];
const ROTATION_WORDS: [&str; 2] = ["orient", "quat"];
const BLOCK_WORDS: [&str; 1] = ["block"];

/// The program of a dump with these columns.
///
/// # Errors
/// [`ReadError::Ambiguous`] if the sizes may be semi-axes or diameters.
pub(super) fn format_of(names: &[String], style: Style) -> Result<Format, ReadError> {
    let names = Names(names);
    let any = |wanted: &[&str]| wanted.iter().any(|name| names.one(name).is_some());
    if any(&ROUNDNESS) {
        return Ok(Format::OvitoDump);
    }
    let is_liggghts = any(&QUATERNION) || BLOCKINESS.iter().any(|pair| any(pair));
    let has_rotation_array = array::<4>(names, &ROTATION_WORDS).is_some();
    let is_lammps =
        any(&["quatw"]) || any(&BLOCK) || has_rotation_array || array::<2>(names, &BLOCK_WORDS).is_some();
    let has_shape = names.all(SHAPE).is_some();
    let has_shape_array = array::<3>(names, &SHAPE_WORDS).is_some();
    if is_liggghts && !is_lammps {
        return Ok(Format::LiggghtsDump);
    }
    if has_shape && is_liggghts == is_lammps {
        let what = "shapex, shapey, shapez are semi-axes in a dump of LIGGGHTS and diameters in one of LAMMPS, \
                    and no other column decides";
        return Err(ambiguous(what, [Format::LiggghtsDump, Format::LammpsDump]));
    }
    // OVITO names its columns c_shape[i] and quatw, and LAMMPS may.
    if has_shape_array && !has_rotation_array {
        return match style {
            Style::Lammps => Ok(Format::LammpsDump),
            Style::General => Ok(Format::OvitoDump),
            Style::Plain => {
                let what = "c_shape[1] to c_shape[3] are semi-axes in a dump of OVITO and diameters in one of \
                            LAMMPS, and nothing decides";
                Err(ambiguous(what, [Format::OvitoDump, Format::LammpsDump]))
            }
        };
    }
    if is_lammps {
        return Ok(Format::LammpsDump);
    }
    // Spheres and points mean the same everywhere.
    Ok(match style {
        Style::Lammps => Format::LammpsDump,
        Style::General => Format::OvitoDump,
        Style::Plain => Format::LiggghtsDump,
    })
}

fn ambiguous(what: &str, candidates: [Format; 2]) -> ReadError {
    ReadError::Ambiguous { what: what.to_owned(), candidates: candidates.map(Format::name).to_vec() }
}

/// The stem and the columns of `c_NAME[1]` to `c_NAME[N]` (or `f_`, `v_`) where NAME has one of the
/// words.
fn array<'a, const N: usize>(names: Names<'a>, words: &[&str]) -> Option<(&'a str, [usize; N])> {
    let has_word = |stem: &str| {
        let stem = stem.to_ascii_lowercase();
        ["c_", "f_", "v_"].iter().any(|kind| stem.starts_with(kind))
            && words.iter().any(|word| stem.contains(word))
    };
    let stems = names.0.iter().filter_map(|name| name.strip_suffix("[1]")).filter(|stem| has_word(stem));
    stems.into_iter().find_map(|stem| {
        let own: [String; N] = std::array::from_fn(|index| format!("{stem}[{}]", index + 1));
        let columns = names.all(own.each_ref().map(String::as_str))?;
        names.one(&format!("{stem}[{}]", N + 1)).is_none().then_some((stem, columns))
    })
}

/// The meaning of the columns of a format, with warnings about it.
///
/// # Errors
/// There are no positions, or a column that was asked for is not there.
pub(super) fn layout(
    names: Vec<String>,
    format: Format,
    options: &ReadOptions,
) -> Result<(Layout, Vec<String>), ReadError> {
    let held = Names(&names);
    let (rotation, order_warning) = rotation(held);
    let position = match (held.any(&PLAIN), held.any(&SCALED)) {
        (Some(columns), _) => Some(Position::Plain(columns)),
        (None, Some(columns)) => Some(Position::Scaled(columns)),
        (None, None) => None,
    };
    let maps_position = options.columns.as_ref().is_some_and(column_map::has_position);
    if position.is_none() && !maps_position {
        let message = "the dump has no position: columns x y z, xu yu zu, xs ys zs or xsu ysu zsu";
        return Err(ReadError::part("x", message));
    }
    let extra = held
        .extra(&options.extra, options.all_extra)
        .map_err(|(name, message)| ReadError::part(name, message))?;
    let mut layout = Layout {
        id: held.one("id"),
        position: position.unwrap_or(Position::Plain([0; 3])),
        size: size(held, format),
        powers: powers(held),
        rotation,
        color: held.all(["ColorR", "ColorG", "ColorB"]),
        extra,
        skips_points: format == Format::LammpsDump && options.min_axis.is_none(),
        names,
    };
    if let Some(map) = &options.columns {
        column_map::assign(map, &mut layout)?;
    }
    let mut warnings = Vec::new();
    match layout.rotation {
        Rotation::Identity if matches!(layout.size, Size::SemiAxes(_) | Size::Diameters(_)) => {
            warnings.push("the dump has no quaternion columns; no particle is turned".to_owned());
        }
        found if found == rotation => warnings.extend(order_warning),
        _ => {}
    }
    if layout.size == Size::Point {
        warnings.push("the dump has no size columns; particles are shown as points".to_owned());
    }
    Ok((layout, warnings))
}

fn size(names: Names<'_>, format: Format) -> Size {
    let columns = names.all(SHAPE).or_else(|| array::<3>(names, &SHAPE_WORDS).map(|(_, columns)| columns));
    if let Some(columns) = columns {
        return if format == Format::LammpsDump { Size::Diameters(columns) } else { Size::SemiAxes(columns) };
    }
    if let Some(radius) = names.one("radius") {
        return Size::Radius(radius);
    }
    names.one("diameter").map_or(Size::Point, Size::Diameter)
}

fn powers(names: Names<'_>) -> Powers {
    if let Some(columns) = names.all(ROUNDNESS) {
        return Powers::Roundness(columns);
    }
    let columns = names.any(&BLOCKINESS).or_else(|| names.all(BLOCK));
    let columns = columns.or_else(|| array::<2>(names, &BLOCK_WORDS).map(|(_, columns)| columns));
    columns.map_or(Powers::Round, Powers::Blockiness)
}

/// The columns of the rotation, and a warning if the file does not say their order.
fn rotation(names: Names<'_>) -> (Rotation, Option<String>) {
    if let Some(columns) = names.all(QUATERNION).or_else(|| names.all(NAMED_QUATERNION)) {
        return (Rotation::Quaternion(columns), None);
    }
    let Some((stem, [first, second, third, fourth])) = array::<4>(names, &ROTATION_WORDS) else {
        return (Rotation::Identity, None);
    };
    // OVITO's manual has c_orient as x y z w; LAMMPS lists its attributes as quatw quati quatj quatk.
    let (columns, order) = if stem.to_ascii_lowercase().contains("orient") {
        ([fourth, first, second, third], "x y z w")
    } else {
        ([first, second, third, fourth], "w x y z")
    };
    let warning = format!(
        "{stem}[1] to {stem}[4] are taken as {order}; the file does not say their order: \
         --columns quaternion=W,X,Y,Z sets another"
    );
    (Rotation::Quaternion(columns), Some(warning))
}
