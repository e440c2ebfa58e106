//! NumPy's array files (.npy, versions 1 to 3), by numpy/lib/format.py.
//!
//! Read here and not by a library: those on offer convert no types and read neither strings nor
//! half precision, and fits have all of these.

use half::f16;

use super::number_array::NumberArray;
use crate::read::error::ReadError;

/// The first bytes of a .npy file.
pub(crate) const MAGIC: &[u8] = b"\x93NUMPY";
/// The longest string of an array of strings, in characters.
const MOST_CHARACTERS: usize = 4096;

/// An array of a .npy file.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum NumpyArray {
    /// Numbers or truth values, converted to f64.
    Numbers(NumberArray),
    /// Strings, in C order.
    Text(Vec<String>),
}

impl NumpyArray {
    /// The numbers, or an error that names the array.
    pub(crate) fn numbers(self, name: &str) -> Result<NumberArray, ReadError> {
        match self {
            Self::Numbers(array) => Ok(array),
            Self::Text(_) => Err(ReadError::part(name, "expected numbers, found strings")),
        }
    }
}

/// The type of one item.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Item {
    Float,
    Signed,
    Unsigned,
    /// UTF-32.
    Unicode,
    /// ASCII.
    Bytes,
}

/// The fields of the header.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Header {
    item: Item,
    /// Bytes of an item.
    size: usize,
    is_big_endian: bool,
    is_fortran: bool,
    shape: Vec<usize>,
}

/// The shape in the header of a .npy file, if these first bytes hold it.
pub(crate) fn shape_of(head: &[u8]) -> Option<Vec<usize>> {
    split(head).ok().and_then(|(text, _)| header(text, "array").ok()).map(|header| header.shape)
}

/// Reads an array. `name` is its name in errors.
///
/// # Errors
/// The bytes are no .npy file, the type is not read (objects, records, complex numbers), or the
/// header claims more than the bytes hold.
pub(crate) fn read(bytes: &[u8], name: &str) -> Result<NumpyArray, ReadError> {
    let (text, data) = split(bytes).map_err(|message| ReadError::part(name, message))?;
    let header = header(text, name)?;
    let Header { item, size, is_big_endian, is_fortran, shape } = header;
    let count = shape.iter().try_fold(1_usize, |product, &length| product.checked_mul(length));
    let needed = count.and_then(|count| count.checked_mul(size));
    let Some((count, needed)) = count.zip(needed).filter(|(_, needed)| *needed <= data.len()) else {
        let message = format!(
            "the header claims the shape {} of {size} bytes each, but {} bytes follow",
            NumberArray { shape, values: Vec::new() }.shape_text(),
            data.len()
        );
        return Err(ReadError::part(name, message));
    };
    let data = &data[..needed];
    if matches!(item, Item::Unicode | Item::Bytes) {
        if size == 0 {
            // Strings of no characters take no bytes: nothing bounds their number.
            let message = "strings of length 0 are not read";
            return Err(ReadError::part(name, message));
        }
        let strings = data.chunks_exact(size).map(|string| text_of(string, item, is_big_endian));
        return Ok(NumpyArray::Text(strings.collect()));
    }
    let mut values = Vec::with_capacity(count);
    for bytes in data.chunks_exact(size) {
        let Some(value) = number(bytes, item, is_big_endian) else {
            return Err(ReadError::part(name, format!("numbers of {size} bytes are not read")));
        };
        values.push(value);
    }
    Ok(NumpyArray::Numbers(match is_fortran {
        true => NumberArray::from_fortran(shape, &values),
        false => NumberArray { shape, values },
    }))
}

