//! VTK's legacy files, versions 1 to 5.1, ASCII and binary (big endian).

use std::ops::ControlFlow;

use superegg_geom::glam::DVec3;

use super::super::error::ReadError;
use super::super::scalars::{ByteOrder, Scalar, parse_number, shortened};
use super::data_set::{
    Array, DataSet, Kind, Lattice, Wanted, extent_count, is_step_name, points_of, rectilinear_points,
    rectilinear_spacing,
};

/// Whether these bytes begin a legacy file.
pub(super) fn is_legacy(head: &[u8]) -> bool {
    head.starts_with(b"# vtk DataFile Version")
}

/// Reads a legacy file; only its structure without `wanted`.
pub(super) fn read(bytes: &[u8], wanted: Option<Wanted<'_>>) -> Result<DataSet, ReadError> {
    let mut cursor = Cursor { bytes, at: 0, is_binary: false };
    cursor.line();
    let title = String::from_utf8_lossy(cursor.line()).trim().to_owned();
    match cursor.keyword()?.as_str() {
        "ASCII" => {}
        "BINARY" => cursor.is_binary = true,
        other => return Err(cursor.error(format!("expected ASCII or BINARY, found '{other}'"))),
    }
    let word = cursor.keyword()?;
    if word != "DATASET" {
        return Err(cursor.error(format!("expected DATASET, found '{word}'")));
    }
    let name = cursor.keyword()?;
    let Some(kind) = Kind::by_legacy_name(&name) else {
        return Err(cursor.error(format!("data sets of the kind '{name}' have no points that can be read")));
    };
    let mut data = DataSet::new(kind);
    data.title = title;
    let mut reader = Reader { cursor, wanted, data, grid: Grid::default(), section: Section::Geometry };
    while let Some(word) = reader.cursor.word() {
        let keyword = String::from_utf8_lossy(&word[..word.len().min(40)]).to_ascii_uppercase();
        if reader.part(&keyword)?.is_break() {
            return Err(reader.cursor.error(format!("'{}' is no keyword of a VTK file", shortened(word))));
        }
    }
    reader.finish()
}

/// The type of an array's entries.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Entry {
    Number(Scalar),
    /// Eight to a byte.
    Bit,
    Text,
}

impl Entry {
    fn by_name(name: &str) -> Option<Self> {
        Some(Self::Number(match name {
            "bit" => return Some(Self::Bit),
            "string" | "utf8_string" => return Some(Self::Text),
            "char" | "signed_char" | "vtktypeint8" => Scalar::I8,
            "unsigned_char" | "vtktypeuint8" => Scalar::U8,
            "short" | "vtktypeint16" => Scalar::I16,
            "unsigned_short" | "vtktypeuint16" => Scalar::U16,
            // VTK writes its own index type as int.
            "int" | "vtkidtype" | "vtktypeint32" => Scalar::I32,
            "unsigned_int" | "vtktypeuint32" => Scalar::U32,
            "long" | "long_long" | "vtktypeint64" => Scalar::I64,
            "unsigned_long" | "unsigned_long_long" | "vtktypeuint64" => Scalar::U64,
            "float" | "vtktypefloat32" => Scalar::F32,
            "double" | "vtktypefloat64" => Scalar::F64,
            _ => return None,
        }))
    }
}

/// The owner of the arrays that follow.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Section {
    Geometry,
    Points,
    /// The cells, so many.
    Cells(usize),
}

/// The points of a grid that does not list them.
#[derive(Clone, Debug, Default)]
struct Grid {
    dimensions: Option<[i64; 3]>,
    origin: DVec3,
    spacing: Option<DVec3>,
    axes: [Vec<f64>; 3],
}

struct Reader<'a, 'w> {
    cursor: Cursor<'a>,
    wanted: Option<Wanted<'w>>,
    data: DataSet,
    grid: Grid,
    section: Section,
}

