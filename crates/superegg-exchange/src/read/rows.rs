//! Rows of a text file on their way to particles.

use superegg_geom::glam::{DMat3, DQuat, DVec3};

use super::check;
use super::error::ReadError;
use super::import::{Content, Import};
use super::layout::{Layout, Position, Powers, Rotation, Size};
use super::number;
use super::options::ReadOptions;
use super::particles::{Particles, SimulationBox};
use super::spacing::point_radius;

/// Particles while their rows are read.
pub(super) struct Rows<'a> {
    layout: &'a Layout,
    options: &'a ReadOptions,
    /// The columns whose numbers are needed.
    wanted: Vec<bool>,
    /// A byte that separates columns besides blanks and tabs; empty columns are then kept.
    separator: Option<u8>,
    /// The numbers of one row, by column; those that are not needed are stale.
    numbers: Vec<f64>,
    /// Which of the kept columns hold text.
    is_text: Vec<bool>,
    particles: Particles,
    colors: Vec<[f32; 3]>,
    far_quaternions: usize,
    points: usize,
}

impl<'a> Rows<'a> {
    /// No rows yet. `most` is a bound of their number by the bytes that are there.
    pub(super) fn new(layout: &'a Layout, options: &'a ReadOptions, most: u64) -> Self {
        let count = usize::try_from(most).unwrap_or(0);
        let mut particles = Particles::default();
        particles.positions.reserve_exact(count);
        particles.radii.reserve_exact(count);
        particles.exponents.reserve_exact(count);
        particles.rotations.reserve_exact(count);
        if layout.id.is_some() {
            particles.ids.reserve_exact(count);
        }
        particles.extra = layout
            .extra
            .iter()
            .map(|&column| (layout.names[column].clone(), Vec::with_capacity(count)))
            .collect();
        Self {
            layout,
            options,
            wanted: layout.wanted(),
            separator: None,
            numbers: vec![0.0; layout.names.len()],
            is_text: vec![false; layout.extra.len()],
            particles,
            colors: Vec::new(),
            far_quaternions: 0,
            points: 0,
        }
    }

    /// Columns are separated by this byte.
    pub(super) fn separated_by(mut self, separator: Option<u8>) -> Self {
        self.separator = separator;
        self
    }

    /// Sets the box, for positions that are fractions of it, and the step.
    pub(super) fn in_frame(mut self, bounds: Option<SimulationBox>, step: Option<f64>) -> Self {
        self.particles.bounds = bounds;
        self.particles.step = step;
        self
    }

    /// The number of rows that were added.
    pub(super) fn count(&self) -> usize {
        self.particles.len() + self.points
    }

    /// Adds a row of text.
    pub(super) fn add(&mut self, row: &[u8]) -> Result<(), String> {
        match self.separator {
            None => self.split_blanks(row)?,
            Some(separator) => self.split_at(row, separator)?,
        }
        self.push()
    }

    /// Adds a row of numbers, one a column.
    pub(super) fn add_numbers(&mut self, numbers: &[f64]) -> Result<(), String> {
        self.numbers.copy_from_slice(numbers);
        self.push()
    }

    /// Splits a row at blanks and reads the numbers that are needed.
    fn split_blanks(&mut self, row: &[u8]) -> Result<(), String> {
        let mut rest = row;
        for column in 0..self.wanted.len() {
            rest = skip_blanks(rest);
            if rest.is_empty() {
                return Err(self.too_few(column));
            }
            if !self.wanted[column] {
                rest = &rest[number::word_length(rest)..];
            } else if let Some((value, length)) = number::parse_word(rest) {
                self.numbers[column] = value;
                rest = &rest[length..];
            } else {
                let length = number::word_length(rest);
                self.word(column, &rest[..length])?;
                rest = &rest[length..];
            }
        }
        if skip_blanks(rest).is_empty() { Ok(()) } else { Err(self.too_many()) }
    }

    /// Splits a row at a separator and reads the numbers that are needed.
    fn split_at(&mut self, row: &[u8], separator: u8) -> Result<(), String> {
        let words = split_quoted(row, separator);
        if words.len() < self.wanted.len() {
            return Err(self.too_few(words.len()));
        }
        if words.len() > self.wanted.len() {
            return Err(self.too_many());
        }
        for (column, word) in words.into_iter().enumerate() {
            if self.wanted[column] {
                self.word(column, word)?;
            }
        }
        Ok(())
    }

    fn too_few(&self, found: usize) -> String {
        format!("the row has {found} columns instead of {}", self.wanted.len())
    }

    fn too_many(&self) -> String {
        format!("the row has more than {} columns", self.wanted.len())
    }

