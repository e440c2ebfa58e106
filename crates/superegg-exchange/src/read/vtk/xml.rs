//! VTK's XML files: ASCII, inline base64, appended raw and base64, plain and compressed by zlib,
//! both byte orders.

use std::borrow::Cow;

use quick_xml::Reader;
use quick_xml::events::{BytesStart, Event};
use superegg_geom::glam::DVec3;

use super::super::error::ReadError;
use super::super::expansion::expansion_limit;
use super::super::scalars::{ByteOrder, Scalar, parse_number, parse_numbers, shortened};
use super::data_set::{
    Array, DataSet, Kind, Lattice, Wanted, extent_count, is_step_name, points_of, rectilinear_points,
    rectilinear_spacing,
};
use super::encoded::{Encoded, Encoding};

/// Whether these bytes begin an XML file of VTK.
pub(super) fn is_xml(head: &[u8]) -> bool {
    let head = head.strip_prefix(b"\xef\xbb\xbf").unwrap_or(head).trim_ascii_start();
    let head = &head[..head.len().min(2000)];
    head.starts_with(b"<") && head.windows(8).any(|window| window == b"<VTKFile")
}

/// Reads an XML file; only its structure without `wanted`.
pub(super) fn read(bytes: &[u8], wanted: Option<Wanted<'_>>) -> Result<DataSet, ReadError> {
    let document = Document::parse(bytes)?;
    let mut data = document.outline()?;
    if let Some(wanted) = wanted {
        document.fill(&mut data, wanted, expansion_limit(bytes.len()))?;
    }
    Ok(data)
}

/// The element that an array stands in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Section {
    PointData,
    Points,
    Coordinates,
    FieldData,
    /// Cells, and data of cells.
    Other,
}

/// Where the numbers of an array are.
#[derive(Clone, Copy, Debug)]
enum Payload<'a> {
    Ascii(&'a [u8]),
    Base64(&'a [u8]),
    Appended(usize),
}

/// An array as declared.
#[derive(Clone, Debug)]
struct DataArray<'a> {
    section: Section,
    name: String,
    /// The type; `None` if it is no type of numbers.
    scalar: Option<Scalar>,
    components: usize,
    /// The number of rows, where the section does not give it.
    rows: Option<usize>,
    payload: Payload<'a>,
}

/// A piece of the data set.
#[derive(Clone, Debug)]
struct Piece<'a> {
    count: usize,
    extent: Option<[[i64; 2]; 3]>,
    arrays: Vec<DataArray<'a>>,
}

/// The structure of a file.
#[derive(Clone, Debug)]
struct Document<'a> {
    kind: Kind,
    encoding: Encoding,
    /// The compressor, if it is not zlib. ASCII arrays do not need it.
    unknown_compressor: Option<String>,
    pieces: Vec<Piece<'a>>,
    /// Arrays of the whole data set.
    fields: Vec<DataArray<'a>>,
    lattice: Lattice,
    active_tensors: Option<String>,
    appended: Option<Encoded<'a>>,
}

impl<'a> Document<'a> {
    fn parse(bytes: &'a [u8]) -> Result<Self, ReadError> {
        let mut parser = Parser { bytes, section: Section::Other, document: None, array: None };
        let mut reader = Reader::from_reader(bytes);
        loop {
            let event = reader.read_event();
            let position = usize::try_from(reader.buffer_position()).unwrap_or(bytes.len());
            let event = event.map_err(|error| line_error(bytes, position, format!("wrong XML: {error}")))?;
            match event {
                Event::Start(element) if element.name().as_ref() == b"AppendedData" => {
                    parser.appended(&element, position)?;
                    break;
                }
                Event::Start(element) => parser.start(&element, position)?,
                Event::Empty(element) => {
                    parser.start(&element, position)?;
                    parser.end(element.name().as_ref());
                }
                Event::End(element) => parser.end(element.name().as_ref()),
                Event::Text(text) => {
                    // Text of a slice is never copied.
                    if let Cow::Borrowed(text) = text.into_inner() {
                        parser.text(text);
                    }
                }
                Event::Eof => break,
                Event::CData(_)
                | Event::Comment(_)
                | Event::Decl(_)
                | Event::PI(_)
                | Event::DocType(_)
                | Event::GeneralRef(_) => {}
            }
        }
        parser.document.ok_or_else(|| ReadError::part("VTKFile", "the element is missing"))
    }

