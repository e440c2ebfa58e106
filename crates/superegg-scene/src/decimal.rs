//! Reading of short decimal numbers.

use crate::numbers::POWERS;

/// Integers below this are exact in f64.
const MOST_EXACT: u64 = 1 << 53;
/// Integers of this many digits fit a u64.
const MOST_DIGITS: usize = 19;

/// The f64 nearest to a short decimal number at the start of `bytes`, and the length of its word,
/// which ends at a blank, a tab or with the bytes. `None` if the word is no number, or one of many
/// digits or of a large exponent.
///
/// Short numbers are the quotient or product of two exact numbers, which is rounded once (Clinger
/// 1990).
///
/// ```
/// use superegg_scene::short_decimal;
/// assert_eq!(short_decimal(b"-1.25e1 7"), Some((-12.5, 7)));
/// assert_eq!(short_decimal(b"1x"), None);
/// ```
#[inline]
pub fn short_decimal(bytes: &[u8]) -> Option<(f64, usize)> {
    let (is_negative, mut at) = match bytes.first()? {
        b'-' => (true, 1),
        b'+' => (false, 1),
        _ => (false, 0),
    };
    let first = at;
    let mut mantissa = 0_u64;
    // Few digits stand before the point.
    at = digits(bytes, at, &mut mantissa);
    let mut count = at - first;
    let mut places = 0;
    if bytes.get(at) == Some(&b'.') {
        let after = at + 1;
        at = many_digits(bytes, after, &mut mantissa);
        places = at - after;
        count += places;
    }
    // More digits may have overflowed.
    if count == 0 || count > MOST_DIGITS || mantissa >= MOST_EXACT {
        return None;
    }
    let mut exponent = -(places as i32);
    if let Some(b'e' | b'E') = bytes.get(at) {
        let rest = &bytes[at + 1..];
        let length = rest.iter().position(|byte| is_blank(*byte)).unwrap_or(rest.len());
        exponent += exponent_of(&rest[..length])?;
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

/// As [`digits`], eight at once where there are eight bytes.
#[inline]
fn many_digits(bytes: &[u8], mut at: usize, number: &mut u64) -> usize {
    while let Some(&eight) = bytes.get(at..).and_then(<[u8]>::first_chunk) {
        let (value, count) = leading_digits(u64::from_le_bytes(eight));
        *number = number.wrapping_mul(POWERS_OF_TEN[count]).wrapping_add(value);
        at += count;
        if count < 8 {
            return at;
        }
    }
    digits(bytes, at, number)
}

/// 1 to 1e8.
const POWERS_OF_TEN: [u64; 9] = [1, 10, 100, 1_000, 10_000, 100_000, 1_000_000, 10_000_000, 100_000_000];

/// The number of the digits at the start of eight characters, the first one in the lowest byte, and
/// their count (Lemire 2021, "Number parsing at a gigabyte per second").
#[inline]
fn leading_digits(characters: u64) -> (u64, usize) {
    const EACH: u64 = 0x0101_0101_0101_0101;
    let values = characters ^ (EACH * u64::from(b'0'));
    // The highest bit of the lowest byte above 9 is set. Its carry reaches higher bytes only.
    let others = (values.wrapping_add(EACH * 0x76) | values) & (EACH * 0x80);
    let count = others.trailing_zeros() as usize / 8;
    if count == 0 {
        return (0, 0);
    }
    // Zeros before the digits. Neighbours are joined to numbers of two, four and eight digits.
    let digits = values << (64 - 8 * count);
    let pairs = (digits.wrapping_mul(10 << 8 | 1) >> 8) & 0x00ff_00ff_00ff_00ff;
    let fours = (pairs.wrapping_mul(100 << 16 | 1) >> 16) & 0x0000_ffff_0000_ffff;
    (fours.wrapping_mul(10_000 << 32 | 1) >> 32, count)
}

/// An exponent of at most three digits.
fn exponent_of(bytes: &[u8]) -> Option<i32> {
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

#[inline]
fn is_blank(byte: u8) -> bool {
    byte == b' ' || byte == b'\t'
}