/// Splits the file into the text of the header and the data.
fn split(bytes: &[u8]) -> Result<(&str, &[u8]), String> {
    let cut = || "the header of the array is cut off".to_owned();
    let rest = bytes.strip_prefix(MAGIC).ok_or("this is not a NumPy array")?;
    let (version, rest) = rest.split_at_checked(2).ok_or_else(cut)?;
    let (length, rest) = match version[0] {
        1 => rest.split_first_chunk::<2>().map(|(n, rest)| (u32::from(u16::from_le_bytes(*n)), rest)),
        2 | 3 => rest.split_first_chunk::<4>().map(|(n, rest)| (u32::from_le_bytes(*n), rest)),
        other => return Err(format!("version {other} of NumPy's array format is not read")),
    }
    .ok_or_else(cut)?;
    let (text, data) = rest.split_at_checked(length as usize).ok_or_else(cut)?;
    let text = std::str::from_utf8(text).map_err(|_| "the header of the array is not text")?;
    Ok((text, data))
}

/// Reads the header: `{'descr': '<f8', 'fortran_order': False, 'shape': (2, 11), }`.
fn header(text: &str, name: &str) -> Result<Header, ReadError> {
    let error = |message: String| ReadError::part(name, message);
    let field = |key: &str| {
        let rest = ['\'', '"'].iter().find_map(|quote| text.split_once(&format!("{quote}{key}{quote}")));
        let value = rest.and_then(|(_, rest)| rest.trim_start().strip_prefix(':')).map(str::trim_start);
        value.ok_or_else(|| error(format!("the header of the array has no '{key}'")))
    };
    let (item, size, is_big_endian) = item_type(field("descr")?).map_err(error)?;
    let order = field("fortran_order")?;
    let is_fortran = order.starts_with("True");
    if !is_fortran && !order.starts_with("False") {
        return Err(error("'fortran_order' is neither True nor False".to_owned()));
    }
    let shape = field("shape")?;
    let lengths = shape.strip_prefix('(').and_then(|rest| rest.split_once(')')).map(|(inside, _)| inside);
    let lengths = lengths.ok_or_else(|| error("'shape' is no tuple of lengths".to_owned()))?;
    let lengths = lengths.split(',').map(str::trim).filter(|length| !length.is_empty());
    let shape = lengths.map(|length| length.trim_end_matches('L').parse::<usize>());
    let shape: Vec<usize> =
        shape.collect::<Result<_, _>>().map_err(|_| error("'shape' is no tuple of lengths".to_owned()))?;
    if shape.len() > 32 {
        return Err(error("arrays of more than 32 axes are not read".to_owned()));
    }
    Ok(Header { item, size, is_big_endian, is_fortran, shape })
}

/// The type of the items from the value of 'descr': `'<f8'`.
fn item_type(text: &str) -> Result<(Item, usize, bool), String> {
    if text.starts_with('[') {
        return Err("arrays of records are not read; save each field as an array".to_owned());
    }
    let quote = text.chars().next().filter(|c| matches!(c, '\'' | '"'));
    let inside = quote.and_then(|quote| text[1..].split_once(quote)).map(|(inside, _)| inside);
    let code = inside.ok_or("'descr' is no type")?;
    let (order, rest) = match code.chars().next() {
        Some(order @ ('<' | '>' | '=' | '|')) => (order, &code[1..]),
        _ => ('<', code),
    };
    let kind = rest.chars().next().ok_or("'descr' is no type")?;
    let digits = rest[kind.len_utf8()..].parse::<usize>();
    let item = match kind {
        'f' => Item::Float,
        'i' => Item::Signed,
        'u' | 'b' => Item::Unsigned,
        'U' => Item::Unicode,
        'S' | 'a' => Item::Bytes,
        'O' => {
            return Err("the array holds pickled Python objects, which are not read; \
                        save plain arrays of numbers"
                .to_owned());
        }
        _ => return Err(format!("items of the type '{code}' are not read")),
    };
    let length = digits.map_err(|_| format!("items of the type '{code}' are not read"))?;
    let is_size_known = match item {
        Item::Float => matches!(length, 2 | 4 | 8),
        Item::Signed | Item::Unsigned => matches!(length, 1 | 2 | 4 | 8),
        Item::Unicode | Item::Bytes => length <= MOST_CHARACTERS,
    };
    if !is_size_known {
        return Err(format!("items of the type '{code}' are not read"));
    }
    let size = if item == Item::Unicode { 4 * length } else { length };
    Ok((item, size, order == '>'))
}

