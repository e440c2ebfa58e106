//! Numbers as the language reads and writes them.

use std::fmt;

use superegg_geom::glam::DVec3;

/// Why a word is not a number of the language.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NumberError {
    /// Not plain decimal or exponent form.
    NotANumber,
    /// Beyond the largest f64.
    TooLarge,
}

impl fmt::Display for NumberError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::NotANumber => "is not a number",
            Self::TooLarge => "is too large a number",
        })
    }
}

/// Reads plain decimal or exponent form: `2`, `1.`, `.5`, `-.6`, `1e-3`. The whole word must be a number; `inf` and `nan` are none.
///
/// # Errors
/// The word is not a number, or larger than the largest f64.
pub fn parse_number(word: &str) -> Result<f64, NumberError> {
    let is_plain = |c: u8| c.is_ascii_digit() || matches!(c, b'+' | b'-' | b'.' | b'e' | b'E');
    if !word.bytes().all(is_plain) {
        return Err(NumberError::NotANumber);
    }
    match word.parse::<f64>() {
        Ok(number) if number.is_finite() => Ok(number),
        Ok(_) => Err(NumberError::TooLarge),
        Err(_) => Err(NumberError::NotANumber),
    }
}

/// The shortest text that reads back to the same f64; exponent form where plain form would be long.
pub fn format_number(x: f64) -> String {
    let magnitude = x.abs();
    if magnitude == 0.0 || (1e-5..1e16).contains(&magnitude) { format!("{x}") } else { format!("{x:e}") }
}

/// Three numbers as the language writes them.
pub(crate) fn vector(v: DVec3) -> String {
    v.to_array().map(format_number).join(" ")
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn reads_what_real_files_have() {
        for (word, value) in
            [("1.", 1.0), (".5", 0.5), ("-.6", -0.6), ("1e-3", 0.001), ("+2", 2.0), ("-57.2958", -57.2958)]
        {
            assert_eq!(parse_number(word), Ok(value));
        }
    }

    #[test]
    fn refuses_what_is_no_number() {
        for word in [
            "", ".", "-", "1e", "e5", "inf", "-inf", "nan", "NaN", "infinity", "0x10", "1,5", "1_0", "12abc",
            "٣", "1e5.", "--1",
        ] {
            assert_eq!(parse_number(word), Err(NumberError::NotANumber), "{word}");
        }
        assert_eq!(parse_number("1e999"), Err(NumberError::TooLarge));
    }

    proptest! {
        #[test]
        fn what_is_written_reads_back_to_the_same_bits(x in any::<f64>().prop_filter("finite", |x| x.is_finite())) {
            prop_assert_eq!(parse_number(&format_number(x)).unwrap().to_bits(), x.to_bits());
        }
    }
}
