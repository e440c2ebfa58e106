//! Particles as a table of instances, coloured by a column.

use std::collections::HashMap;

use colorgrad::{BasisGradient, Gradient, preset};
use superegg_geom::Exponents;
use superegg_geom::glam::DVec3;
use superegg_scene::{InstanceTable, Material, TableBuilder};

use crate::read::{Particles, ReadError};
use crate::srgb::linear_of_srgb;

/// The number of colours of a colour map in a picture.
const STEPS: usize = 256;

/// A colour map.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Colormap {
    /// Purple over green to yellow; even in lightness and for colour-blind readers.
    #[default]
    Viridis,
    /// Blue over purple to yellow, even in lightness.
    Plasma,
    /// Black over purple to yellow, even in lightness.
    Inferno,
    /// Black over purple to white, even in lightness.
    Magma,
    /// Blue to yellow, for colour-blind readers.
    Cividis,
    /// Blue over green to red; vivid.
    Turbo,
    /// Blue over white to red, for values around a middle.
    Coolwarm,
    /// Red over yellow to blue, for values around a middle.
    Spectral,
    /// White to black.
    Greys,
    /// A full circle of hues, for angles.
    Sinebow,
}

impl Colormap {
    /// All colour maps.
    pub const ALL: &[Self] = &[
        Self::Viridis,
        Self::Plasma,
        Self::Inferno,
        Self::Magma,
        Self::Cividis,
        Self::Turbo,
        Self::Coolwarm,
        Self::Spectral,
        Self::Greys,
        Self::Sinebow,
    ];

    /// The name for `--colormap`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Viridis => "viridis",
            Self::Plasma => "plasma",
            Self::Inferno => "inferno",
            Self::Magma => "magma",
            Self::Cividis => "cividis",
            Self::Turbo => "turbo",
            Self::Coolwarm => "coolwarm",
            Self::Spectral => "spectral",
            Self::Greys => "greys",
            Self::Sinebow => "sinebow",
        }
    }

    /// The linear colours of equal steps from 0 to 1.
    ///
    /// ```
    /// use superegg_exchange::coloring::Colormap;
    /// let [first, last] = [0, 1].map(|i| Colormap::Viridis.colors(2)[i]);
    /// assert!(first.z > first.y && last.y > last.z);
    /// ```
    pub fn colors(self, count: usize) -> Vec<DVec3> {
        match self {
            Self::Viridis => steps(&preset::viridis(), count),
            Self::Plasma => steps(&preset::plasma(), count),
            Self::Inferno => steps(&preset::inferno(), count),
            Self::Magma => steps(&preset::magma(), count),
            Self::Cividis => steps(&preset::cividis(), count),
            Self::Turbo => steps(&preset::turbo(), count),
            Self::Coolwarm => {
                let mut colors = steps::<BasisGradient>(&preset::rd_bu(), count);
                colors.reverse();
                colors
            }
            Self::Spectral => steps::<BasisGradient>(&preset::spectral(), count),
            Self::Greys => steps::<BasisGradient>(&preset::greys(), count),
            Self::Sinebow => steps(&preset::sinebow(), count),
        }
    }
}

fn steps<G: Gradient>(gradient: &G, count: usize) -> Vec<DVec3> {
    let last = count.saturating_sub(1).max(1) as f32;
    let color = |step: usize| {
        let [r, g, b, _] = gradient.at(step as f32 / last).to_linear_rgba();
        DVec3::new(r.into(), g.into(), b.into()).clamp(DVec3::ZERO, DVec3::ONE)
    };
    (0..count).map(color).collect()
}

/// Linear colours of types, well apart also for colour-blind readers (Okabe and Ito, 2008).
const TYPE_COLORS: [[u8; 3]; 8] = [
    [230, 159, 0],
    [86, 180, 233],
    [0, 158, 115],
    [240, 228, 66],
    [0, 114, 178],
    [213, 94, 0],
    [204, 121, 167],
    [128, 128, 128],
];

/// How particles get their colours.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Coloring {
    /// The colours of the file, or one colour for all.
    #[default]
    Own,
    /// By the type column, from a list of eight colours.
    ByType,
    /// By a numeric column.
    ByColumn(ColorBy),
}

/// A numeric column as colour.
#[derive(Clone, Debug, PartialEq)]
pub struct ColorBy {
    /// The column, `speed` for the length of vx, vy, vz, `force` for that of fx, fy, fz, or names
    /// joined by commas for the length of that vector.
    pub column: String,
    /// The colour map.
    pub map: Colormap,
    /// The values at the ends of the map; those of the data if `None`.
    pub range: Option<[f64; 2]>,
}