impl Reader<'_, '_> {
    /// Reads the part after a keyword; breaks at any other word.
    fn part(&mut self, keyword: &str) -> Result<ControlFlow<()>, ReadError> {
        match keyword {
            "POINTS" => self.points()?,
            "DIMENSIONS" => self.dimensions()?,
            "ORIGIN" => self.grid.origin = DVec3::from_array(self.cursor.three()?),
            "SPACING" | "ASPECT_RATIO" => self.grid.spacing = Some(DVec3::from_array(self.cursor.three()?)),
            "X_COORDINATES" => self.coordinates(0)?,
            "Y_COORDINATES" => self.coordinates(1)?,
            "Z_COORDINATES" => self.coordinates(2)?,
            "VERTICES" | "LINES" | "POLYGONS" | "TRIANGLE_STRIPS" | "CELLS" => self.cells(keyword)?,
            "CELL_TYPES" => {
                let count = self.cursor.last_count()?;
                self.skip(keyword, Entry::Number(Scalar::I32), count)?;
            }
            "POINT_DATA" => {
                let count = self.cursor.count()?;
                if count != self.data.count {
                    let message = format!("POINT_DATA has {count} rows for {} points", self.data.count);
                    return Err(self.cursor.error(message));
                }
                self.section = Section::Points;
            }
            "CELL_DATA" => self.section = Section::Cells(self.cursor.count()?),
            "METADATA" => self.cursor.skip_to_blank_line(),
            "FIELD" => self.field()?,
            _ => return self.attribute(keyword),
        }
        Ok(ControlFlow::Continue(()))
    }

    /// Reads an array of the points or cells that has a keyword of its own.
    fn attribute(&mut self, keyword: &str) -> Result<ControlFlow<()>, ReadError> {
        match keyword {
            "SCALARS" => {
                let (name, entry) = (self.cursor.name()?, self.cursor.entry()?);
                let components = String::from_utf8_lossy(self.cursor.line()).trim().to_owned();
                let components = if components.is_empty() { 1 } else { self.cursor.count_in(&components)? };
                if self.cursor.is_next(b"LOOKUP_TABLE") {
                    self.cursor.line();
                }
                self.rows(name, components, entry)?;
            }
            "COLOR_SCALARS" => {
                let (name, components) = (self.cursor.name()?, self.cursor.last_count()?);
                let entry = if self.cursor.is_binary { Scalar::U8 } else { Scalar::F32 };
                self.rows(name, components, Entry::Number(entry))?;
            }
            "LOOKUP_TABLE" => {
                let (name, count) = (self.cursor.name()?, self.cursor.last_count()?);
                let entry = if self.cursor.is_binary { Scalar::U8 } else { Scalar::F32 };
                self.skip(&name, Entry::Number(entry), self.cursor.product(count, 4)?)?;
            }
            "TEXTURE_COORDINATES" => {
                let (name, components) = (self.cursor.name()?, self.cursor.count()?);
                let entry = self.cursor.last_entry()?;
                self.rows(name, components, entry)?;
            }
            "VECTORS" | "NORMALS" | "TENSORS" | "TENSORS6" | "GLOBAL_IDS" | "PEDIGREE_IDS" | "EDGE_FLAGS" => {
                let components = match keyword {
                    "VECTORS" | "NORMALS" => 3,
                    "TENSORS" => 9,
                    "TENSORS6" => 6,
                    _ => 1,
                };
                let (name, entry) = (self.cursor.name()?, self.cursor.last_entry()?);
                if keyword.starts_with("TENSORS") && self.section == Section::Points {
                    self.data.active_tensors = Some(name.clone());
                }
                self.rows(name, components, entry)?;
            }
            _ => return Ok(ControlFlow::Break(())),
        }
        Ok(ControlFlow::Continue(()))
    }

    fn points(&mut self) -> Result<(), ReadError> {
        let (count, entry) = (self.cursor.count()?, self.cursor.last_entry()?);
        let numbers = self.cursor.product(count, 3)?;
        if self.wanted.is_some() {
            let numbers = self.numbers("POINTS", entry, numbers)?;
            self.data.points = points_of(&numbers).collect();
        } else {
            self.skip("POINTS", entry, numbers)?;
        }
        self.data.count = count;
        Ok(())
    }

    fn dimensions(&mut self) -> Result<(), ReadError> {
        let mut dimensions = [0; 3];
        for dimension in &mut dimensions {
            *dimension = i64::try_from(self.cursor.count()?).unwrap_or(i64::MAX);
        }
        let Some(count) = extent_count(dimensions.map(|dimension| [1, dimension])) else {
            return Err(self.cursor.error("the dimensions are too large".to_owned()));
        };
        self.grid.dimensions = Some(dimensions);
        self.data.count = count;
        Ok(())
    }

