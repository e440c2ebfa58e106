//! MATLAB's version 5 files (.mat), as MATLAB -v6 and -v7, Octave and SciPy write them; by MATLAB's
//! "MAT-File Format".
//!
//! Read here and not by a library: the one on offer leaves out cells and structures without a word
//! and inflates compressed variables without a bound.

use std::io::Read;

use super::number_array::NumberArray;
use crate::read::error::ReadError;

/// The first bytes of version 5 and 7.3 files.
pub(crate) const MAGIC: &[u8] = b"MATLAB ";
/// The length of the header.
const HEADER_BYTES: usize = 128;
/// The most bytes that the compressed variables of a file may have when inflated.
const MOST_INFLATED_BYTES: u64 = 1 << 28;

/// A variable of a file.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Variable {
    pub(crate) name: String,
    pub(crate) value: Value,
}

/// The value of a variable.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Value {
    /// Real numbers, converted to f64.
    Numbers(NumberArray),
    /// A class that is not read: "a cell array".
    Other(&'static str),
}

/// The byte order of a file.
#[derive(Clone, Copy)]
enum Order {
    Little,
    Big,
}

impl Order {
    /// An unsigned number of up to 8 bytes.
    fn bits(self, bytes: &[u8]) -> u64 {
        let push = |value: u64, byte: &u8| value << 8 | u64::from(*byte);
        match self {
            Self::Big => bytes.iter().fold(0, push),
            Self::Little => bytes.iter().rev().fold(0, push),
        }
    }
}

/// The type of the numbers in a data element.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Numeric {
    Signed(usize),
    Unsigned(usize),
    Single,
    Double,
}

impl Numeric {
    /// The type of this code, `None` if it is none of numbers.
    fn of_code(code: u32) -> Option<Self> {
        Some(match code {
            1 => Self::Signed(1),
            2 => Self::Unsigned(1),
            3 => Self::Signed(2),
            4 => Self::Unsigned(2),
            5 => Self::Signed(4),
            6 => Self::Unsigned(4),
            7 => Self::Single,
            9 => Self::Double,
            12 => Self::Signed(8),
            13 => Self::Unsigned(8),
            _ => return None,
        })
    }

    fn size(self) -> usize {
        match self {
            Self::Signed(size) | Self::Unsigned(size) => size,
            Self::Single => 4,
            Self::Double => 8,
        }
    }

    fn value(self, bytes: &[u8], order: Order) -> f64 {
        let bits = order.bits(bytes);
        match self {
            Self::Signed(size) => {
                let unused = 64 - 8 * size as u32;
                ((bits as i64) << unused >> unused) as f64
            }
            Self::Unsigned(_) => bits as f64,
            Self::Single => f64::from(f32::from_bits(bits as u32)),
            Self::Double => f64::from_bits(bits),
        }
    }
}

/// The code of a data element that is a variable.
const MATRIX: u32 = 14;
/// The code of a data element that holds compressed ones.
const COMPRESSED: u32 = 15;

/// Reads the variables of a file.
///
/// # Errors
/// The file is of version 4 or 7.3, cut off, damaged, or too large when inflated.
pub(crate) fn read(bytes: &[u8]) -> Result<Vec<Variable>, ReadError> {
    let file = |message: &str| ReadError::File(message.to_owned());
    if !bytes.starts_with(MAGIC) {
        return Err(file("this is no MATLAB file of version 5; save it again with '-v7'"));
    }
    let Some((header, mut rest)) = bytes.split_at_checked(HEADER_BYTES) else {
        return Err(file("the header of the MATLAB file is cut off"));
    };
    let order = match &header[126..128] {
        b"IM" => Order::Little,
        b"MI" => Order::Big,
        _ => return Err(file("the header of the MATLAB file has no byte order")),
    };
    if order.bits(&header[124..126]) != 0x0100 {
        return Err(file("MATLAB files of version 7.3 (HDF5) are not read; save it again with '-v7'"));
    }
    let mut variables = Vec::new();
    let mut room = MOST_INFLATED_BYTES;
    while !rest.is_empty() {
        let element = Element::split(&mut rest, order)?;
        if element.code == MATRIX {
            variables.push(variable(element.data, order)?);
        } else if element.code == COMPRESSED {
            let inflated = inflate(element.data, &mut room)?;
            let inner = Element::split(&mut inflated.as_slice(), order)?;
            if inner.code == MATRIX {
                variables.push(variable(inner.data, order)?);
            }
        }
    }
    Ok(variables)
}