impl Coloring {
    /// The columns of the file that the colours need.
    pub fn columns(&self) -> Vec<String> {
        let names: &[&str] = match self {
            Self::Own => &[],
            Self::ByType => &["type"],
            Self::ByColumn(by) => match by.column.as_str() {
                "speed" => &["vx", "vy", "vz"],
                "force" => &["fx", "fy", "fz"],
                "id" => &[],
                column => return column.split(',').map(|name| name.trim().to_owned()).collect(),
            },
        };
        names.iter().map(|name| (*name).to_owned()).collect()
    }
}

/// A table with the meaning of its colours.
#[derive(Clone, Debug, PartialEq)]
pub struct ColoredTable {
    /// The rows.
    pub table: InstanceTable,
    /// The meaning of the colours.
    pub key: ColorKey,
}

/// The meaning of the colours of a table.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum ColorKey {
    /// None that a number has.
    #[default]
    None,
    /// The types of the rows, in order; each has the colour [`type_color`].
    Types(Vec<f64>),
    /// The values at the ends of the colour map.
    Range([f64; 2]),
}

impl ColorKey {
    /// The key of two tables together.
    #[must_use]
    pub fn union(self, other: Self) -> Self {
        match (self, other) {
            (Self::Range([a, b]), Self::Range([c, d])) => Self::Range([a.min(c), b.max(d)]),
            (Self::Types(types), Self::Types(others)) => Self::of_types(types.into_iter().chain(others)),
            (Self::None, key) | (key, _) => key,
        }
    }

    fn of_types(types: impl Iterator<Item = f64>) -> Self {
        let mut types: Vec<f64> = types.collect();
        types.sort_by(f64::total_cmp);
        types.dedup_by_key(|value| value.to_bits());
        Self::Types(types)
    }
}

/// The linear colour of rows of a type: one of eight, in turn. Types count from 1.
pub fn type_color(value: f64) -> DVec3 {
    let index = value.rem_euclid(TYPE_COLORS.len() as f64) as usize;
    let before = (index + TYPE_COLORS.len() - 1) % TYPE_COLORS.len();
    DVec3::from(TYPE_COLORS[before].map(|byte| linear_of_srgb(f64::from(byte) / 255.0)))
}

/// The position of a value in a range, from 0 to 1; the middle for a range without width. NaN for
/// NaN.
///
/// ```
/// use superegg_exchange::coloring::share_of;
/// assert_eq!([share_of(3.0, [2.0, 4.0]), share_of(9.0, [2.0, 4.0])], [0.5, 1.0]);
/// ```
pub fn share_of(value: f64, [low, high]: [f64; 2]) -> f64 {
    let share = match high - low {
        width if width.is_finite() && width > 0.0 => (value - low) / width,
        // The width overflows.
        width if width > 0.0 => (0.5 * value - 0.5 * low) / (0.5 * high - 0.5 * low),
        _ => 0.5,
    };
    if value.is_nan() { value } else { share.clamp(0.0, 1.0) }
}

/// The colours of a colour map, as tables have them.
#[derive(Clone, Debug, PartialEq)]
pub struct Palette(Vec<DVec3>);

impl Palette {
    /// The palette of a colour map.
    pub fn of(map: Colormap) -> Self {
        Self(map.colors(STEPS))
    }

    /// The linear colour of a share from 0 to 1; `None` for NaN.
    pub fn color(&self, share: f64) -> Option<DVec3> {
        let index = ((share.clamp(0.0, 1.0) * STEPS as f64) as usize).min(STEPS - 1);
        (!share.is_nan()).then(|| self.0[index])
    }
}

/// The colour of particles without one: a light grey.
const PLAIN: DVec3 = DVec3::splat(0.75);
/// The colour of values that are not numbers: a dark grey.
const NOT_A_NUMBER: DVec3 = DVec3::splat(0.1);

