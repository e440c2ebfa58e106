//! Reading and writing of numbers.

use superegg_geom::glam::{DAffine3, DQuat, DVec3};
use superegg_scene::short_decimal;
use thiserror::Error;

/// Why a word is not a number. The message follows the word: `'1e999' is too large a number`.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
#[non_exhaustive]
pub enum NumberError {
    /// The word is not in decimal or exponent form.
    #[error("is not a number")]
    NotANumber,
    /// The number is beyond the largest f64.
    #[error("is too large a number")]
    TooLarge,
}

/// Reads a number in decimal or exponent form: `2`, `1.`, `.5`, `-.6`, `1e-3`. The whole word must
/// be a number; `inf` and `nan` are not.
///
/// # Errors
/// The word is not a number, or larger than the largest f64.
pub fn parse_number(word: &str) -> Result<f64, NumberError> {
    match short_decimal(word.as_bytes()) {
        Some((number, length)) if length == word.len() => return Ok(number),
        Some(_) | None => {}
    }
    match word.parse::<f64>() {
        Ok(number) if number.is_finite() => Ok(number),
        // The standard library takes the words `inf` and `nan`, too.
        Ok(_) if word.bytes().any(|c| c.is_ascii_digit()) => Err(NumberError::TooLarge),
        Ok(_) | Err(_) => Err(NumberError::NotANumber),
    }
}

/// The shortest text that reads back to the same f64; in exponent form below 1e-5 and from 1e16 on.
///
/// ```
/// use superegg_lang::{format_number, parse_number};
///
/// assert_eq!(format_number(0.1), "0.1");
/// assert_eq!(parse_number("1e-3"), Ok(0.001));
/// assert_eq!(parse_number("1,5").unwrap_err().to_string(), "is not a number");
/// ```
pub fn format_number(x: f64) -> String {
    let magnitude = x.abs();
    if magnitude == 0.0 || (1e-5..1e16).contains(&magnitude) { format!("{x}") } else { format!("{x:e}") }
}

/// Three numbers, separated by blanks.
pub(crate) fn vector(v: DVec3) -> String {
    v.to_array().map(format_number).join(" ")
}

/// The numbers w x y z of a quaternion, separated by blanks.
pub(crate) fn quaternion_words(quaternion: DQuat) -> String {
    [quaternion.w, quaternion.x, quaternion.y, quaternion.z].map(format_number).join(" ")
}

/// The twelve numbers of an affine map, row by row, separated by blanks.
pub(crate) fn matrix_words(map: &DAffine3) -> String {
    let rows = map.matrix3.transpose();
    let row = |row: DVec3, offset: f64| format!("{} {}", vector(row), format_number(offset));
    let by = map.translation;
    [row(rows.x_axis, by.x), row(rows.y_axis, by.y), row(rows.z_axis, by.z)].join(" ")
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
