//! Columns of numbers that take half the memory where the numbers have at most six digits.

use std::hash::Hasher;

/// Rows of `N` numbers each. All are f32 as long as each number is a decimal of six digits, as
/// programs print by default: such a number is recovered to the bit. Otherwise all are f64.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Numbers<const N: usize> {
    Single(Vec<[f32; N]>),
    Double(Vec<[f64; N]>),
}

impl<const N: usize> Default for Numbers<N> {
    fn default() -> Self {
        Self::Single(Vec::new())
    }
}

impl<const N: usize> Numbers<N> {
    pub(crate) fn reserve(&mut self, rows: usize) {
        match self {
            Self::Single(held) => held.reserve_exact(rows),
            Self::Double(held) => held.reserve_exact(rows),
        }
    }

    /// Inlined: a row that is stored and loaded again costs more than it takes to recover it.
    #[inline]
    pub(crate) fn get(&self, row: usize) -> [f64; N] {
        match self {
            Self::Single(held) => decimals(&held[row]),
            Self::Double(held) => held[row],
        }
    }

    pub(crate) fn push(&mut self, row: [f64; N]) {
        if let Self::Single(held) = self {
            let single = row.map(|number| number as f32);
            let is_same = |(a, b): (f64, f64)| a.to_bits() == b.to_bits();
            if decimals(&single).into_iter().zip(row).all(is_same) {
                held.push(single);
                return;
            }
            let mut double = Vec::with_capacity(held.capacity());
            double.extend(held.iter().map(decimals));
            *self = Self::Double(double);
        }
        if let Self::Double(held) = self {
            held.push(row);
        }
    }

    pub(crate) fn shrink(&mut self) {
        match self {
            Self::Single(held) => held.shrink_to_fit(),
            Self::Double(held) => held.shrink_to_fit(),
        }
    }

    pub(crate) fn bytes(&self) -> usize {
        match self {
            Self::Single(held) => held.capacity() * size_of::<[f32; N]>(),
            Self::Double(held) => held.capacity() * size_of::<[f64; N]>(),
        }
    }

    pub(crate) fn hash(&self, hasher: &mut impl Hasher) {
        match self {
            Self::Single(held) => hasher.write(bytemuck::cast_slice(held.as_flattened())),
            Self::Double(held) => hasher.write(bytemuck::cast_slice(held.as_flattened())),
        }
    }
}

/// 1 to 1e22: the powers of ten that f64 holds exactly.
pub(crate) const POWERS: [f64; 23] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18,
    1e19, 1e20, 1e21, 1e22,
];
/// Adding and subtracting this rounds a smaller number to an integer.
const ROUNDER: f64 = 1.5 * (1_u64 << 52) as f64;

/// A loop, because `array::map` is not inlined here.
#[inline]
fn decimals<const N: usize>(row: &[f32; N]) -> [f64; N] {
    let mut numbers = [0.0; N];
    for (number, single) in numbers.iter_mut().zip(row) {
        *number = decimal(*single);
    }
    numbers
}

/// The f64 nearest to the decimal of six digits that is nearest to `single`; `single` itself where
/// that decimal has an exponent beyond exact powers of ten.
#[inline]
fn decimal(single: f32) -> f64 {
    let number = f64::from(single);
    let exponent = (number.to_bits() >> 52 & 0x7ff) as i32 - 1023;
    // A lower bound of log10, at most one too small: log10(2) is 0.30103. Then the integer below
    // has seven digits.
    let places = 5 - ((exponent * 1233) >> 12);
    // The quotient of two exact numbers is rounded once, as a parser rounds it.
    let rounded = |scaled: f64| {
        let seven = (scaled + ROUNDER) - ROUNDER;
        // An integer of seven digits is rounded to six.
        if seven.abs() >= 1e6 { ((scaled * 0.1 + ROUNDER) - ROUNDER) * 10.0 } else { seven }
    };
    match POWERS.get(places.unsigned_abs() as usize) {
        Some(power) if places >= 0 => rounded(number * power) / power,
        Some(power) => rounded(number / power) * power,
        None => number,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_six_digits_come_back_to_the_bit_as_single() {
        let mut column = Numbers::<2>::default();
        let mut state = 12345_u64;
        let mut rows = Vec::new();
        for i in 0..20_000 {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            let number = (state >> 11) as f64 / (1u64 << 53) as f64 - 0.5;
            let sized = number * 10f64.powi(i % 26 - 13);
            let number: f64 = format!("{sized:.5e}").parse().unwrap();
            let short: f64 = format!("{sized:.2e}").parse().unwrap();
            rows.push([number, short]);
        }
        rows.extend([[0.0, 1.0], [1e5, 1e6], [999_999.0, 1e-3], [0.1, -0.1], [9.99999e-5, 1e-4]]);
        rows.iter().for_each(|row| column.push(*row));
        assert!(matches!(column, Numbers::Single(_)));
        rows.iter().enumerate().for_each(|(i, row)| assert_eq!(column.get(i), *row));
    }

    #[test]
    fn any_other_number_makes_the_column_double_and_loses_nothing() {
        for odd in [0.123_456_7, 1.0 / 3.0, f64::from(0.1_f32), -0.0, 1e300, 5e-324, 1_234_567.0, 1e38, 3e-40]
        {
            let mut column = Numbers::<1>::default();
            column.push([0.5]);
            column.push([odd]);
            column.push([0.25]);
            assert_eq!(column.get(0), [0.5]);
            assert_eq!(column.get(1)[0].to_bits(), odd.to_bits(), "{odd}");
            assert_eq!(column.get(2), [0.25]);
        }
    }
}
