//! Decimal numbers in bytes.

use superegg_scene::short_decimal;

/// The f64 nearest to the decimal number at the start of `bytes`, and the length of its word, which
/// ends at a blank or with the bytes; `None` if the word is no number.
///
/// Numbers that are not short go to the parser of the standard library.
#[inline]
pub(super) fn parse_word(bytes: &[u8]) -> Option<(f64, usize)> {
    if let Some(found) = short_decimal(bytes) {
        return Some(found);
    }
    let word = &bytes[..word_length(bytes)];
    Some((std::str::from_utf8(word).ok()?.parse().ok()?, word.len()))
}

/// The f64 nearest to the decimal number that the whole of `word` is; `None` if it is no number.
pub(super) fn parse(word: &[u8]) -> Option<f64> {
    match short_decimal(word) {
        Some((number, length)) if length == word.len() => Some(number),
        _ => std::str::from_utf8(word).ok()?.parse().ok(),
    }
}

/// Whether a byte separates words.
#[inline]
pub(super) fn is_blank(byte: u8) -> bool {
    byte == b' ' || byte == b'\t'
}

/// The number of bytes before the first blank.
#[inline]
pub(super) fn word_length(bytes: &[u8]) -> usize {
    bytes.iter().position(|byte| is_blank(*byte)).unwrap_or(bytes.len())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(text: &str) -> Option<u64> {
        parse_word(text.as_bytes()).map(|(number, _)| number.to_bits())
    }

    #[test]
    fn numbers_are_those_of_the_standard_library() {
        let mut state = 7_u64;
        let mut words: Vec<String> = [
            "0",
            "-0",
            "+1.5",
            ".5",
            "5.",
            "-.25e2",
            "1e22",
            "1e23",
            "9007199254740993",
            "1e-400",
            "123456789012345678901234567890",
            "0.000000000000000000000000000001",
            "00012.50",
            "1E+5",
            "nan",
            "inf",
            "-Infinity",
        ]
        .map(str::to_owned)
        .to_vec();
        for i in 0..50_000 {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            let number = f64::from_bits(state >> 2 ^ (state << 40));
            words.push(format!("{number}"));
            words.push(format!("{:.*e}", i % 18, (state >> 11) as f64 * 1e-9));
        }
        for word in words {
            let expected: Option<f64> = word.parse().ok();
            assert_eq!(parse(&word), expected.map(f64::to_bits), "{word}");
            let longer = format!("{word} 5");
            assert_eq!(parse(&longer), expected.map(f64::to_bits), "{longer}");
        }
        for wrong in ["", "-", ".", "e5", "1e", "1e+", "1.2.3", "1x", "--1", "0x10", "1e5.5"] {
            assert_eq!(parse(wrong), None, "{wrong}");
        }
    }
}