/// A number of these bytes.
fn number(bytes: &[u8], item: Item, is_big_endian: bool) -> Option<f64> {
    let mut buffer = [0; 8];
    let little = buffer.get_mut(..bytes.len())?;
    little.copy_from_slice(bytes);
    if is_big_endian {
        little.reverse();
    }
    let bits = u64::from_le_bytes(buffer);
    let unused = 64 - 8 * bytes.len() as u32;
    Some(match (item, bytes.len()) {
        (Item::Float, 2) => f16::from_bits(bits as u16).to_f64(),
        (Item::Float, 4) => f64::from(f32::from_bits(bits as u32)),
        (Item::Float, 8) => f64::from_bits(bits),
        (Item::Unsigned, _) => bits as f64,
        (Item::Signed, _) => ((bits as i64) << unused >> unused) as f64,
        (Item::Float | Item::Unicode | Item::Bytes, _) => return None,
    })
}

/// A string padded with zeros; characters that are none become U+FFFD.
fn text_of(bytes: &[u8], item: Item, is_big_endian: bool) -> String {
    let text: String = match item {
        Item::Unicode => bytes
            .chunks_exact(4)
            .map(|unit| {
                let unit = [unit[0], unit[1], unit[2], unit[3]];
                let code = if is_big_endian { u32::from_be_bytes(unit) } else { u32::from_le_bytes(unit) };
                char::from_u32(code).unwrap_or(char::REPLACEMENT_CHARACTER)
            })
            .collect(),
        _ => String::from_utf8_lossy(bytes).into_owned(),
    };
    text.trim_end_matches('\0').to_owned()
}

#[cfg(test)]
pub(crate) mod tests {
    use proptest::prelude::*;

    use super::*;

    /// The bytes of a .npy file, version 1.
    pub(crate) fn npy(descr: &str, is_fortran: bool, shape: &str, data: &[u8]) -> Vec<u8> {
        let order = if is_fortran { "True" } else { "False" };
        let mut text = format!("{{'descr': {descr}, 'fortran_order': {order}, 'shape': {shape}, }}");
        while !(text.len() + 11).is_multiple_of(64) {
            text.push(' ');
        }
        text.push('\n');
        let mut bytes = MAGIC.to_vec();
        bytes.extend([1, 0]);
        bytes.extend((text.len() as u16).to_le_bytes());
        bytes.extend(text.bytes());
        bytes.extend(data);
        bytes
    }

    /// The bytes of a .npy file of f64 in C order.
    pub(crate) fn npy_f64(shape: &str, values: &[f64]) -> Vec<u8> {
        let data: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
        npy("'<f8'", false, shape, &data)
    }

    fn values(bytes: &[u8]) -> Vec<f64> {
        read(bytes, "array").unwrap().numbers("array").unwrap().values
    }

    fn message(bytes: &[u8]) -> String {
        read(bytes, "array").unwrap_err().to_string()
    }