    fn coordinates(&mut self, axis: usize) -> Result<(), ReadError> {
        let (count, entry) = (self.cursor.count()?, self.cursor.last_entry()?);
        self.grid.axes[axis] = self.numbers(["X", "Y", "Z"][axis], entry, count)?;
        Ok(())
    }

    /// Skips cells: lists of point numbers, with their lengths before version 5.
    fn cells(&mut self, keyword: &str) -> Result<(), ReadError> {
        let (count, size) = (self.cursor.count()?, self.cursor.count()?);
        self.cursor.line();
        if !self.cursor.is_next(b"OFFSETS") {
            return self.skip(keyword, Entry::Number(Scalar::I32), size);
        }
        self.cursor.word();
        let entry = self.cursor.last_entry()?;
        self.skip("OFFSETS", entry, count)?;
        let word = self.cursor.keyword()?;
        if word != "CONNECTIVITY" {
            return Err(self.cursor.error(format!("expected CONNECTIVITY, found '{word}'")));
        }
        let entry = self.cursor.last_entry()?;
        self.skip("CONNECTIVITY", entry, size)
    }

    /// Reads the arrays of a field.
    fn field(&mut self) -> Result<(), ReadError> {
        self.cursor.name()?;
        let arrays = self.cursor.count()?;
        for _ in 0..arrays {
            let mut name = self.cursor.name()?;
            if name == "METADATA" {
                self.cursor.skip_to_blank_line();
                name = self.cursor.name()?;
            }
            let (components, rows) = (self.cursor.count()?, self.cursor.count()?);
            let entry = self.cursor.last_entry()?;
            match self.section {
                Section::Points if rows == self.data.count && components > 0 => {
                    self.rows(name, components, entry)?;
                }
                Section::Points if components > 0 && self.is_wanted(&name, components) => {
                    let message = format!("the array has {rows} rows for {} points", self.data.count);
                    return Err(ReadError::part(name, message));
                }
                Section::Geometry if components == 1 && rows == 1 && is_step_name(&name) => {
                    self.data.step = self.numbers(&name, entry, 1)?.first().copied();
                }
                Section::Geometry | Section::Points | Section::Cells(_) => {
                    let count = self.cursor.product(components, rows)?;
                    self.skip(&name, entry, count)?;
                }
            }
        }
        Ok(())
    }

    fn is_wanted(&self, name: &str, components: usize) -> bool {
        self.section == Section::Points && self.wanted.is_some_and(|wanted| wanted(name, components))
    }

    /// Reads or skips an array with a row for each point or cell.
    fn rows(&mut self, name: String, components: usize, entry: Entry) -> Result<(), ReadError> {
        let rows = match self.section {
            Section::Points => self.data.count,
            Section::Cells(count) => return self.skip(&name, entry, self.cursor.product(count, components)?),
            Section::Geometry => {
                return Err(self.cursor.error(format!("the array '{name}' stands before POINT_DATA")));
            }
        };
        if components == 0 || self.data.array(&name).is_some() {
            let message =
                if components == 0 { "the array has no components" } else { "the array occurs twice" };
            return Err(ReadError::part(name, message));
        }
        let count = self.cursor.product(rows, components)?;
        let values = if self.is_wanted(&name, components) {
            self.numbers(&name, entry, count)?
        } else {
            self.skip(&name, entry, count)?;
            Vec::new()
        };
        self.data.arrays.push(Array { name, components, values });
        Ok(())
    }

    /// Reads `count` numbers.
    fn numbers(&mut self, name: &str, entry: Entry, count: usize) -> Result<Vec<f64>, ReadError> {
        let Entry::Number(scalar) = entry else {
            return Err(ReadError::part(name, "the array holds no numbers"));
        };
        if self.cursor.is_binary {
            let bytes = self.cursor.take(name, count.checked_mul(scalar.size()))?;
            return Ok(scalar.decode(bytes, ByteOrder::Big));
        }
        // A number takes at least one byte and one blank.
        let mut numbers = Vec::with_capacity(count.min(self.cursor.rest().len() / 2 + 1));
        for found in 0..count {
            let Some(word) = self.cursor.word() else {
                let message = format!("'{name}': expected {count} numbers, found {found}");
                return Err(self.cursor.error(message));
            };
            let number = parse_number(word);
            numbers.push(number.map_err(|message| self.cursor.error(format!("'{name}': {message}")))?);
        }
        Ok(numbers)
    }