    /// The data set without points and numbers.
    fn outline(&self) -> Result<DataSet, ReadError> {
        let mut data = DataSet::new(self.kind);
        data.active_tensors.clone_from(&self.active_tensors);
        let sum = self.pieces.iter().try_fold(0usize, |sum, piece| sum.checked_add(piece.count));
        data.count = sum.ok_or_else(|| ReadError::part("Piece", "the counts are too large"))?;
        let Some(piece) = self.pieces.iter().find(|piece| piece.count > 0).or(self.pieces.first()) else {
            return Ok(data);
        };
        for array in piece.arrays.iter().filter(|array| array.section == Section::PointData) {
            if data.array(&array.name).is_some() {
                return Err(ReadError::part(&array.name, "the array occurs twice"));
            }
            let (name, components) = (array.name.clone(), array.components);
            data.arrays.push(Array { name, components, values: Vec::new() });
        }
        Ok(data)
    }

    /// Reads the arrays that are wanted, then the points.
    fn fill(&self, data: &mut DataSet, wanted: Wanted<'_>, limit: u64) -> Result<(), ReadError> {
        let mut decoder = Decoder { document: self, left: limit, limit };
        let step = self.fields.iter().find(|array| is_step_name(&array.name) && array.components == 1);
        if let Some(step) = step.filter(|step| step.rows.is_none_or(|rows| rows == 1)) {
            data.step = decoder.numbers(step, 1)?.first().copied();
        }
        for array in data.arrays.iter_mut().filter(|array| wanted(&array.name, array.components)) {
            for piece in self.pieces.iter().filter(|piece| piece.count > 0) {
                let found = piece.arrays.iter().find(|found| {
                    found.section == Section::PointData
                        && found.name == array.name
                        && found.components == array.components
                });
                let Some(found) = found else {
                    return Err(ReadError::part(&array.name, "a piece of the file lacks the array"));
                };
                let numbers = decoder.numbers(found, piece.count)?;
                if array.values.is_empty() {
                    array.values = numbers;
                } else {
                    array.values.extend(numbers);
                }
            }
        }
        let has_values = data.arrays.iter().any(|array| !array.values.is_empty());
        for piece in self.pieces.iter().filter(|piece| piece.count > 0) {
            match self.kind {
                Kind::PolyData | Kind::UnstructuredGrid | Kind::StructuredGrid => {
                    decoder.listed_points(piece, data)?;
                }
                Kind::RectilinearGrid => decoder.rectilinear_points(piece, data, has_values)?,
                Kind::ImageData => {
                    let lattice = Lattice { extent: piece.extent.unwrap_or_default(), ..self.lattice };
                    data.spacing = data.spacing.into_iter().chain([lattice.spacing()]).reduce(f64::min);
                    if has_values {
                        data.points.extend(lattice.points());
                    }
                }
            }
        }
        Ok(())
    }
}

/// Decodes arrays up to a limit of bytes.
struct Decoder<'d, 'a> {
    document: &'d Document<'a>,
    left: u64,
    limit: u64,
}

impl Decoder<'_, '_> {
    fn numbers(&mut self, array: &DataArray<'_>, rows: usize) -> Result<Vec<f64>, ReadError> {
        self.decode(array, rows).map_err(|message| ReadError::part(&array.name, message))
    }

    fn decode(&mut self, array: &DataArray<'_>, rows: usize) -> Result<Vec<f64>, String> {
        if let Some(declared) = array.rows.filter(|declared| *declared != rows) {
            return Err(format!("the array declares {declared} rows where {rows} are expected"));
        }
        let too_large = "the counts are too large";
        let count = rows.checked_mul(array.components).ok_or(too_large)?;
        let Some(scalar) = array.scalar else {
            return Err("the array holds no numbers".to_owned());
        };
        let encoding = self.document.encoding;
        let text;
        let data = match array.payload {
            Payload::Ascii(text) => return parse_numbers(text, count),
            Payload::Base64(inline) => {
                text = without_blanks(inline);
                Encoded::Base64(&text)
            }
            Payload::Appended(offset) => {
                let rest = match self.document.appended {
                    Some(Encoded::Raw(bytes)) => bytes.get(offset..).map(Encoded::Raw),
                    Some(Encoded::Base64(bytes)) => bytes.get(offset..).map(Encoded::Base64),
                    None => return Err("the element AppendedData is missing".to_owned()),
                };
                rest.ok_or_else(|| format!("the offset {offset} is beyond the appended data"))?
            }
        };
        if let Some(name) = &self.document.unknown_compressor {
            let name = shortened(name.as_bytes());
            return Err(format!("data of the compressor '{name}' cannot be read; write them with zlib"));
        }
        let length = count.checked_mul(scalar.size()).ok_or(too_large)?;
        if encoding.is_compressed {
            // In memory each number takes eight bytes.
            let left = self.left.checked_sub((count as u64).saturating_mul(8));
            let message = || format!("the arrays would take more than {} bytes in memory", self.limit);
            self.left = left.ok_or_else(message)?;
        }
        Ok(scalar.decode(&encoding.decode(data, length)?, encoding.order))
    }