    #[test]
    fn every_type_is_converted() {
        let numbers: [f64; 3] = [1.5, -2.0, 0.25];
        for (descr, data) in [
            ("'<f8'", numbers.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>()),
            ("'>f8'", numbers.iter().flat_map(|x| x.to_be_bytes()).collect()),
            ("'<f4'", numbers.iter().flat_map(|x| (*x as f32).to_le_bytes()).collect()),
            ("'>f4'", numbers.iter().flat_map(|x| (*x as f32).to_be_bytes()).collect()),
            ("'<f2'", numbers.iter().flat_map(|x| f16::from_f64(*x).to_le_bytes()).collect()),
            ("\">f2\"", numbers.iter().flat_map(|x| f16::from_f64(*x).to_be_bytes()).collect()),
        ] {
            assert_eq!(values(&npy(descr, false, "(3,)", &data)), numbers, "{descr}");
        }
        assert_eq!(values(&npy("'|i1'", false, "(2,)", &[0xff, 2])), [-1.0, 2.0]);
        assert_eq!(values(&npy("'|u1'", false, "(2,)", &[0xff, 2])), [255.0, 2.0]);
        assert_eq!(values(&npy("'|b1'", false, "(2,)", &[0, 1])), [0.0, 1.0]);
        assert_eq!(values(&npy("'>i2'", false, "(1,)", &(-300_i16).to_be_bytes())), [-300.0]);
        assert_eq!(values(&npy("'<i8'", false, "()", &(-3_i64).to_le_bytes())), [-3.0]);
        assert_eq!(values(&npy("'<u4'", false, "(1L,)", &u32::MAX.to_le_bytes())), [f64::from(u32::MAX)]);
        let data: Vec<u8> = [1.0_f64, 2.0, 3.0, 4.0, 5.0, 6.0].iter().flat_map(|x| x.to_le_bytes()).collect();
        assert_eq!(values(&npy("'<f8'", true, "(2, 3)", &data)), [1.0, 3.0, 5.0, 2.0, 4.0, 6.0]);
    }

    #[test]
    fn strings_lose_their_padding() {
        let data: Vec<u8> = "ab\0é\0\0".chars().flat_map(|c| u32::from(c).to_le_bytes()).collect();
        let text = read(&npy("'<U3'", false, "(2,)", &data), "names").unwrap();
        assert_eq!(text, NumpyArray::Text(vec!["ab".to_owned(), "é".to_owned()]));
        let text = read(&npy("'|S2'", false, "(2,)", b"a\0bc"), "names").unwrap();
        assert_eq!(text, NumpyArray::Text(vec!["a".to_owned(), "bc".to_owned()]));
        assert!(text.numbers("names").unwrap_err().to_string().contains("found strings"));
    }

    #[test]
    fn hostile_headers_are_errors() {
        assert!(message(&npy("'|O'", false, "(2,)", &[0; 16])).contains("pickled Python objects"));
        assert!(message(&npy("[('x', '<f8')]", false, "(2,)", &[0; 16])).contains("records"));
        assert!(message(&npy("'<c16'", false, "(2,)", &[0; 32])).contains("'<c16'"));
        assert!(message(&npy("'<f8'", false, "(2, 11)", &[0; 16])).contains("16 bytes follow"));
        let huge = "(4294967296, 4294967296, 16)";
        assert!(message(&npy("'<f8'", false, huge, &[0; 16])).contains("claims the shape"));
        assert!(message(&npy("'<U0'", false, "(4294967296,)", &[])).contains("length 0"));
        assert!(message(&npy("'<f8'", false, "(-1,)", &[])).contains("tuple of lengths"));
        assert!(message(&npy("'é8'", false, "(1,)", &[])).contains("not read"));
        assert!(message(&npy("'<f'", false, "(1,)", &[])).contains("not read"));
        assert!(message(b"\x93NUMPY\x09\x00").contains("version 9"));
        let mut bytes = MAGIC.to_vec();
        bytes.extend([2, 0, 255, 255, 255, 255]);
        assert!(message(&bytes).contains("cut off"));
        let whole = npy_f64("(2,)", &[1.0, 2.0]);
        for end in 0..whole.len() {
            assert!(read(&whole[..end], "array").is_err(), "{end}");
        }
    }

    proptest! {
        #[test]
        fn any_bytes_are_an_array_or_an_error(bytes in prop::collection::vec(any::<u8>(), 0..200), text in "[(){}:',0-9<>fiUOTrue a-z]{0,120}") {
            let _ = read(&bytes, "array");
            let mut file = MAGIC.to_vec();
            file.extend([1, 0]);
            file.extend((text.len() as u16).to_le_bytes());
            file.extend(text.bytes());
            file.extend(bytes);
            let _ = read(&file, "array");
        }
    }
}