    /// Skips `count` entries.
    fn skip(&mut self, name: &str, entry: Entry, count: usize) -> Result<(), ReadError> {
        match (self.cursor.is_binary, entry) {
            (true, Entry::Number(scalar)) => {
                self.cursor.take(name, count.checked_mul(scalar.size())).map(drop)
            }
            (true, Entry::Bit) => self.cursor.take(name, Some(count.div_ceil(8))).map(drop),
            (true, Entry::Text) => (0..count).try_for_each(|_| self.cursor.skip_text(name)),
            (false, Entry::Text) => {
                // The rest of the array's own line; then each text has a line.
                self.cursor.line();
                (0..count).try_for_each(|_| self.cursor.skip_line(name))
            }
            (false, Entry::Number(_) | Entry::Bit) => (0..count).try_for_each(|found| {
                let message = || format!("'{name}': expected {count} numbers, found {found}");
                self.cursor.word().map(drop).ok_or_else(|| self.cursor.error(message()))
            }),
        }
    }

    /// Completes the points of grids that do not list them.
    fn finish(mut self) -> Result<DataSet, ReadError> {
        let grid = self.grid;
        let has_values = self.data.arrays.iter().any(|array| !array.values.is_empty());
        match self.data.kind {
            Kind::ImageData => {
                let Some(dimensions) = grid.dimensions else {
                    return Err(ReadError::part("DIMENSIONS", "the line is missing"));
                };
                let spacing = grid.spacing.unwrap_or(DVec3::ONE);
                let lattice = Lattice {
                    extent: dimensions.map(|dimension| [0, dimension - 1]),
                    origin: grid.origin,
                    steps: [DVec3::X * spacing.x, DVec3::Y * spacing.y, DVec3::Z * spacing.z],
                };
                self.data.spacing = Some(lattice.spacing());
                if has_values {
                    self.data.points = lattice.points().collect();
                }
            }
            Kind::RectilinearGrid => {
                let lengths = grid.axes.each_ref().map(|axis| axis.len() as i64);
                if grid.dimensions.is_some_and(|dimensions| dimensions != lengths) {
                    return Err(ReadError::part("DIMENSIONS", "the coordinates have other counts"));
                }
                self.data.spacing = rectilinear_spacing(&grid.axes);
                if has_values {
                    self.data.points = rectilinear_points(&grid.axes).collect();
                }
            }
            Kind::StructuredGrid => {
                let listed = self.data.points.len();
                if let (Some(dimensions), true) = (grid.dimensions, self.wanted.is_some())
                    && extent_count(dimensions.map(|dimension| [1, dimension])) != Some(listed)
                {
                    return Err(ReadError::part("DIMENSIONS", format!("the file lists {listed} points")));
                }
            }
            Kind::PolyData | Kind::UnstructuredGrid => {}
        }
        Ok(self.data)
    }
}

/// A position in the bytes of a legacy file.
#[derive(Clone, Copy, Debug)]
struct Cursor<'a> {
    bytes: &'a [u8],
    at: usize,
    is_binary: bool,
}