    /// Reads the number of a column. Kept columns of text are left out if all are kept.
    fn word(&mut self, column: usize, word: &[u8]) -> Result<(), String> {
        if let Some(value) = number::parse(word) {
            self.numbers[column] = value;
            return Ok(());
        }
        let kept = self.layout.extra.iter().position(|&kept| kept == column);
        let name = &self.layout.names[column];
        if let Some(kept) = kept
            && self.options.all_extra
            && !self.options.extra.contains(name)
            && !self.is_needed(column)
        {
            self.is_text[kept] = true;
            self.numbers[column] = f64::NAN;
            return Ok(());
        }
        Err(format!("column {} ('{name}'): '{}' is not a number", column + 1, String::from_utf8_lossy(word)))
    }

    /// Whether a column is part of the particle, and not only kept.
    fn is_needed(&self, column: usize) -> bool {
        Layout { extra: Vec::new(), ..self.layout.clone() }.wanted()[column]
    }

    /// Makes a particle of the numbers.
    fn push(&mut self) -> Result<(), String> {
        let layout = self.layout;
        let numbers = &self.numbers;
        let vector = |[x, y, z]: [usize; 3]| DVec3::new(numbers[x], numbers[y], numbers[z]);
        if layout.skips_points && self.is_point() {
            self.points += 1;
            return Ok(());
        }
        let (position, columns) = match layout.position {
            Position::Plain(columns) => (vector(columns), columns),
            Position::Scaled(columns) => (unscaled(self.particles.bounds, vector(columns))?, columns),
        };
        let position = check::position(position).map_err(|message| named(layout, &columns, &message))?;
        let radii = self.radii()?;
        let exponents = self.exponents()?;
        let rotation = self.rotation()?;
        if let Some(column) = layout.id {
            let id = self.numbers[column];
            if id.fract() != 0.0 || id.abs() > 2_f64.powi(53) {
                return Err(format!("'{}' is {id}; expected an integer", layout.names[column]));
            }
            self.particles.ids.push(id as i64);
        }
        if let Some(columns) = layout.color {
            let color = columns.map(|column| self.numbers[column] as f32);
            if !color.iter().all(|part| (0.0..=255.0).contains(part)) {
                let message = "a colour lies outside of 0 to 1 and of 0 to 255";
                return Err(named(layout, &columns, message));
            }
            self.colors.push(color);
        }
        for ((_, values), &column) in self.particles.extra.iter_mut().zip(&layout.extra) {
            values.push(self.numbers[column]);
        }
        self.particles.push(position, radii, exponents, rotation);
        Ok(())
    }

    /// Whether the size and the rotation of the row are 0.
    fn is_point(&self) -> bool {
        let zero = |columns: &[usize]| columns.iter().all(|&column| self.numbers[column] == 0.0);
        let is_unsized = match &self.layout.size {
            Size::SemiAxes(columns) | Size::Diameters(columns) => zero(columns),
            Size::Radius(_) | Size::Diameter(_) | Size::Point => false,
        };
        is_unsized
            && match &self.layout.rotation {
                Rotation::Quaternion(columns) => zero(columns),
                Rotation::Identity | Rotation::Euler { .. } => false,
            }
    }

    fn radii(&self) -> Result<DVec3, String> {
        let at = |column: usize| self.numbers[column];
        let (radii, columns): (DVec3, &[usize]) = match &self.layout.size {
            Size::SemiAxes(columns) => (DVec3::from(columns.map(at)), columns),
            Size::Diameters(columns) => (DVec3::from(columns.map(at)) * 0.5, columns),
            Size::Radius(column) => (DVec3::splat(at(*column)), std::slice::from_ref(column)),
            Size::Diameter(column) => (DVec3::splat(0.5 * at(*column)), std::slice::from_ref(column)),
            Size::Point => return Ok(DVec3::ONE),
        };
        check::semi_axes(radii, self.options).map_err(|message| named(self.layout, columns, &message))
    }

    fn exponents(&self) -> Result<[f64; 2], String> {
        let at = |column: usize| self.numbers[column];
        let (exponents, columns) = match self.layout.powers {
            Powers::Round => return Ok([1.0; 2]),
            Powers::Exponents(columns) => {
                let [e, n] = columns.map(at);
                (check::exponents(e, n), columns)
            }
            Powers::Blockiness(columns) => {
                let [first, second] = columns.map(at);
                (check::exponents_of_blockiness(first, second), columns)
            }
            Powers::Roundness(columns) => {
                // OVITO writes 0 for a property that is not set: an ellipsoid.
                let [e, n] = columns.map(|column| if at(column) == 0.0 { 1.0 } else { at(column) });
                (check::exponents(e, n), columns)
            }
        };
        exponents.map_err(|message| named(self.layout, &columns, &message))
    }

