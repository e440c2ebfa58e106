//! The columns of a dump: which program wrote them, and what they mean.

use super::super::error::ReadError;
use super::super::format::Format;
use super::super::number;
use super::super::options::ReadOptions;

/// The columns of a position.
#[derive(Clone, Copy)]
pub(super) enum Position {
    Plain([usize; 3]),
    /// Fractions of the box.
    Scaled([usize; 3]),
}

/// The columns of a size.
#[derive(Clone, Copy)]
pub(super) enum Size {
    SemiAxes([usize; 3]),
    Diameters([usize; 3]),
    Radius(usize),
    Diameter(usize),
}

/// The columns of exponents.
#[derive(Clone, Copy)]
pub(super) enum Powers {
    /// n1, n2: n = 2/n1, e = 2/n2.
    Blockiness([usize; 2]),
    /// OVITO's phi, theta: e, n.
    Roundness([usize; 2]),
}

/// The columns of a rotation.
#[derive(Clone, Copy)]
pub(super) enum Rotation {
    None,
    /// w, x, y, z.
    Quaternion([usize; 4]),
}

/// The columns of a dump. Indices are those of the wanted numbers of a row.
pub(super) struct Columns {
    /// For each column of the file the index of its number; `None` for columns that are skipped.
    wanted: Vec<Option<usize>>,
    pub(super) id: Option<usize>,
    pub(super) position: Position,
    pub(super) size: Size,
    pub(super) exponents: Option<Powers>,
    pub(super) rotation: Rotation,
    /// Further columns that were asked for, with their names.
    pub(super) extra: Vec<(String, usize)>,
    /// How the columns are read, in one line.
    pub(super) reading: String,
    pub(super) warnings: Vec<String>,
}

const QUATERNION: [&str; 4] = ["quat1", "quat2", "quat3", "quat4"];
const NAMED_QUATERNION: [&str; 4] = ["quatw", "quati", "quatj", "quatk"];
const SHAPE: [&str; 3] = ["shapex", "shapey", "shapez"];
const ROUNDNESS: [&str; 2] = ["SuperquadricRoundnessPhi", "SuperquadricRoundnessTheta"];
/// The names that programs and their users give to the powers n1, n2.
const POWERS: [[&str; 2]; 4] = [
    ["blockiness1", "blockiness2"],
    ["roundness1", "roundness2"],
    ["block1", "block2"],
    ["blockx", "blocky"],
];

/// The program of a dump with these columns.
pub(super) fn format_of(names: &[&str]) -> Result<Format, ReadError> {
    let has = |name: &str| names.contains(&name);
    let has_array = |suffix: &str| names.iter().any(|name| name.starts_with("c_") && name.ends_with(suffix));
    let has_shape = has("shapex") || has_array("[3]");
    if ROUNDNESS.iter().any(|name| has(name)) {
        return Ok(Format::OvitoDump);
    }
    if has("quat1") || has("blockiness1") || has("roundness1") {
        return Ok(Format::LiggghtsDump);
    }
    if has("block1") || has("blockx") {
        return Ok(Format::LammpsDump);
    }
    if has_shape && has("c_shape[1]") && has("quatw") {
        return Err(ReadError::Ambiguous {
            what: "c_shape[1] to c_shape[3] are semi-axes in a dump of OVITO and diameters in one of LAMMPS"
                .to_owned(),
            candidates: vec![Format::OvitoDump.name(), Format::LammpsDump.name()],
        });
    }
    if has("quatw") || has_array("[4]") {
        return Ok(Format::LammpsDump);
    }
    if has_shape {
        return Err(ReadError::Ambiguous {
            what:
                "shapex, shapey, shapez are semi-axes in a dump of LIGGGHTS and diameters in one of LAMMPS, \
                   and no column tells which this is"
                    .to_owned(),
            candidates: vec![Format::LiggghtsDump.name(), Format::LammpsDump.name()],
        });
    }
    // Spheres and points mean the same everywhere.
    Ok(Format::LammpsDump)
}

/// Gives numbers to the columns that are wanted.
struct Wanted<'a> {
    names: &'a [&'a str],
    numbers: Vec<Option<usize>>,
    count: usize,
}

impl Wanted<'_> {
    fn one(&mut self, name: &str) -> Option<usize> {
        let column = self.names.iter().position(|held| *held == name)?;
        if self.numbers[column].is_none() {
            self.numbers[column] = Some(self.count);
            self.count += 1;
        }
        self.numbers[column]
    }

    fn all<const N: usize>(&mut self, wanted: [&str; N]) -> Option<[usize; N]> {
        if !wanted.iter().all(|name| self.names.contains(name)) {
            return None;
        }
        let mut numbers = [0; N];
        for (number, name) in numbers.iter_mut().zip(wanted) {
            *number = self.one(name)?;
        }
        Some(numbers)
    }

    /// The columns `c_NAME[1]` to `c_NAME[N]`, for the first name that has as many and no more.
    fn array<const N: usize>(&mut self) -> Option<[usize; N]> {
        let suffix = format!("[{N}]");
        let more = format!("[{}]", N + 1);
        let stems = self.names.iter().filter_map(|name| name.strip_suffix(suffix.as_str()));
        let stem = stems
            .filter(|stem| stem.starts_with("c_") || stem.starts_with("f_"))
            .find(|stem| !self.names.contains(&format!("{stem}{more}").as_str()))?
            .to_owned();
        let names: [String; N] = std::array::from_fn(|index| format!("{stem}[{}]", index + 1));
        self.all(names.each_ref().map(String::as_str))
    }
}