impl<'a> Cursor<'a> {
    fn rest(&self) -> &'a [u8] {
        &self.bytes[self.at..]
    }

    /// An error in the line before the cursor; the text alone in a binary file.
    fn error(&self, message: impl Into<String>) -> ReadError {
        if self.is_binary {
            return ReadError::File(message.into());
        }
        let lines = self.bytes[..self.at].iter().filter(|byte| **byte == b'\n').count();
        ReadError::line(lines as u64 + 1, message)
    }

    /// The rest of the line, and goes to the next.
    fn line(&mut self) -> &'a [u8] {
        let rest = self.rest();
        let end = rest.iter().position(|byte| *byte == b'\n').unwrap_or(rest.len());
        self.at += (end + 1).min(rest.len());
        &rest[..end]
    }

    /// The next word, or `None` at the end.
    fn word(&mut self) -> Option<&'a [u8]> {
        let rest = self.rest();
        let start = rest.iter().position(|byte| !byte.is_ascii_whitespace())?;
        let length = rest[start..].iter().position(u8::is_ascii_whitespace).unwrap_or(rest.len() - start);
        self.at += start + length;
        Some(&rest[start..start + length])
    }

    /// The next word, which must be there, as text.
    fn text(&mut self) -> Result<String, ReadError> {
        match self.word() {
            Some(word) => Ok(String::from_utf8_lossy(&word[..word.len().min(1000)]).into_owned()),
            None => Err(self.error("the file ends early")),
        }
    }

    /// The next word in capitals.
    fn keyword(&mut self) -> Result<String, ReadError> {
        Ok(self.text()?.to_ascii_uppercase())
    }

    /// The name of an array: blanks and other signs are written as %20 and so on.
    fn name(&mut self) -> Result<String, ReadError> {
        let text = self.text()?;
        let mut bytes = Vec::with_capacity(text.len());
        let mut rest = text.as_bytes();
        while let [first, after @ ..] = rest {
            let digits =
                after.get(..2).filter(|_| *first == b'%').and_then(|two| std::str::from_utf8(two).ok());
            match digits.and_then(|two| u8::from_str_radix(two, 16).ok()) {
                Some(byte) => {
                    bytes.push(byte);
                    rest = &after[2..];
                }
                None => {
                    bytes.push(*first);
                    rest = after;
                }
            }
        }
        Ok(String::from_utf8_lossy(&bytes).into_owned())
    }

    /// The next word as a count.
    fn count(&mut self) -> Result<usize, ReadError> {
        let text = self.text()?;
        self.count_in(&text)
    }

    /// The count that ends the line before the data.
    fn last_count(&mut self) -> Result<usize, ReadError> {
        let count = self.count()?;
        if self.is_binary {
            self.line();
        }
        Ok(count)
    }

    fn count_in(&self, text: &str) -> Result<usize, ReadError> {
        let message = || format!("expected a count, found '{}'", shortened(text.as_bytes()));
        text.parse().map_err(|_| self.error(message()))
    }

    fn product(&self, a: usize, b: usize) -> Result<usize, ReadError> {
        a.checked_mul(b).ok_or_else(|| self.error("the counts are too large"))
    }

    fn three(&mut self) -> Result<[f64; 3], ReadError> {
        let mut numbers = [0.0; 3];
        for number in &mut numbers {
            let word = self.word().unwrap_or_default();
            *number = parse_number(word).map_err(|message| self.error(message))?;
        }
        Ok(numbers)
    }

    /// The next word as a type.
    fn entry(&mut self) -> Result<Entry, ReadError> {
        let text = self.text()?;
        let message = || format!("'{}' is no type of numbers that can be read", shortened(text.as_bytes()));
        Entry::by_name(&text.to_ascii_lowercase()).ok_or_else(|| self.error(message()))
    }

    /// The type that ends the line before the data.
    fn last_entry(&mut self) -> Result<Entry, ReadError> {
        let entry = self.entry()?;
        if self.is_binary {
            self.line();
        }
        Ok(entry)
    }

    /// Whether the next word is this one. Blanks are skipped in ASCII files only.
    fn is_next(&self, word: &[u8]) -> bool {
        let rest = if self.is_binary { self.rest() } else { self.rest().trim_ascii_start() };
        rest.starts_with(word)
    }

    /// The bytes of a binary array.
    fn take(&mut self, name: &str, length: Option<usize>) -> Result<&'a [u8], ReadError> {
        let rest = self.rest();
        let Some(bytes) = length.and_then(|length| rest.get(..length)) else {
            let message = format!("the file ends early: only {} bytes are left for the array", rest.len());
            return Err(ReadError::part(name, message));
        };
        self.at += bytes.len();
        Ok(bytes)
    }

    /// Skips a string of a binary file. The two highest bits of its first byte give the size of
    /// its length.
    fn skip_text(&mut self, name: &str) -> Result<(), ReadError> {
        let first = self.rest().first().copied().unwrap_or_default();
        let size = match first >> 6 {
            3 => 1,
            2 => 2,
            1 => 4,
            _ => 8,
        };
        let length =
            self.take(name, Some(size))?.iter().fold(0u64, |length, byte| length << 8 | u64::from(*byte));
        let length = length & (u64::MAX >> (66 - 8 * size));
        self.take(name, usize::try_from(length).ok()).map(drop)
    }

    fn skip_line(&mut self, name: &str) -> Result<(), ReadError> {
        if self.rest().is_empty() {
            return Err(self.error(format!("'{name}': the file ends early")));
        }
        self.line();
        Ok(())
    }

    /// Skips the lines up to the next one that is blank.
    fn skip_to_blank_line(&mut self) {
        self.line();
        while !self.line().trim_ascii().is_empty() {}
    }
}
