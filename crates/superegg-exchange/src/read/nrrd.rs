//! Tensors of Teem: NRRD files with seven numbers a tensor, confidence xx xy xz yy yz zz.
//!
//! By hand, since no maintained crate reads NRRD. Source: the format's definition of version 5.

use std::borrow::Cow;
use std::io::Read;

use flate2::read::MultiGzDecoder;
use superegg_geom::glam::{DMat3, DVec3};

use super::error::ReadError;
use super::expansion::expansion_limit;
use super::format::Format;
use super::import::Import;
use super::options::ReadOptions;
use super::scalars::{ByteOrder, Scalar, parse_number, parse_numbers, shortened};
use super::tensor_field::{TensorField, import};

/// Tensors of less confidence are not drawn, as in Teem's own programs.
const CONFIDENCE: f64 = 0.5;
/// The most axes that the format allows.
const MOST_AXES: usize = 16;

/// The format, if a file begins with these bytes.
///
/// # Errors
/// None: faults of the file are found on reading.
pub(super) fn recognize(head: &[u8]) -> Result<Option<Format>, ReadError> {
    Ok(is_nrrd(head).then_some(Format::TeemNrrd))
}

/// Whether a file that begins with these bytes is NRRD.
fn is_nrrd(head: &[u8]) -> bool {
    head.starts_with(b"NRRD000")
}

/// Reads one file.
///
/// # Errors
/// The file is wrong, has its data elsewhere, or no tensors.
pub(super) fn read(bytes: &[u8], options: &ReadOptions) -> Result<Import, ReadError> {
    let (header, data) = Header::parse(bytes)?;
    let layout = Layout::new(&header)?;
    let numbers = header.numbers(data, layout.count, bytes.len())?;
    let mut field =
        TensorField { name: "NRRD".to_owned(), spacing: Some(layout.spacing()), ..TensorField::default() };
    let mut confidences = Vec::new();
    let mut doubted = 0usize;
    for index in layout.indices() {
        let at: usize = index.iter().zip(&layout.axes).map(|(index, axis)| index * axis.stride).sum();
        let number = |component: usize| numbers[at + component * layout.stride];
        let (confidence, tensor) = layout.order.tensor(number);
        if confidence.is_nan() || confidence < CONFIDENCE {
            doubted += 1;
            continue;
        }
        let steps = index.iter().zip(&layout.axes).map(|(index, axis)| axis.step * *index as f64);
        field.positions.push(layout.origin + steps.sum::<DVec3>());
        field.tensors.push(layout.frame * tensor * layout.frame.transpose());
        confidences.push(confidence);
    }
    if doubted > 0 {
        field.warnings.push(format!("{doubted} tensors have a confidence below {CONFIDENCE} and no glyph"));
    }
    for asked in &options.extra {
        if asked != "confidence" {
            return Err(ReadError::part(asked, "the file has no such column; it has confidence"));
        }
    }
    if options.all_extra || !options.extra.is_empty() {
        field.extra.push(("confidence".to_owned(), confidences));
    }
    import(field, options)
}

/// The order of a tensor's numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Order {
    /// Confidence xx xy xz yy yz zz.
    Masked,
    /// xx xy xz yy yz zz.
    Symmetric,
    /// Row by row.
    Full,
}

impl Order {
    fn length(self) -> usize {
        match self {
            Self::Masked => 7,
            Self::Symmetric => 6,
            Self::Full => 9,
        }
    }

    /// The order that a kind of axis has.
    fn by_kind(kind: &str) -> Option<Self> {
        match kind.to_ascii_lowercase().as_str() {
            "3d-masked-symmetric-matrix" => Some(Self::Masked),
            "3d-symmetric-matrix" => Some(Self::Symmetric),
            "3d-matrix" => Some(Self::Full),
            _ => None,
        }
    }

