//! The text of the prompt.

use superegg_lang::visible;

use crate::modeller::Modeller;

/// The maximum length of a name in the prompt; longer names are cut.
const LONGEST_NAME: usize = 24;

/// The selection and the child at its cursor: `snowman[head]> `.
pub(super) fn prompt_text(modeller: &Modeller) -> String {
    let selection = modeller.session().selection();
    match (selection.selected, selection.cursor()) {
        (None, _) => "superegg> ".to_owned(),
        (Some(name), None) => format!("{}> ", short_name(name)),
        (Some(name), Some(cursor)) => format!("{}[{}]> ", short_name(name), short_name(cursor)),
    }
}

/// A name for a terminal, cut after [`LONGEST_NAME`] characters.
fn short_name(name: &str) -> String {
    let shown = visible(name);
    let mut short: String = shown.chars().take(LONGEST_NAME).collect();
    if shown.chars().nth(LONGEST_NAME).is_some() {
        short.push('…');
    }
    short
}