/// Inflates a compressed element into at most `room` bytes, and takes them off.
fn inflate(data: &[u8], room: &mut u64) -> Result<Vec<u8>, ReadError> {
    let mut bytes = Vec::new();
    let mut inflater = flate2::bufread::ZlibDecoder::new(data).take(*room + 1);
    let result = inflater.read_to_end(&mut bytes);
    result.map_err(|error| ReadError::File(format!("a compressed variable cannot be read: {error}")))?;
    let Some(left) = room.checked_sub(bytes.len() as u64) else {
        let message = format!("the variables have more than {MOST_INFLATED_BYTES} bytes when inflated");
        return Err(ReadError::File(message));
    };
    *room = left;
    Ok(bytes)
}

/// A data element: a type and its bytes.
struct Element<'a> {
    code: u32,
    data: &'a [u8],
}

impl<'a> Element<'a> {
    /// Takes the first element, with its padding to 8 bytes.
    fn split(bytes: &mut &'a [u8], order: Order) -> Result<Self, ReadError> {
        let cut = || ReadError::File("the MATLAB file is cut off".to_owned());
        let (tag, rest) = bytes.split_at_checked(8).ok_or_else(cut)?;
        let first = order.bits(&tag[..4]) as u32;
        // Up to four bytes lie in the tag itself, with their number in its upper half.
        let small = (first >> 16) as usize;
        if small > 0 {
            if small > 4 {
                return Err(ReadError::File(format!("a small data element claims {small} bytes")));
            }
            *bytes = rest;
            return Ok(Self { code: first & 0xffff, data: &tag[4..4 + small] });
        }
        let length = order.bits(&tag[4..]) as usize;
        let (data, rest) = rest.split_at_checked(length).ok_or_else(cut)?;
        let padding = if first == COMPRESSED { 0 } else { length.next_multiple_of(8) - length };
        *bytes = rest.get(padding..).unwrap_or_default();
        Ok(Self { code: first, data })
    }

    fn numbers(&self, order: Order, name: &str) -> Result<Vec<f64>, ReadError> {
        let Some(numeric) = Numeric::of_code(self.code) else {
            let message = format!("expected numbers, found a data element of type {}", self.code);
            return Err(ReadError::part(name, message));
        };
        Ok(self.data.chunks_exact(numeric.size()).map(|bytes| numeric.value(bytes, order)).collect())
    }
}

