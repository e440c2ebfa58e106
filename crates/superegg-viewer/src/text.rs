//! Numbers and errors as short texts.

use superegg_geom::glam::DVec3;

/// A number with at most this many decimals and without trailing zeros.
pub(crate) fn number_text(x: f64, decimals: usize) -> String {
    let text = format!("{x:.decimals$}");
    let text = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    if text == "-0" { "0".to_owned() } else { text.to_owned() }
}

/// Three numbers separated by spaces, each as [`number_text`] writes it.
pub(crate) fn vector_text(v: DVec3, decimals: usize) -> String {
    v.to_array().map(|x| number_text(x, decimals)).join(" ")
}

/// The first line without surrounding white space. Driver errors span many lines.
pub(crate) fn first_line(text: &str) -> String {
    text.lines().next().unwrap_or_default().trim().to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_written_short() {
        for (x, text) in
            [(1.0, "1"), (-0.0, "0"), (0.1, "0.1"), (-1e-9, "0"), (1e9, "1000000000"), (100.0, "100")]
        {
            assert_eq!(number_text(x, 6), text);
        }
        assert_eq!(number_text(1200.0, 0), "1200");
    }
}