    /// The confidence and the tensor of these numbers.
    fn tensor(self, number: impl Fn(usize) -> f64) -> (f64, DMat3) {
        let symmetric = |first: usize| {
            let [xx, xy, xz, yy, yz, zz] = [0, 1, 2, 3, 4, 5].map(|at| number(first + at));
            DMat3::from_cols_array(&[xx, xy, xz, xy, yy, yz, xz, yz, zz])
        };
        match self {
            Self::Masked => (number(0), symmetric(1)),
            Self::Symmetric => (1.0, symmetric(0)),
            Self::Full => (1.0, DMat3::from_cols_array(&[0, 1, 2, 3, 4, 5, 6, 7, 8].map(number)).transpose()),
        }
    }
}

/// An axis of space.
#[derive(Clone, Copy, Debug)]
struct Axis {
    size: usize,
    /// The distance of neighbours in the array of numbers.
    stride: usize,
    step: DVec3,
}

/// How tensors lie in the array, and where in space.
#[derive(Clone, Debug)]
struct Layout {
    order: Order,
    /// The number of all numbers.
    count: usize,
    /// The distance of a tensor's numbers in the array.
    stride: usize,
    axes: Vec<Axis>,
    origin: DVec3,
    /// From the tensors' frame to that of the space.
    frame: DMat3,
}

impl Layout {
    fn new(header: &Header) -> Result<Self, ReadError> {
        let sizes = &header.sizes;
        let by_kind = || {
            let kinds = header.kinds.iter().enumerate();
            kinds.into_iter().find_map(|(axis, kind)| Some((axis, Order::by_kind(kind)?)))
        };
        let by_size = || (sizes.first() == Some(&7)).then_some((0, Order::Masked));
        let Some((tensor_axis, order)) = by_kind().or_else(by_size) else {
            let first = sizes.first().copied().unwrap_or_default();
            let message =
                format!("the file holds no tensors: the first axis has {first} numbers, a tensor has 7");
            return Err(ReadError::part("sizes", message));
        };
        if sizes.get(tensor_axis) != Some(&order.length()) {
            let message = format!("the axis of the tensors must have {} numbers", order.length());
            return Err(ReadError::part("sizes", message));
        }
        let mut layout = Self {
            order,
            count: 1,
            stride: 1,
            axes: Vec::new(),
            origin: header.origin.unwrap_or_default(),
            frame: header.frame.unwrap_or(DMat3::IDENTITY),
        };
        for (axis, size) in sizes.iter().copied().enumerate() {
            if axis == tensor_axis {
                layout.stride = layout.count;
            } else {
                let step = layout.step(header, axis)?;
                layout.axes.push(Axis { size, stride: layout.count, step });
            }
            let count = layout.count.checked_mul(size);
            layout.count = count.ok_or_else(|| ReadError::part("sizes", "the sizes are too large"))?;
        }
        Ok(layout)
    }

    /// The step along the next axis of space.
    fn step(&mut self, header: &Header, axis: usize) -> Result<DVec3, ReadError> {
        let Some(unit) = DVec3::AXES.get(self.axes.len()) else {
            return Err(ReadError::part(
                "sizes",
                "tensors with more than three axes of space cannot be shown",
            ));
        };
        match &header.directions {
            Some(directions) => {
                let direction = directions.get(axis).copied().flatten();
                direction.ok_or_else(|| ReadError::part("space directions", format!("axis {axis} has none")))
            }
            None => {
                let number = |numbers: &[f64]| numbers.get(axis).copied().filter(|number| number.is_finite());
                self.origin += *unit * number(&header.mins).unwrap_or(0.0);
                Ok(*unit * number(&header.spacings).unwrap_or(1.0))
            }
        }
    }

    fn spacing(&self) -> f64 {
        let lengths = |all: bool| {
            self.axes.iter().filter(move |axis| all || axis.size > 1).map(|axis| axis.step.length())
        };
        let smallest = lengths(false).fold(f64::INFINITY, f64::min);
        if smallest.is_finite() { smallest } else { lengths(true).fold(f64::INFINITY, f64::min) }
    }