/// Reads the content of a matrix element.
fn variable(mut data: &[u8], order: Order) -> Result<Variable, ReadError> {
    let flags = Element::split(&mut data, order)?;
    let flags = flags.data.get(..4).map_or(0, |word| order.bits(word) as u32);
    let lengths = Element::split(&mut data, order)?.numbers(order, "dimensions")?;
    let name = Element::split(&mut data, order)?;
    let name = String::from_utf8_lossy(name.data).into_owned();
    let other = match flags & 0xff {
        1 => Some("a cell array"),
        2 => Some("a structure"),
        3 => Some("an object"),
        4 => Some("text"),
        5 => Some("a sparse matrix"),
        6..=15 if flags & 0x800 != 0 => Some("a complex matrix"),
        6..=15 => None,
        _ => Some("of an unknown class"),
    };
    if let Some(other) = other {
        return Ok(Variable { name, value: Value::Other(other) });
    }
    let shape: Option<Vec<usize>> =
        lengths.iter().map(|length| (*length >= 0.0).then_some(*length as usize)).collect();
    let count = shape
        .as_ref()
        .and_then(|shape| shape.iter().try_fold(1_usize, |product, &length| product.checked_mul(length)));
    let values = Element::split(&mut data, order)?.numbers(order, &name)?;
    match (shape, count) {
        (Some(shape), Some(count)) if count == values.len() => {
            Ok(Variable { name, value: Value::Numbers(NumberArray::from_fortran(shape, &values)) })
        }
        _ => {
            let lengths: Vec<String> = lengths.iter().map(f64::to_string).collect();
            let message =
                format!("the size is {}, but there are {} numbers", lengths.join("x"), values.len());
            Err(ReadError::part(name, message))
        }
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use std::io::Write;

    use super::*;

    /// How test files are written.
    #[derive(Clone, Copy)]
    pub(crate) enum Layout {
        Plain,
        BigEndian,
        Compressed,
    }

    fn word(value: u32, layout: Layout) -> [u8; 4] {
        match layout {
            Layout::BigEndian => value.to_be_bytes(),
            Layout::Plain | Layout::Compressed => value.to_le_bytes(),
        }
    }

    fn element(code: u32, data: &[u8], layout: Layout) -> Vec<u8> {
        let mut bytes = [word(code, layout), word(data.len() as u32, layout)].concat();
        bytes.extend(data);
        if code != COMPRESSED {
            bytes.resize(bytes.len().next_multiple_of(8), 0);
        }
        bytes
    }

    /// The bytes of a matrix element: doubles in column order.
    pub(crate) fn matrix(
        class: u32,
        name: &str,
        [rows, columns]: [u32; 2],
        columns_first: &[f64],
        layout: Layout,
    ) -> Vec<u8> {
        let values: Vec<u8> = columns_first
            .iter()
            .flat_map(|value| match layout {
                Layout::BigEndian => value.to_be_bytes(),
                Layout::Plain | Layout::Compressed => value.to_le_bytes(),
            })
            .collect();
        let content = [
            element(6, &[word(class, layout), [0; 4]].concat(), layout),
            element(5, &[word(rows, layout), word(columns, layout)].concat(), layout),
            element(1, name.as_bytes(), layout),
            element(9, &values, layout),
        ]
        .concat();
        let whole = element(MATRIX, &content, layout);
        match layout {
            Layout::Compressed => {
                let mut encoder = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::default());
                encoder.write_all(&whole).unwrap();
                element(COMPRESSED, &encoder.finish().unwrap(), layout)
            }
            Layout::Plain | Layout::BigEndian => whole,
        }
    }

    /// The bytes of a file of these elements.
    pub(crate) fn mat(elements: &[Vec<u8>], layout: Layout) -> Vec<u8> {
        let mut bytes = b"MATLAB 5.0 MAT-file, written by a test".to_vec();
        bytes.resize(124, b' ');
        bytes.extend(match layout {
            Layout::BigEndian => *b"\x01\x00MI",
            Layout::Plain | Layout::Compressed => *b"\x00\x01IM",
        });
        elements.iter().for_each(|element| bytes.extend(element));
        bytes
    }

    #[test]
    fn variables_are_read_in_all_layouts() {
        for layout in [Layout::Plain, Layout::BigEndian, Layout::Compressed] {
            let values = [1.0, 4.0, 2.0, 5.0, 3.0, 6.5];
            let bytes = mat(
                &[matrix(6, "x", [2, 3], &values, layout), matrix(1, "longer", [1, 1], &[], layout)],
                layout,
            );
            let variables = read(&bytes).unwrap();
            let array = NumberArray { shape: vec![2, 3], values: vec![1.0, 2.0, 3.0, 4.0, 5.0, 6.5] };
            assert_eq!(variables[0], Variable { name: "x".to_owned(), value: Value::Numbers(array) });
            assert_eq!(variables[1].value, Value::Other("a cell array"));
        }
    }

    #[test]
    fn small_elements_lie_in_their_tag() {
        // The name "ab" and the number 7 as one byte, as MATLAB writes them.
        let content = [
            element(6, &[word(6, Layout::Plain), [0; 4]].concat(), Layout::Plain),
            element(5, &[word(1, Layout::Plain), word(1, Layout::Plain)].concat(), Layout::Plain),
            vec![1, 0, 2, 0, b'a', b'b', 0, 0],
            vec![2, 0, 1, 0, 7, 0, 0, 0],
        ]
        .concat();
        let bytes = mat(&[element(MATRIX, &content, Layout::Plain)], Layout::Plain);
        let array = NumberArray { shape: vec![1, 1], values: vec![7.0] };
        let expected = Variable { name: "ab".to_owned(), value: Value::Numbers(array) };
        assert_eq!(read(&bytes).unwrap(), [expected]);
    }

    #[test]
    fn other_versions_and_damage_are_errors() {
        let message = |bytes: &[u8]| read(bytes).unwrap_err().to_string();
        assert!(message(b"\0\0\0\0").contains("'-v7'"));
        let mut newer = mat(&[], Layout::Plain);
        newer[125] = 2;
        assert!(message(&newer).contains("7.3"));
        let mut lie = mat(&[matrix(6, "x", [2, 3], &[0.0; 5], Layout::Plain)], Layout::Plain);
        assert!(message(&lie).contains("2x3"));
        lie[132] = 0xff;
        lie[135] = 0xff;
        assert!(message(&lie).contains("cut off"));
        for layout in [Layout::Plain, Layout::Compressed] {
            let bytes = mat(&[matrix(6, "x", [1, 11], &[1.0; 11], layout)], layout);
            for end in (0..bytes.len()).filter(|end| *end != HEADER_BYTES) {
                assert!(read(&bytes[..end]).is_err(), "{end}");
            }
            for at in 0..bytes.len() {
                let mut damaged = bytes.clone();
                damaged[at] ^= 0x81;
                let _ = read(&damaged);
            }
        }
    }

    #[test]
    fn a_bomb_is_an_error() {
        let mut encoder = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::fast());
        let zeros = vec![0_u8; 1 << 20];
        for _ in 0..=(MOST_INFLATED_BYTES >> 20) {
            encoder.write_all(&zeros).unwrap();
        }
        let bytes = mat(&[element(COMPRESSED, &encoder.finish().unwrap(), Layout::Plain)], Layout::Plain);
        assert!(bytes.len() < 3 << 20);
        assert!(read(&bytes).unwrap_err().to_string().contains("when inflated"));
    }
}