    fn rotation(&mut self) -> Result<DQuat, String> {
        match self.layout.rotation {
            Rotation::Identity => Ok(DQuat::IDENTITY),
            Rotation::Quaternion(columns) => {
                let [w, x, y, z] = columns.map(|column| self.numbers[column]);
                let (rotation, is_far) =
                    check::rotation(w, x, y, z).map_err(|message| named(self.layout, &columns, &message))?;
                self.far_quaternions += usize::from(is_far);
                Ok(rotation)
            }
            Rotation::Euler { columns, axes, degrees } => {
                let angles = columns.map(|column| self.numbers[column]);
                if !angles.iter().all(|angle| angle.is_finite()) {
                    return Err(named(self.layout, &columns, "an angle is not a finite number"));
                }
                let unit = if degrees { std::f64::consts::PI / 180.0 } else { 1.0 };
                let turn = |index: usize| {
                    DQuat::from_axis_angle([DVec3::X, DVec3::Y, DVec3::Z][axes[index]], angles[index] * unit)
                };
                Ok((turn(0) * turn(1) * turn(2)).normalize())
            }
        }
    }

    /// The import, with warnings about the rows as a whole.
    pub(super) fn finish(self) -> Result<Import, ReadError> {
        let Self { layout, options, mut particles, colors, far_quaternions, points, is_text, .. } = self;
        let mut warnings = Vec::new();
        let mut reading = layout.reading();
        if layout.size == Size::Point {
            let chosen = options.point_radius.unwrap_or_else(|| point_radius(&particles.positions));
            let radius = check::semi_axes(DVec3::splat(chosen), options).map_err(ReadError::File)?;
            particles.radii.fill(radius);
            reading = format!("{reading} of radius {chosen:.6}");
        }
        let mut is_text = is_text.iter();
        particles.extra.retain(|_| !is_text.next().copied().unwrap_or(false));
        particles.colors = linear_colors(colors);
        warnings.extend(check::repeated_ids(&particles));
        if far_quaternions > 0 {
            warnings
                .push(format!("{far_quaternions} quaternions are not of unit length; they are normalized"));
        }
        if points > 0 {
            warnings
                .push(format!("{points} particles without size and rotation are points; they are left out"));
        }
        let mut import = Import::new(Content::Particles(particles), reading);
        import.warnings = warnings;
        Ok(import)
    }
}

#[inline]
fn skip_blanks(bytes: &[u8]) -> &[u8] {
    let blanks = bytes.iter().position(|byte| !number::is_blank(*byte)).unwrap_or(bytes.len());
    &bytes[blanks..]
}

/// A message with the names of the columns that it is about.
#[cold]
fn named(layout: &Layout, columns: &[usize], message: &str) -> String {
    format!("{message} ({})", layout.list(columns))
}

/// The position of fractions of the edges of a box.
fn unscaled(bounds: Option<SimulationBox>, fractions: DVec3) -> Result<DVec3, String> {
    let bounds = bounds.ok_or("scaled coordinates need the bounds of the box")?;
    let [a, b, c] = bounds.edges;
    Ok(bounds.origin + DMat3::from_cols(a, b, c) * fractions)
}

/// Colours of 0 to 255 (if one is above 1) as sRGB, others as they are.
fn linear_colors(mut colors: Vec<[f32; 3]>) -> Vec<[f32; 3]> {
    if colors.iter().flatten().any(|part| *part > 1.0) {
        let linear = |part: f32| crate::srgb::linear_of_srgb(f64::from(part) / 255.0) as f32;
        colors.iter_mut().for_each(|color| *color = color.map(linear));
    }
    colors
}

/// The words of a row between separators, without blanks and quotes around them. A quoted word may
/// hold separators.
pub(super) fn split_quoted(row: &[u8], separator: u8) -> Vec<&[u8]> {
    let mut words = Vec::new();
    let (mut start, mut is_quoted) = (0, false);
    for (at, &byte) in row.iter().enumerate() {
        if byte == b'"' {
            is_quoted = !is_quoted;
        } else if byte == separator && !is_quoted {
            words.push(unquoted(&row[start..at]));
            start = at + 1;
        }
    }
    words.push(unquoted(&row[start..]));
    words
}

fn unquoted(word: &[u8]) -> &[u8] {
    let word = word.trim_ascii();
    let inner = word.strip_prefix(b"\"").and_then(|word| word.strip_suffix(b"\""));
    inner.map_or(word, <[u8]>::trim_ascii)
}