    /// Reads the points of a piece that lists them.
    fn listed_points(&mut self, piece: &Piece<'_>, data: &mut DataSet) -> Result<(), ReadError> {
        let Some(array) = piece.arrays.iter().find(|array| array.section == Section::Points) else {
            return Err(ReadError::part("Points", "the element has no array"));
        };
        if array.components != 3 {
            let message = format!("expected 3 components, found {}", array.components);
            return Err(ReadError::part(&array.name, message));
        }
        data.points.extend(points_of(&self.numbers(array, piece.count)?));
        Ok(())
    }

    /// Computes the points of a piece that lists the coordinates along its axes.
    fn rectilinear_points(
        &mut self,
        piece: &Piece<'_>,
        data: &mut DataSet,
        has_values: bool,
    ) -> Result<(), ReadError> {
        let arrays: Vec<_> =
            piece.arrays.iter().filter(|array| array.section == Section::Coordinates).collect();
        let ([x, y, z], Some(extent)) = (&arrays[..], piece.extent) else {
            return Err(ReadError::part("Coordinates", "expected three arrays"));
        };
        let mut axes = [Vec::new(), Vec::new(), Vec::new()];
        for ((axis, array), [first, last]) in axes.iter_mut().zip([x, y, z]).zip(extent) {
            let length = extent_count([[first, last], [0, 0], [0, 0]]).unwrap_or_default();
            *axis = self.numbers(array, length)?;
        }
        let spacings = data.spacing.into_iter().chain(rectilinear_spacing(&axes));
        data.spacing = spacings.reduce(f64::min);
        if has_values {
            data.points.extend(rectilinear_points(&axes));
        }
        Ok(())
    }
}

/// The state while the structure is parsed.
struct Parser<'a> {
    bytes: &'a [u8],
    section: Section,
    document: Option<Document<'a>>,
    /// The array whose text comes next.
    array: Option<DataArray<'a>>,
}

impl<'a> Parser<'a> {
    fn start(&mut self, element: &BytesStart<'_>, position: usize) -> Result<(), ReadError> {
        let attributes = Attributes { element, bytes: self.bytes, position };
        let name = element.name();
        if name.as_ref() == b"VTKFile" {
            self.document = Some(document(&attributes)?);
            return Ok(());
        }
        let Some(document) = &mut self.document else {
            return Err(line_error(self.bytes, position, "expected the element VTKFile"));
        };
        match name.as_ref() {
            b"ImageData" => lattice(&attributes, &mut document.lattice)?,
            b"Piece" => {
                let piece = piece(&attributes, document.kind)?;
                document.pieces.push(piece);
            }
            b"PointData" => {
                self.section = Section::PointData;
                document.active_tensors = attributes.text("Tensors")?;
            }
            b"Points" => self.section = Section::Points,
            b"Coordinates" => self.section = Section::Coordinates,
            b"FieldData" => self.section = Section::FieldData,
            b"DataArray" | b"Array" => self.array = Some(data_array(&attributes, self.section)?),
            // The text of an array ends where an element begins in it.
            _ => self.store(),
        }
        Ok(())
    }

    fn text(&mut self, text: &'a [u8]) {
        if let Some(array) = &mut self.array
            && text.iter().any(|byte| !byte.is_ascii_whitespace())
        {
            match &mut array.payload {
                Payload::Ascii(payload) | Payload::Base64(payload) if payload.is_empty() => *payload = text,
                Payload::Ascii(_) | Payload::Base64(_) | Payload::Appended(_) => {}
            }
        }
    }

    fn end(&mut self, name: &[u8]) {
        match name {
            b"DataArray" | b"Array" => self.store(),
            b"PointData" | b"Points" | b"Coordinates" | b"FieldData" => self.section = Section::Other,
            _ => {}
        }
    }

    /// Files the array that was begun, if it may be of use.
    fn store(&mut self) {
        let (Some(array), Some(document)) = (self.array.take(), &mut self.document) else { return };
        match (array.section, document.pieces.last_mut()) {
            (Section::FieldData, _) => document.fields.push(array),
            (Section::PointData | Section::Points | Section::Coordinates, Some(piece)) => {
                piece.arrays.push(array);
            }
            (Section::PointData | Section::Points | Section::Coordinates | Section::Other, _) => {}
        }
    }