    /// The indices of all tensors, the first axis fastest.
    fn indices(&self) -> impl Iterator<Item = Vec<usize>> {
        let tensors: usize = self.axes.iter().map(|axis| axis.size).product();
        let sizes: Vec<usize> = self.axes.iter().map(|axis| axis.size).collect();
        (0..tensors).map(move |mut at| {
            let index = |size: &usize| {
                let index = at % size;
                at /= size;
                index
            };
            sizes.iter().map(index).collect()
        })
    }
}

/// How the numbers are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Encoding {
    Raw,
    Text,
    Gzip,
}

/// The fields of a header that matter.
#[derive(Clone, Debug)]
struct Header {
    scalar: Scalar,
    sizes: Vec<usize>,
    encoding: Encoding,
    order: Option<ByteOrder>,
    line_skip: usize,
    byte_skip: i64,
    kinds: Vec<String>,
    spacings: Vec<f64>,
    mins: Vec<f64>,
    directions: Option<Vec<Option<DVec3>>>,
    origin: Option<DVec3>,
    frame: Option<DMat3>,
}

/// The fields of a header as they are met.
#[derive(Default)]
struct Fields {
    scalar: Option<Scalar>,
    dimension: Option<usize>,
    sizes: Vec<usize>,
    encoding: Option<Encoding>,
    order: Option<ByteOrder>,
    line_skip: usize,
    byte_skip: i64,
    kinds: Vec<String>,
    spacings: Vec<f64>,
    mins: Vec<f64>,
    directions: Option<Vec<Option<DVec3>>>,
    origin: Option<DVec3>,
    frame: Option<DMat3>,
}

impl Header {
    /// The header, and the bytes after it.
    fn parse(bytes: &[u8]) -> Result<(Self, &[u8]), ReadError> {
        if !is_nrrd(bytes) {
            return Err(ReadError::File("the file is not NRRD: it does not begin with NRRD000".to_owned()));
        }
        let mut fields = Fields::default();
        let mut rest = bytes;
        let mut number = 0u64;
        loop {
            number += 1;
            let Some(end) = rest.iter().position(|byte| *byte == b'\n') else {
                return Err(ReadError::line(
                    number,
                    "the header ends early; data in another file are not read",
                ));
            };
            let line = String::from_utf8_lossy(&rest[..end]);
            let line = line.trim();
            rest = &rest[end + 1..];
            if line.is_empty() {
                break;
            }
            // After the magic come fields, comments, and pairs of key and value.
            if number == 1 || line.starts_with('#') {
                continue;
            }
            match line.split_once(':') {
                Some((_, value)) if value.starts_with('=') => {}
                Some((name, value)) => {
                    let field = fields.set(name.trim(), value.trim());
                    field.map_err(|message| {
                        ReadError::line(number, format!("'{}': {message}", shortened(name.as_bytes())))
                    })?;
                }
                None => return Err(ReadError::line(number, "expected 'FIELD: VALUE'")),
            }
        }
        Ok((fields.complete()?, rest))
    }

    /// The numbers of the file, `count` of them.
    fn numbers(&self, data: &[u8], count: usize, file_size: usize) -> Result<Vec<f64>, ReadError> {
        self.decode(data, count, file_size).map_err(|message| ReadError::part("data", message))
    }

