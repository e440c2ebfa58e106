//! Decimal numbers in bytes.

/// 1 to 1e22: the powers of ten that f64 holds exactly.
const POWERS: [f64; 23] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18,
    1e19, 1e20, 1e21, 1e22,
];
/// Integers below this are exact in f64.
const MOST_EXACT: u64 = 1 << 53;
/// Integers of this many digits fit a u64.
const MOST_DIGITS: usize = 19;

/// The f64 nearest to the decimal number at the start of `bytes`, and the length of its word, which
/// ends at a blank or with the bytes; `None` if the word is no number.
///
/// Short numbers are the quotient or product of two exact numbers, which is rounded once (Clinger
/// 1990). All others go to the parser of the standard library.
#[inline]
pub(super) fn parse_word(bytes: &[u8]) -> Option<(f64, usize)> {
    if let Some(found) = short(bytes) {
        return Some(found);
    }
    let word = &bytes[..word_length(bytes)];
    Some((std::str::from_utf8(word).ok()?.parse().ok()?, word.len()))
}

/// The f64 nearest to the decimal number that the whole of `word` is; `None` if it is no number.
pub(super) fn parse(word: &[u8]) -> Option<f64> {
    match short(word) {
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

#[inline]
fn short(bytes: &[u8]) -> Option<(f64, usize)> {
    let (is_negative, mut at) = match bytes.first()? {
        b'-' => (true, 1),
        b'+' => (false, 1),
        _ => (false, 0),
    };
    let first = at;
    let mut mantissa = 0_u64;
    at = digits(bytes, at, &mut mantissa);
    let mut count = at - first;
    let mut places = 0;
    if bytes.get(at) == Some(&b'.') {
        let after = at + 1;
        at = digits(bytes, after, &mut mantissa);
        places = at - after;
        count += places;
    }
    // More digits may have overflowed.
    if count == 0 || count > MOST_DIGITS || mantissa >= MOST_EXACT {
        return None;
    }
    let mut exponent = -(places as i32);
    if let Some(b'e' | b'E') = bytes.get(at) {
        let length = word_length(&bytes[at + 1..]);
        exponent += self::exponent(&bytes[at + 1..at + 1 + length])?;
        at += 1 + length;
    }
    if bytes.get(at).is_some_and(|byte| !is_blank(*byte)) {
        return None;
    }
    let number = mantissa as f64;
    let power = POWERS.get(exponent.unsigned_abs() as usize)?;
    let number = if exponent < 0 { number / power } else { number * power };
    Some((if is_negative { -number } else { number }, at))
}

/// Appends the digits from an index on to a number and returns the index after them.
#[inline]
fn digits(bytes: &[u8], mut at: usize, number: &mut u64) -> usize {
    while let Some(digit) = bytes.get(at).map(|byte| byte.wrapping_sub(b'0')).filter(|digit| *digit < 10) {
        *number = number.wrapping_mul(10).wrapping_add(digit.into());
        at += 1;
    }
    at
}

/// An exponent of at most three digits.
fn exponent(bytes: &[u8]) -> Option<i32> {
    let (sign, digits) = match bytes.split_first()? {
        (b'-', rest) => (-1, rest),
        (b'+', rest) => (1, rest),
        _ => (1, bytes),
    };
    if digits.is_empty() || digits.len() > 3 || !digits.iter().all(u8::is_ascii_digit) {
        return None;
    }
    Some(sign * digits.iter().fold(0, |value, digit| value * 10 + i32::from(digit - b'0')))
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
