//! Names for new things.

/// The first of the word with `first`, with the number after it, and so on, that is not taken.
///
/// ```
/// assert_eq!(superegg_scene::numbered_name("ball", 2, |name| name == "ball2"), "ball3");
/// ```
pub fn numbered_name(word: &str, first: u32, is_taken: impl Fn(&str) -> bool) -> String {
    (first..).map(|number| format!("{word}{number}")).find(|name| !is_taken(name)).unwrap_or_default()
}
