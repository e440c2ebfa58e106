//! Suggestions for misspelt words.

use crate::text::shorten;

/// The candidate nearest to a misspelt word, by Damerau-Levenshtein distance; `None` if none is
/// near: at most one edit per three letters, and three in all.
///
/// ```
/// assert_eq!(superegg_lang::nearest("tranlsate", ["translate", "rotate"]), Some("translate"));
/// assert_eq!(superegg_lang::nearest("banana", ["translate", "rotate"]), None);
/// ```
pub fn nearest<'a>(word: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    /// Longer words are not compared: the distance takes quadratic time.
    const LONGEST: usize = 64;
    /// The maximal number of candidates, so that a file full of errors loads quickly.
    const MOST: usize = 1000;
    let wanted = word.to_lowercase();
    let length = wanted.chars().count();
    if length > LONGEST {
        return None;
    }
    let allowed = (length / 3).clamp(1, 3);
    let letters = letters(&wanted);
    candidates
        .into_iter()
        .take(MOST)
        .filter(|candidate| {
            candidate.len() <= 2 * LONGEST && candidate.chars().count().abs_diff(length) <= allowed
        })
        // An edit changes at most two letters of the set.
        .filter(|candidate| {
            let other = self::letters(candidate);
            letters.zip(other).is_none_or(|(a, b)| (a ^ b).count_ones() as usize <= 2 * allowed)
        })
        .map(|candidate| (strsim::damerau_levenshtein(&wanted, &candidate.to_lowercase()), candidate))
        .filter(|(distance, candidate)| *distance <= allowed && *distance < candidate.chars().count())
        .min_by_key(|(distance, _)| *distance)
        .map(|(_, candidate)| candidate)
}

/// The set of the characters of an ASCII word, without case; `None` for another word.
fn letters(word: &str) -> Option<u64> {
    word.is_ascii().then(|| word.bytes().fold(0, |set, byte| set | 1 << (byte.to_ascii_lowercase() % 64)))
}

/// Whether faults suggest a known word for an unknown one. A search through many names takes a
/// while, so a file with many faults goes without.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Suggestions {
    #[default]
    Given,
    Omitted,
}

impl Suggestions {
    /// The help for an unknown word: the nearest known one, else `otherwise`.
    pub(crate) fn did_you_mean<'a>(
        self,
        word: &str,
        known: impl IntoIterator<Item = &'a str>,
        otherwise: &str,
    ) -> String {
        let near = if self == Self::Given { nearest(word, known) } else { None };
        near.map_or_else(|| otherwise.to_owned(), |near| format!("did you mean '{}'?", shorten(near)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn finds_slips_and_nothing_else() {
        let words = ["setCoeff", "setColor", "translate", "ap"];
        assert_eq!(nearest("setcolour", words), Some("setColor"));
        assert_eq!(nearest("tranlsate", words), Some("translate"));
        assert_eq!(nearest("banana", words), None);
        assert_eq!(nearest("xy", words), None);
        assert_eq!(nearest(&"x".repeat(10_000), words), None);
    }
}