    /// Notes the appended data, which are no XML: they begin after an underline.
    fn appended(&mut self, element: &BytesStart<'_>, position: usize) -> Result<(), ReadError> {
        let attributes = Attributes { element, bytes: self.bytes, position };
        let Some(document) = &mut self.document else {
            return Err(line_error(self.bytes, position, "expected the element VTKFile"));
        };
        let rest = self.bytes.get(position..).unwrap_or_default().trim_ascii_start();
        let Some(data) = rest.strip_prefix(b"_") else {
            return Err(ReadError::part("AppendedData", "the data begin without an underline"));
        };
        document.appended = Some(match attributes.text("encoding")?.as_deref() {
            Some("raw") => Encoded::Raw(data),
            Some("base64") | None => {
                let end = data.iter().position(|byte| *byte == b'<').unwrap_or(data.len());
                Encoded::Base64(data[..end].trim_ascii_end())
            }
            Some(other) => {
                let message =
                    format!("the encoding '{}' is neither raw nor base64", shortened(other.as_bytes()));
                return Err(ReadError::part("AppendedData", message));
            }
        });
        Ok(())
    }
}

/// The document of a VTKFile element.
fn document<'a>(attributes: &Attributes<'_>) -> Result<Document<'a>, ReadError> {
    let name = attributes.text("type")?.unwrap_or_default();
    let Some(kind) = Kind::by_xml_name(name.as_bytes()) else {
        let name = shortened(name.as_bytes());
        let message = if name.starts_with('P') || name.starts_with("vtk") || name == "Collection" {
            format!("a file of the type '{name}' only names other files; open those")
        } else {
            format!("files of the type '{name}' have no points that can be read")
        };
        return Err(attributes.error(message));
    };
    let order = match attributes.text("byte_order")?.as_deref() {
        None | Some("LittleEndian") => ByteOrder::Little,
        Some("BigEndian") => ByteOrder::Big,
        Some(_) => return Err(attributes.error("byte_order is neither LittleEndian nor BigEndian")),
    };
    let length_size = match attributes.text("header_type")?.as_deref() {
        None | Some("UInt32") => 4,
        Some("UInt64") => 8,
        Some(_) => return Err(attributes.error("header_type is neither UInt32 nor UInt64")),
    };
    let compressor = attributes.text("compressor")?.filter(|name| !name.is_empty());
    let is_compressed = compressor.is_some();
    let unknown_compressor = compressor.filter(|name| name != "vtkZLibDataCompressor");
    Ok(Document {
        kind,
        encoding: Encoding { length_size, order, is_compressed },
        unknown_compressor,
        pieces: Vec::new(),
        fields: Vec::new(),
        lattice: Lattice { extent: [[0; 2]; 3], origin: DVec3::ZERO, steps: [DVec3::X, DVec3::Y, DVec3::Z] },
        active_tensors: None,
        appended: None,
    })
}

/// Origin, spacing and direction of an image. The columns of the direction are the axes.
fn lattice(attributes: &Attributes<'_>, lattice: &mut Lattice) -> Result<(), ReadError> {
    let origin = attributes.numbers::<3>("Origin")?.unwrap_or([0.0; 3]);
    let spacing = attributes.numbers::<3>("Spacing")?.unwrap_or([1.0; 3]);
    let d = attributes.numbers::<9>("Direction")?.unwrap_or([1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]);
    lattice.origin = DVec3::from_array(origin);
    for axis in 0..3 {
        lattice.steps[axis] = DVec3::new(d[axis], d[axis + 3], d[axis + 6]) * spacing[axis];
    }
    Ok(())
}

fn piece<'a>(attributes: &Attributes<'_>, kind: Kind) -> Result<Piece<'a>, ReadError> {
    let (count, extent) = match kind {
        Kind::PolyData | Kind::UnstructuredGrid => {
            let count = attributes.count("NumberOfPoints")?;
            (count.ok_or_else(|| attributes.error("a Piece lacks NumberOfPoints"))?, None)
        }
        Kind::ImageData | Kind::StructuredGrid | Kind::RectilinearGrid => {
            let numbers = attributes.numbers::<6>("Extent")?;
            let numbers = numbers.ok_or_else(|| attributes.error("a Piece lacks Extent"))?;
            // Beyond 2^53 casts would be inexact; no real extent comes near.
            let [a, b, c, d, e, f] = numbers.map(|number| number.clamp(-1e15, 1e15) as i64);
            let extent = [[a, b], [c, d], [e, f]];
            let count = extent_count(extent)
                .ok_or_else(|| attributes.error("the Extent is negative or too large"))?;
            (count, Some(extent))
        }
    };
    Ok(Piece { count, extent, arrays: Vec::new() })
}

