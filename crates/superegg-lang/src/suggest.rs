//! The nearest known word to one that looks like a slip.

/// The candidate that `word` is most likely a slip of, or `None` where none is near: at most one edit in three letters, three in all.
pub fn nearest<'a>(word: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    /// Longer words are not compared: it takes time by the square.
    const LONGEST: usize = 64;
    /// Of more candidates only the first are looked at, so that a file full of errors is read in its time.
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
