//! Suggestions for misspelt words.

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
    candidates
        .into_iter()
        .take(MOST)
        .filter(|candidate| {
            candidate.len() <= 2 * LONGEST && candidate.chars().count().abs_diff(length) <= allowed
        })
        .map(|candidate| (strsim::damerau_levenshtein(&wanted, &candidate.to_lowercase()), candidate))
        .filter(|(distance, candidate)| *distance <= allowed && *distance < candidate.chars().count())
        .min_by_key(|(distance, _)| *distance)
        .map(|(_, candidate)| candidate)
}

/// The help for an unknown word: the nearest known one, else `otherwise`.
pub(crate) fn did_you_mean<'a>(word: &str, known: impl Iterator<Item = &'a str>, otherwise: &str) -> String {
    match nearest(word, known) {
        Some(near) => format!("did you mean '{near}'?"),
        None => otherwise.to_owned(),
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