/// Particles as a table of instances, with a material for each colour.
///
/// # Errors
/// A column is missing, or the exponents or semi-axes of a row make no superquadric.
///
/// ```
/// use superegg_exchange::coloring::{Coloring, to_table};
/// use superegg_exchange::read::Particles;
/// use superegg_geom::glam::{DQuat, DVec3};
///
/// let mut grains = Particles::default();
/// grains.push(DVec3::X, DVec3::new(1.0, 1.0, 2.0), [1.0, 0.5], DQuat::IDENTITY);
/// let table = to_table(&grains, &Coloring::Own)?.table;
/// assert_eq!((table.len(), table.position(0)), (1, DVec3::X));
/// # Ok::<(), superegg_exchange::read::ReadError>(())
/// ```
pub fn to_table(particles: &Particles, coloring: &Coloring) -> Result<ColoredTable, ReadError> {
    let mut builder = TableBuilder::default();
    builder.reserve(particles.len());
    let colors = Colors::of(particles, coloring)?;
    let mut materials: HashMap<[u64; 3], u32> = HashMap::new();
    // Neighbours often have the same colour.
    let mut last = (DVec3::NAN, 0);
    for row in 0..particles.len() {
        let color = colors.of_row(row);
        if color != last.0 {
            let bits = color.to_array().map(f64::to_bits);
            let new = || builder.material(Material { color, ..Material::default() });
            last = (color, *materials.entry(bits).or_insert_with(new));
        }
        let [e, n] = particles.exponents[row];
        let wrong =
            |error: superegg_geom::ShapeError| ReadError::File(format!("particle {}: {error}", row + 1));
        let exponents = Exponents::new(e, n).map_err(wrong)?;
        let shape = builder.shape(particles.radii[row], exponents, last.1).map_err(wrong)?;
        let id = particles.ids.get(row).copied();
        builder.push(shape, particles.positions[row], particles.rotations[row], id);
    }
    Ok(ColoredTable { table: builder.finish(), key: colors.key() })
}

/// The colours of rows.
enum Colors<'a> {
    Plain,
    File(&'a [[f32; 3]]),
    Types(&'a [f64]),
    Scaled { values: Values<'a>, range: [f64; 2], palette: Palette },
}

/// The values of a column: one column, ids, or the length of a vector.
enum Values<'a> {
    Ids(&'a [i64]),
    Column(&'a [f64]),
    Length(Vec<&'a [f64]>),
}

impl Values<'_> {
    fn at(&self, row: usize) -> f64 {
        match self {
            Self::Ids(ids) => ids[row] as f64,
            Self::Column(values) => values[row],
            Self::Length(columns) => {
                columns.iter().map(|values| values[row] * values[row]).sum::<f64>().sqrt()
            }
        }
    }
}

impl<'a> Colors<'a> {
    fn of(particles: &'a Particles, coloring: &Coloring) -> Result<Self, ReadError> {
        let by = match coloring {
            Coloring::Own if particles.colors.is_empty() => return Ok(Self::Plain),
            Coloring::Own => return Ok(Self::File(&particles.colors)),
            Coloring::ByType => return Ok(Self::Types(column(particles, "type")?)),
            Coloring::ByColumn(by) => by,
        };
        let names = coloring.columns();
        let values = match &names[..] {
            [] if particles.ids.is_empty() && !particles.is_empty() => {
                return Err(ReadError::part("id", "the file has no ids to colour by"));
            }
            [] => Values::Ids(&particles.ids),
            [name] => Values::Column(column(particles, name)?),
            _ => Values::Length(names.iter().map(|name| column(particles, name)).collect::<Result<_, _>>()?),
        };
        let of_data = || {
            let rows = (0..particles.len()).map(|row| values.at(row)).filter(|value| value.is_finite());
            let [least, most] = rows.fold([f64::INFINITY, f64::NEG_INFINITY], |[least, most], value| {
                [least.min(value), most.max(value)]
            });
            if least > most { [0.0, 1.0] } else { [least, most] }
        };
        let range = by.range.unwrap_or_else(of_data);
        Ok(Self::Scaled { values, range, palette: Palette::of(by.map) })
    }

    fn of_row(&self, row: usize) -> DVec3 {
        match self {
            Self::Plain => PLAIN,
            Self::File(colors) => DVec3::from(colors[row].map(f64::from)).clamp(DVec3::ZERO, DVec3::ONE),
            Self::Types(types) => type_color(types[row]),
            Self::Scaled { values, range, palette } => {
                palette.color(share_of(values.at(row), *range)).unwrap_or(NOT_A_NUMBER)
            }
        }
    }

    fn key(&self) -> ColorKey {
        match self {
            Self::Plain | Self::File(_) => ColorKey::None,
            Self::Types(types) => ColorKey::of_types(types.iter().copied()),
            Self::Scaled { range, .. } => ColorKey::Range(*range),
        }
    }
}

fn column<'a>(particles: &'a Particles, name: &str) -> Result<&'a [f64], ReadError> {
    let held = particles.extra.iter().find(|(held, _)| held == name);
    let held = held.or_else(|| particles.extra.iter().find(|(held, _)| held.eq_ignore_ascii_case(name)));
    match held {
        Some((_, values)) if values.len() == particles.len() => Ok(values),
        Some(_) => Err(ReadError::part(name, "it has not one value for each particle")),
        None => {
            let names: Vec<&str> = particles.extra.iter().map(|(held, _)| held.as_str()).collect();
            let known = if names.is_empty() { "none".to_owned() } else { names.join(", ") };
            Err(ReadError::part(name, format!("the file has no such column; it has {known}")))
        }
    }
}
