//! Numbers of binary files: their types, their byte order, and how they become f64.

/// A type of number in a binary file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    I64,
    U64,
    F32,
    F64,
}

/// The order of the bytes of a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ByteOrder {
    Little,
    Big,
}

impl Scalar {
    /// The size of a number in bytes.
    pub(super) fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::I64 | Self::U64 | Self::F64 => 8,
        }
    }

    /// The numbers in `bytes` as f64; a rest shorter than one number is left out. Integers beyond
    /// 2^53 are rounded.
    pub(super) fn decode(self, bytes: &[u8], order: ByteOrder) -> Vec<f64> {
        /// The numbers of one type.
        macro_rules! numbers {
            ($type:ty) => {{
                let (chunks, _) = bytes.as_chunks::<{ size_of::<$type>() }>();
                let number = |chunk: &[u8; size_of::<$type>()]| match order {
                    ByteOrder::Little => <$type>::from_le_bytes(*chunk),
                    ByteOrder::Big => <$type>::from_be_bytes(*chunk),
                };
                chunks.iter().map(|chunk| number(chunk) as f64).collect()
            }};
        }
        match self {
            Self::I8 => numbers!(i8),
            Self::U8 => numbers!(u8),
            Self::I16 => numbers!(i16),
            Self::U16 => numbers!(u16),
            Self::I32 => numbers!(i32),
            Self::U32 => numbers!(u32),
            Self::I64 => numbers!(i64),
            Self::U64 => numbers!(u64),
            Self::F32 => numbers!(f32),
            Self::F64 => numbers!(f64),
        }
    }
}

/// The numbers of a text between blanks, exactly `count` of them.
///
/// # Errors
/// A word that is no number, or another count. The message names neither line nor array.
pub(super) fn parse_numbers(text: &[u8], count: usize) -> Result<Vec<f64>, String> {
    // A number takes at least one byte and one blank.
    let mut numbers = Vec::with_capacity(count.min(text.len() / 2 + 1));
    for word in text.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty()) {
        if numbers.len() == count {
            return Err(format!("expected {count} numbers, found more"));
        }
        numbers.push(parse_number(word)?);
    }
    if numbers.len() == count {
        Ok(numbers)
    } else {
        Err(format!("expected {count} numbers, found {}", numbers.len()))
    }
}

/// One number of a text.
///
/// # Errors
/// The word is no number.
pub(super) fn parse_number(word: &[u8]) -> Result<f64, String> {
    let number = std::str::from_utf8(word).ok().and_then(|word| word.parse().ok());
    number.ok_or_else(|| format!("expected a number, found '{}'", shortened(word)))
}

/// A word for a message: at most 40 characters, without control characters.
pub(super) fn shortened(word: &[u8]) -> String {
    let text = String::from_utf8_lossy(&word[..word.len().min(160)]);
    let mut short: String = text.chars().filter(|c| !c.is_control()).take(40).collect();
    if short.len() < word.len() {
        short.push_str("...");
    }
    short
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_each_type_keep_their_value_in_both_orders() {
        assert_eq!(Scalar::I8.decode(&[0xff, 2], ByteOrder::Little), [-1.0, 2.0]);
        assert_eq!(Scalar::U8.decode(&[0xff], ByteOrder::Big), [255.0]);
        assert_eq!(Scalar::I16.decode(&[0xff, 0xfe], ByteOrder::Big), [-2.0]);
        assert_eq!(Scalar::U16.decode(&[1, 2], ByteOrder::Little), [513.0]);
        assert_eq!(Scalar::I32.decode(&(-7i32).to_be_bytes(), ByteOrder::Big), [-7.0]);
        assert_eq!(Scalar::U32.decode(&u32::MAX.to_le_bytes(), ByteOrder::Little), [4294967295.0]);
        assert_eq!(Scalar::I64.decode(&i64::MIN.to_be_bytes(), ByteOrder::Big), [-9223372036854775808.0]);
        assert_eq!(Scalar::U64.decode(&9u64.to_le_bytes(), ByteOrder::Little), [9.0]);
        assert_eq!(Scalar::F32.decode(&0.1f32.to_be_bytes(), ByteOrder::Big), [f64::from(0.1f32)]);
        assert_eq!(Scalar::F64.decode(&0.1f64.to_le_bytes(), ByteOrder::Little), [0.1]);
        assert_eq!(Scalar::F64.decode(&[0; 15], ByteOrder::Little), [0.0]);
    }

    #[test]
    fn a_text_has_as_many_numbers_as_it_claims() {
        assert_eq!(parse_numbers(b" 1\n-2.5e3\t nan ", 3).unwrap()[..2], [1.0, -2500.0]);
        assert_eq!(
            parse_numbers(b"", usize::MAX).unwrap_err(),
            format!("expected {} numbers, found 0", usize::MAX)
        );
        assert!(parse_numbers(b"1 2 3", 2).unwrap_err().contains("found more"));
        assert!(parse_numbers(b"1 two", 2).unwrap_err().contains("'two'"));
        assert!(parse_numbers(&[b'x'; 1000], 1).unwrap_err().len() < 100);
        assert!(parse_numbers(&[0xff, 0xfe], 1).is_err());
    }
}