    fn decode(&self, data: &[u8], count: usize, file_size: usize) -> Result<Vec<f64>, String> {
        let length = count.checked_mul(self.scalar.size()).ok_or("the sizes are too large")?;
        let data = after_lines(data, self.line_skip)?;
        let data = match self.encoding {
            Encoding::Raw | Encoding::Text => Cow::Borrowed(data),
            Encoding::Gzip => {
                let skip = u64::try_from(self.byte_skip).map_err(|_| "the byte skip is negative")?;
                let needed = (length as u64).saturating_add(skip);
                let limit = expansion_limit(file_size);
                if (count as u64).saturating_mul(8).max(needed) > limit {
                    return Err(format!("the numbers would take more than {limit} bytes in memory"));
                }
                Cow::Owned(inflate(data, needed)?)
            }
        };
        let skip = match usize::try_from(self.byte_skip) {
            Ok(skip) => skip,
            Err(_) => data.len().checked_sub(length).ok_or("the file is shorter than the data")?,
        };
        let data = data.get(skip..).ok_or("the file ends within the bytes to skip")?;
        if self.encoding == Encoding::Text {
            // Commas may stand between the numbers.
            let spaced: Vec<u8> = data.iter().map(|byte| if *byte == b',' { b' ' } else { *byte }).collect();
            return parse_numbers(&spaced, count);
        }
        let order = match self.order {
            Some(order) => order,
            None if self.scalar.size() == 1 => ByteOrder::Little,
            None => return Err("the field 'endian' is missing".to_owned()),
        };
        let left = data.len();
        let data = data.get(..length).ok_or_else(|| format!("expected {length} bytes, found {left}"))?;
        Ok(self.scalar.decode(data, order))
    }
}

/// The data after so many lines.
fn after_lines(mut data: &[u8], lines: usize) -> Result<&[u8], String> {
    for _ in 0..lines {
        let end =
            data.iter().position(|byte| *byte == b'\n').ok_or("the file ends within the lines to skip")?;
        data = &data[end + 1..];
    }
    Ok(data)
}

/// The first `length` bytes of gzip data; fewer if there are no more.
fn inflate(data: &[u8], length: u64) -> Result<Vec<u8>, String> {
    let mut inflated = Vec::new();
    let read = MultiGzDecoder::new(data).take(length).read_to_end(&mut inflated);
    read.map_err(|error| format!("the compressed data are damaged: {error}"))?;
    Ok(inflated)
}

impl Fields {
    /// Takes one field. Fields without effect are skipped.
    fn set(&mut self, name: &str, value: &str) -> Result<(), String> {
        match name.to_ascii_lowercase().as_str() {
            "type" => self.scalar = Some(scalar(value)?),
            "dimension" => self.dimension = Some(count(value)?),
            "sizes" => {
                self.sizes = value
                    .split_ascii_whitespace()
                    .take(MOST_AXES + 1)
                    .map(count)
                    .collect::<Result<_, _>>()?;
            }
            "encoding" => self.encoding = Some(encoding(value)?),
            "endian" => {
                self.order = Some(match value.to_ascii_lowercase().as_str() {
                    "little" => ByteOrder::Little,
                    "big" => ByteOrder::Big,
                    _ => {
                        return Err(format!(
                            "expected little or big, found '{}'",
                            shortened(value.as_bytes())
                        ));
                    }
                });
            }
            "data file" | "datafile" => {
                let file = shortened(value.as_bytes());
                return Err(format!(
                    "the data are in other files ({file}); join them with 'unu save -f nrrd'"
                ));
            }
            "line skip" | "lineskip" => self.line_skip = count(value)?,
            "byte skip" | "byteskip" => {
                self.byte_skip = value.parse().map_err(|_| "expected a count".to_owned())?;
                if self.byte_skip < -1 {
                    return Err("expected a count, or -1 for data at the end".to_owned());
                }
            }
            "kinds" => {
                self.kinds = value.split_ascii_whitespace().take(MOST_AXES).map(str::to_owned).collect();
            }
            "spacings" => self.spacings = numbers(value)?,
            "axis mins" | "axismins" => self.mins = numbers(value)?,
            "space directions" => self.directions = Some(vectors(value)?),
            "space origin" => {
                let vectors = vectors(value)?;
                let [Some(origin)] = vectors[..] else {
                    return Err("expected one vector (x,y,z)".to_owned());
                };
                self.origin = Some(origin);
            }
            "measurement frame" => {
                let vectors = vectors(value)?;
                let [Some(x), Some(y), Some(z)] = vectors[..] else {
                    return Err("expected three vectors (x,y,z)".to_owned());
                };
                self.frame = Some(DMat3::from_cols(x, y, z));
            }
            _ => {}
        }
        Ok(())
    }

