//! Round numbers, for the ticks of a legend and the length of a scale bar.

use superegg_lang::format_number;

/// A number with its text.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Label {
    pub(super) value: f64,
    pub(super) text: String,
}

/// `digits` times ten to the power of `exponent`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Decimal {
    digits: i128,
    exponent: i32,
}

impl Decimal {
    fn value(self) -> f64 {
        let Self { digits, exponent } = self;
        format!("{digits}e{exponent}").parse().unwrap_or(f64::NAN)
    }

    /// Without a power of ten, for exponents below [`MOST_PLACES`].
    fn plain(self) -> String {
        let Self { digits, exponent } = self;
        let places = usize::try_from(-exponent).unwrap_or(0);
        let zeros = if digits == 0 { 0 } else { usize::try_from(exponent).unwrap_or(0) };
        let all = format!("{:0>width$}{}", digits.unsigned_abs(), "0".repeat(zeros), width = places + 1);
        let (whole, rest) = all.split_at(all.len() - places.min(all.len() - 1));
        let sign = if digits < 0 { "-" } else { "" };
        let point = if rest.is_empty() { "" } else { "." };
        format!("{sign}{whole}{point}{rest}")
    }

    /// With a power of ten: one figure before the point.
    fn scientific(self) -> String {
        if self.digits == 0 {
            return "0".to_owned();
        }
        let all = self.digits.unsigned_abs().to_string();
        let exponent = self.exponent + all.len() as i32 - 1;
        let (first, rest) = all.split_at(1);
        let rest = rest.trim_end_matches('0');
        let sign = if self.digits < 0 { "-" } else { "" };
        let point = if rest.is_empty() { "" } else { "." };
        format!("{sign}{first}{point}{rest}e{exponent}")
    }
}

/// Longer texts of numbers have a power of ten.
const LONGEST: usize = 6;
/// Numbers with more places have a power of ten.
const MOST_PLACES: usize = 40;

/// Numbers of one column as texts: all with a power of ten if that is shorter than long numbers.
fn labels(numbers: &[Decimal]) -> Vec<Label> {
    let longest = |texts: &[String]| texts.iter().map(String::len).max().unwrap_or(0);
    let is_plain = numbers.iter().all(|number| number.exponent.unsigned_abs() < MOST_PLACES as u32);
    let plain: Vec<String> = numbers.iter().filter(|_| is_plain).map(|number| number.plain()).collect();
    let scientific: Vec<String> = numbers.iter().map(|number| number.scientific()).collect();
    let is_short = longest(&plain) <= LONGEST.max(longest(&scientific));
    let texts = if is_plain && is_short { plain } else { scientific };
    numbers.iter().zip(texts).map(|(number, text)| Label { value: number.value(), text }).collect()
}

/// Three to five equally spaced numbers of a range, 1, 2, 5 or, where those give too few or too many,
/// 2.5 times a power of ten apart. The ends of a range too narrow for such; one number for a range
/// without width; none for one whose ends are not in order.
pub(super) fn ticks([low, high]: [f64; 2]) -> Vec<Label> {
    let exact = |value: f64| Label { value, text: format_number(value) };
    if low == high {
        return vec![exact(low)];
    }
    if !(low < high && low.is_finite() && high.is_finite()) {
        return Vec::new();
    }
    // A tenth, because the width may overflow.
    let decade = (0.1 * high - 0.1 * low).log10().floor();
    let decade = if decade.is_finite() { decade as i32 } else { return vec![exact(low), exact(high)] };
    let round = steps(&[1, 2, 5], decade).chain(steps(&[25], decade - 1));
    let mut found = round.filter_map(|step| multiples(step, [low, high]));
    found.next().map_or_else(|| vec![exact(low), exact(high)], |numbers| labels(&numbers))
}

/// Steps of these digits about a power of ten, in order.
fn steps(digits: &'static [i128], decade: i32) -> impl Iterator<Item = Decimal> {
    let of_exponent = |exponent: i32| digits.iter().map(move |&digits| Decimal { digits, exponent });
    (decade - 1..=decade + 2).flat_map(of_exponent)
}

/// The multiples of a step in a range, if they are three to five.
fn multiples(step: Decimal, [low, high]: [f64; 2]) -> Option<Vec<Decimal>> {
    let (first, last) = ((low / step.value()).floor(), (high / step.value()).ceil());
    // Beyond 2^63 floats have gaps of more than a step.
    if !(last - first < 16.0 && first.abs() < 9e18 && last.abs() < 9e18) {
        return None;
    }
    // The quotients are rounded, so the numbers decide which are in the range.
    let all = (first as i128 - 1..=last as i128 + 1)
        .map(|count| Decimal { digits: count * step.digits, exponent: step.exponent });
    let inside: Vec<Decimal> = all.filter(|number| (low..=high).contains(&number.value())).collect();
    let is_rising = inside.windows(2).all(|pair| pair[0].value() < pair[1].value());
    ((3..=5).contains(&inside.len()) && is_rising).then_some(inside)
}