impl Columns {
    /// The meaning of columns in a format.
    pub(super) fn of(names: &[&str], format: Format, options: &ReadOptions) -> Result<Self, ReadError> {
        let mut wanted = Wanted { names, numbers: vec![None; names.len()], count: 0 };
        let mut warnings = Vec::new();
        let position = position(&mut wanted)?;
        let id = wanted.one("id");
        let (size, size_words) = size(&mut wanted, format)?;
        let (exponents, power_words) = powers(&mut wanted);
        let (rotation, rotation_words) = rotation(&mut wanted);
        let is_sphere = matches!(size, Size::Radius(_) | Size::Diameter(_));
        if matches!(rotation, Rotation::None) && !is_sphere {
            warnings.push("the dump has no quaternion columns; no particle is turned".to_owned());
        }
        let mut extra = Vec::new();
        let all = if options.all_extra { names.to_vec() } else { Vec::new() };
        for name in options.extra.iter().map(String::as_str).chain(all) {
            match wanted.one(name) {
                Some(number) if extra.iter().all(|(held, _)| held != name) => {
                    extra.push((name.to_owned(), number));
                }
                Some(_) => {}
                None => {
                    let known = names.join(", ");
                    return Err(ReadError::part(
                        name,
                        format!("the dump has no such column; it has {known}"),
                    ));
                }
            }
        }
        let reading = format!("sizes from {size_words}; {power_words}; {rotation_words}");
        Ok(Self { wanted: wanted.numbers, id, position, size, exponents, rotation, extra, reading, warnings })
    }

    /// The number of columns of the file.
    pub(super) fn count(&self) -> usize {
        self.wanted.len().max(1)
    }

    /// The number of wanted columns.
    pub(super) fn wanted_count(&self) -> usize {
        self.wanted.iter().flatten().count()
    }

    /// Reads the wanted numbers of a row.
    pub(super) fn parse(&self, row: &[u8], numbers: &mut [f64]) -> Result<(), String> {
        let mut rest = row;
        for (column, wanted) in self.wanted.iter().enumerate() {
            rest = skip_blanks(rest);
            if rest.is_empty() {
                let (found, count) = (column, self.wanted.len());
                return Err(format!("the row has {found} columns instead of {count}"));
            }
            let Some(index) = *wanted else {
                rest = &rest[number::word_length(rest)..];
                continue;
            };
            let parsed = number::parse_word(rest);
            let Some((value, length)) = parsed else {
                let word = String::from_utf8_lossy(&rest[..number::word_length(rest)]);
                return Err(format!("column {}: '{word}' is not a number", column + 1));
            };
            numbers[index] = value;
            rest = &rest[length..];
        }
        match skip_blanks(rest) {
            [] => Ok(()),
            _ => Err(format!("the row has more than {} columns", self.wanted.len())),
        }
    }
}

#[inline]
fn skip_blanks(bytes: &[u8]) -> &[u8] {
    let blanks = bytes.iter().position(|byte| !number::is_blank(*byte)).unwrap_or(bytes.len());
    &bytes[blanks..]
}

fn position(wanted: &mut Wanted<'_>) -> Result<Position, ReadError> {
    for plain in [["x", "y", "z"], ["xu", "yu", "zu"]] {
        if let Some(axes) = wanted.all(plain) {
            return Ok(Position::Plain(axes));
        }
    }
    for scaled in [["xs", "ys", "zs"], ["xsu", "ysu", "zsu"]] {
        if let Some(axes) = wanted.all(scaled) {
            return Ok(Position::Scaled(axes));
        }
    }
    Err(ReadError::part("x", "the dump has no position: columns x y z, xu yu zu, xs ys zs or xsu ysu zsu"))
}

fn size(wanted: &mut Wanted<'_>, format: Format) -> Result<(Size, &'static str), ReadError> {
    let axes = wanted.all(SHAPE).or_else(|| wanted.array::<3>());
    if let Some(axes) = axes {
        return Ok(match format {
            Format::LammpsDump => (Size::Diameters(axes), "shapex, shapey, shapez as diameters"),
            _ => (Size::SemiAxes(axes), "shapex, shapey, shapez as semi-axes"),
        });
    }
    if let Some(radius) = wanted.one("radius").or_else(|| wanted.one("Radius")) {
        return Ok((Size::Radius(radius), "radius"));
    }
    if let Some(diameter) = wanted.one("diameter") {
        return Ok((Size::Diameter(diameter), "diameter"));
    }
    let message = "the dump has no size: columns shapex shapey shapez, radius or diameter";
    Err(ReadError::part("shapex", message))
}

fn powers(wanted: &mut Wanted<'_>) -> (Option<Powers>, String) {
    if let Some(columns) = wanted.all(ROUNDNESS) {
        let words = "exponents e = roundness phi, n = roundness theta".to_owned();
        return (Some(Powers::Roundness(columns)), words);
    }
    for names in POWERS {
        if let Some(columns) = wanted.all(names) {
            let [first, second] = names;
            return (Some(Powers::Blockiness(columns)), format!("exponents e = 2/{second}, n = 2/{first}"));
        }
    }
    (None, "ellipsoids (no exponents)".to_owned())
}

fn rotation(wanted: &mut Wanted<'_>) -> (Rotation, &'static str) {
    if let Some(columns) = wanted.all(QUATERNION) {
        return (Rotation::Quaternion(columns), "rotation from quat1..4 as w x y z");
    }
    if let Some(columns) = wanted.all(NAMED_QUATERNION) {
        return (Rotation::Quaternion(columns), "rotation from quatw, quati, quatj, quatk");
    }
    match wanted.array::<4>() {
        Some([x, y, z, w]) => {
            (Rotation::Quaternion([w, x, y, z]), "rotation from the array of four numbers as x y z w")
        }
        None => (Rotation::None, "no rotation"),
    }
}