    fn complete(self) -> Result<Header, ReadError> {
        fn missing<T>(field: Option<T>, name: &str) -> Result<T, ReadError> {
            field.ok_or_else(|| ReadError::part(name, "the field is missing"))
        }
        let dimension = missing(self.dimension, "dimension")?;
        if self.sizes.len() != dimension || self.sizes.contains(&0) || dimension > MOST_AXES {
            let message = format!("expected {dimension} sizes above 0, at most {MOST_AXES}");
            return Err(ReadError::part("sizes", message));
        }
        Ok(Header {
            scalar: missing(self.scalar, "type")?,
            sizes: self.sizes,
            encoding: missing(self.encoding, "encoding")?,
            order: self.order,
            line_skip: self.line_skip,
            byte_skip: self.byte_skip,
            kinds: self.kinds,
            spacings: self.spacings,
            mins: self.mins,
            directions: self.directions,
            origin: self.origin,
            frame: self.frame,
        })
    }
}

fn count(text: &str) -> Result<usize, String> {
    text.parse().map_err(|_| format!("expected a count, found '{}'", shortened(text.as_bytes())))
}

fn numbers(text: &str) -> Result<Vec<f64>, String> {
    text.split_ascii_whitespace().take(MOST_AXES).map(|word| parse_number(word.as_bytes())).collect()
}

/// Vectors (x,y,z) or the word none.
fn vectors(text: &str) -> Result<Vec<Option<DVec3>>, String> {
    let mut vectors = Vec::new();
    let mut rest = text.trim();
    while !rest.is_empty() && vectors.len() < MOST_AXES {
        if let Some(after) = rest.strip_prefix("none") {
            vectors.push(None);
            rest = after.trim_start();
            continue;
        }
        let inner = rest.strip_prefix('(').and_then(|after| after.split_once(')'));
        let Some((inner, after)) = inner else {
            return Err(format!("expected a vector (x,y,z), found '{}'", shortened(rest.as_bytes())));
        };
        let numbers: Vec<f64> = inner
            .split(',')
            .take(4)
            .map(|word| parse_number(word.trim().as_bytes()))
            .collect::<Result<_, _>>()?;
        let [x, y, z] = numbers[..] else {
            return Err(format!("expected three numbers in ({})", shortened(inner.as_bytes())));
        };
        vectors.push(Some(DVec3::new(x, y, z)));
        rest = after.trim_start();
    }
    Ok(vectors)
}

fn encoding(text: &str) -> Result<Encoding, String> {
    match text.to_ascii_lowercase().as_str() {
        "raw" => Ok(Encoding::Raw),
        "txt" | "text" | "ascii" => Ok(Encoding::Text),
        "gz" | "gzip" => Ok(Encoding::Gzip),
        _ => Err(format!("expected raw, ascii or gzip, found '{}'", shortened(text.as_bytes()))),
    }
}

fn scalar(text: &str) -> Result<Scalar, String> {
    let words: Vec<&str> = text.split_ascii_whitespace().collect();
    Ok(match words.join(" ").to_ascii_lowercase().as_str() {
        "signed char" | "int8" | "int8_t" => Scalar::I8,
        "uchar" | "unsigned char" | "uint8" | "uint8_t" => Scalar::U8,
        "short" | "short int" | "signed short" | "signed short int" | "int16" | "int16_t" => Scalar::I16,
        "ushort" | "unsigned short" | "unsigned short int" | "uint16" | "uint16_t" => Scalar::U16,
        "int" | "signed int" | "int32" | "int32_t" => Scalar::I32,
        "uint" | "unsigned int" | "uint32" | "uint32_t" => Scalar::U32,
        "longlong"
        | "long long"
        | "long long int"
        | "signed long long"
        | "signed long long int"
        | "int64"
        | "int64_t" => Scalar::I64,
        "ulonglong" | "unsigned long long" | "unsigned long long int" | "uint64" | "uint64_t" => Scalar::U64,
        "float" => Scalar::F32,
        "double" => Scalar::F64,
        _ => return Err(format!("'{}' is no type that can be read", shortened(text.as_bytes()))),
    })
}