fn data_array<'a>(attributes: &Attributes<'_>, section: Section) -> Result<DataArray<'a>, ReadError> {
    let name = attributes.text("Name")?.unwrap_or_default();
    let scalar = match attributes.text("type")?.as_deref() {
        Some("Int8") => Some(Scalar::I8),
        Some("UInt8") => Some(Scalar::U8),
        Some("Int16") => Some(Scalar::I16),
        Some("UInt16") => Some(Scalar::U16),
        Some("Int32") => Some(Scalar::I32),
        Some("UInt32") => Some(Scalar::U32),
        Some("Int64") => Some(Scalar::I64),
        Some("UInt64") => Some(Scalar::U64),
        Some("Float32") => Some(Scalar::F32),
        Some("Float64") => Some(Scalar::F64),
        _ => None,
    };
    let payload = match attributes.text("format")?.as_deref() {
        None | Some("ascii") => Payload::Ascii(b""),
        Some("binary") => Payload::Base64(b""),
        Some("appended") => match attributes.count("offset")? {
            Some(offset) => Payload::Appended(offset),
            None => return Err(ReadError::part(name, "the array is appended and lacks an offset")),
        },
        Some(other) => {
            let message =
                format!("the format '{}' is none of ascii, binary, appended", shortened(other.as_bytes()));
            return Err(ReadError::part(name, message));
        }
    };
    let components = attributes.count("NumberOfComponents")?.unwrap_or(1).max(1);
    let rows = attributes.count("NumberOfTuples")?;
    Ok(DataArray { section, name, scalar, components, rows, payload })
}

/// The attributes of an element.
struct Attributes<'e> {
    element: &'e BytesStart<'e>,
    bytes: &'e [u8],
    position: usize,
}

impl Attributes<'_> {
    fn error(&self, message: impl Into<String>) -> ReadError {
        line_error(self.bytes, self.position, message)
    }

    fn text(&self, name: &str) -> Result<Option<String>, ReadError> {
        let mut attributes = self.element.attributes();
        // The first of several counts; a search for duplicates would take quadratic time.
        attributes.with_checks(false);
        for attribute in attributes {
            let attribute = attribute.map_err(|error| self.error(format!("wrong XML: {error}")))?;
            if attribute.key.as_ref() == name.as_bytes() {
                let value = String::from_utf8_lossy(&attribute.value);
                let value = quick_xml::escape::unescape(&value);
                let value = value.map_err(|error| self.error(format!("wrong XML: {error}")))?;
                return Ok(Some(value.into_owned()));
            }
        }
        Ok(None)
    }

    fn count(&self, name: &str) -> Result<Option<usize>, ReadError> {
        let Some(text) = self.text(name)? else { return Ok(None) };
        let message = || format!("{name}: expected a count, found '{}'", shortened(text.as_bytes()));
        text.trim().parse().map(Some).map_err(|_| self.error(message()))
    }

    fn numbers<const N: usize>(&self, name: &str) -> Result<Option<[f64; N]>, ReadError> {
        let Some(text) = self.text(name)? else { return Ok(None) };
        let mut numbers = [0.0; N];
        let mut words = text.split_ascii_whitespace();
        for number in &mut numbers {
            let word = words.next().unwrap_or_default();
            let parsed = parse_number(word.as_bytes()).ok().filter(|number| number.is_finite());
            *number = parsed.ok_or_else(|| self.error(format!("{name}: expected {N} numbers")))?;
        }
        Ok(Some(numbers))
    }
}

/// An error in the line that holds this byte.
fn line_error(bytes: &[u8], position: usize, message: impl Into<String>) -> ReadError {
    let before = &bytes[..position.min(bytes.len())];
    let lines = before.iter().filter(|byte| **byte == b'\n').count();
    ReadError::line(lines as u64 + 1, message)
}

/// A text without blanks.
fn without_blanks(text: &[u8]) -> Cow<'_, [u8]> {
    let text = text.trim_ascii();
    if text.iter().any(u8::is_ascii_whitespace) {
        Cow::Owned(text.iter().copied().filter(|byte| !byte.is_ascii_whitespace()).collect())
    } else {
        Cow::Borrowed(text)
    }
}