/// The number 1, 2 or 5 times a power of ten that is nearest to a length, by ratio; `None` for one
/// that is not above 0, or so large or small that none is near.
pub(super) fn round_length(length: f64) -> Option<Label> {
    if !(length > 0.0 && length.is_finite()) {
        return None;
    }
    let decade = length.log10().floor() as i32;
    let near = (decade - 1..=decade + 1)
        .flat_map(|exponent| [1, 2, 5].map(|digits| Decimal { digits, exponent }))
        .filter(|number| number.value() > 0.0 && number.value().is_finite());
    let away = |number: &Decimal| (number.value() / length).ln().abs();
    let nearest = near.min_by(|a, b| away(a).total_cmp(&away(b)))?;
    labels(&[nearest]).pop()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A small generator with a seed.
    fn random(state: &mut u64) -> f64 {
        *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (*state >> 11) as f64 / (1u64 << 53) as f64
    }

    fn texts(range: [f64; 2]) -> Vec<String> {
        ticks(range).into_iter().map(|tick| tick.text).collect()
    }

    #[test]
    fn ticks_are_three_to_five_round_numbers_inside_the_range() {
        let mut state = 7;
        for round in 0..20_000 {
            let scale = 10f64.powf(600.0 * random(&mut state) - 300.0);
            let low = scale * (2.0 * random(&mut state) - 1.0);
            let high = low + scale * random(&mut state) * if round % 3 == 0 { 1e-6 } else { 1.0 };
            if low == high {
                continue;
            }
            let ticks = ticks([low, high]);
            let values: Vec<f64> = ticks.iter().map(|tick| tick.value).collect();
            assert!((3..=5).contains(&values.len()), "{low} {high}: {values:?}");
            assert!(values.iter().all(|value| (low..=high).contains(value)), "{low} {high}: {values:?}");
            for tick in &ticks {
                assert_eq!(tick.text.parse::<f64>(), Ok(tick.value), "{low} {high}");
                assert!(tick.text.len() <= 24, "{}", tick.text);
            }
            // The step has the digits 1, 2, 25 or 5, up to the rounding of the difference.
            let slack = 1e-15 * low.abs().max(high.abs()) / scale;
            for pair in values.windows(2) {
                let step = pair[1] - pair[0];
                let power = step.log10().floor();
                let digits = step / 10f64.powf(power);
                let is_near = |round: f64| (digits / round - 1.0).abs() < 1e-9 + slack * scale / step;
                assert!([1.0, 2.0, 2.5, 5.0, 10.0].into_iter().any(is_near), "{low} {high}: {digits}");
            }
        }
    }

    #[test]
    fn ticks_of_known_ranges() {
        assert_eq!(texts([0.0, 1.0]), ["0.0", "0.5", "1.0"]);
        assert_eq!(texts([0.0137, 9.42]), ["2", "4", "6", "8"]);
        assert_eq!(texts([-1.0, 1.0]), ["-1.0", "-0.5", "0.0", "0.5", "1.0"]);
        assert_eq!(texts([0.0, 4.2e-7]), ["0", "1e-7", "2e-7", "3e-7", "4e-7"]);
        assert_eq!(texts([1.0, 4000.0]), ["1000", "2000", "3000", "4000"]);
        assert_eq!(texts([-3e7, 4e7]), ["-2e7", "0", "2e7", "4e7"]);
        assert_eq!(texts([7.0, 7.0]), ["7"]);
        assert_eq!(texts([2.0, 1.0]), [""; 0]);
        assert_eq!(texts([f64::NAN, 1.0]), [""; 0]);
        assert_eq!(texts([0.0, f64::INFINITY]), [""; 0]);
    }

    #[test]
    fn ranges_at_the_limits_of_numbers_have_ticks() {
        let next = |value: f64| value.next_up();
        for [low, high] in [
            [-f64::MAX, f64::MAX],
            [0.0, f64::MIN_POSITIVE],
            [0.0, 5e-324],
            [1.0, next(1.0)],
            [1e300, next(1e300)],
            [1e16, 1e16 + 6.0],
            [-5e-324, 5e-324],
        ] {
            let ticks = ticks([low, high]);
            assert!((2..=5).contains(&ticks.len()), "{low} {high}: {ticks:?}");
            for tick in ticks {
                assert!((low..=high).contains(&tick.value), "{low} {high}");
                assert_eq!(tick.text.parse::<f64>(), Ok(tick.value), "{low} {high}");
            }
        }
    }

    #[test]
    fn round_lengths_are_near() {
        let mut state = 3;
        for _ in 0..10_000 {
            let length = 10f64.powf(600.0 * random(&mut state) - 300.0);
            let round = round_length(length).unwrap();
            let ratio = round.value / length;
            assert!((0.63..1.6).contains(&ratio), "{length}: {}", round.text);
            assert_eq!(round.text.parse::<f64>(), Ok(round.value));
            assert!(round.text.len() <= 6, "{}", round.text);
        }
        let text = |length| round_length(length).map(|label| label.text);
        assert_eq!([text(0.0043), text(3.1), text(900.0)].map(Option::unwrap), ["0.005", "2", "1000"]);
        assert_eq!([text(0.0), text(-1.0), text(f64::NAN), text(f64::INFINITY)], [const { None }; 4]);
        assert!(text(5e-324).is_some() && text(f64::MAX).is_some());
    }
}
