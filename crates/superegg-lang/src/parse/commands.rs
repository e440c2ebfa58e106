//! Several commands in one line, with `;` between.

use crate::color::is_hexadecimal;

/// The commands of a line and the column, in characters, at which each begins. They are separated by
/// a `;` that is at the end of a word or stands alone: a name may contain one. A comment and a file
/// name between double quotes may contain any.
///
/// ```
/// use superegg_lang::split_commands;
///
/// assert_eq!(split_commands("prm ball; color red # a; b"), [(0, "prm ball"), (9, " color red # a; b")]);
/// assert_eq!(split_commands("obj a;b"), [(0, "obj a;b")]);
/// ```
pub fn split_commands(line: &str) -> Vec<(usize, &str)> {
    let mut commands = Vec::new();
    let (mut start, mut start_column) = (0, 0);
    let mut is_quoted = false;
    let mut before = ' ';
    for (column, (byte, c)) in line.char_indices().enumerate() {
        let after = line[byte + c.len_utf8()..].chars().next();
        match c {
            '"' if is_quoted => is_quoted = false,
            '"' if before.is_whitespace() => is_quoted = true,
            '#' if !is_quoted && !begins_color(before, &line[byte + 1..]) => break,
            ';' if !is_quoted && (before.is_whitespace() || after.is_none_or(char::is_whitespace)) => {
                commands.push((start_column, &line[start..byte]));
                (start, start_column) = (byte + 1, column + 1);
            }
            _ => {}
        }
        before = c;
    }
    commands.push((start_column, &line[start..]));
    if commands.len() > 1 {
        commands.retain(|(_, command)| !command.trim().is_empty());
    }
    commands
}

/// Whether a `#` after this character begins a colour, given the text after it.
fn begins_color(before: char, after: &str) -> bool {
    let digits = after.split(|c: char| c.is_whitespace() || c == ';').next().unwrap_or_default();
    before.is_whitespace() && is_hexadecimal(digits)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn comments_quotes_colours_and_names_keep_their_marks() {
        for (line, expected) in [
            ("", &[(0, "")][..]),
            ("prm a", &[(0, "prm a")]),
            ("prm a;", &[(0, "prm a")]),
            (";; prm a ;", &[(2, " prm a ")]),
            (";", &[]),
            ("prm größe; prm b", &[(0, "prm größe"), (10, " prm b")]),
            ("color #ff8000; gloss 1", &[(0, "color #ff8000"), (14, " gloss 1")]),
            ("load \"a; b.scn\"; info", &[(0, "load \"a; b.scn\""), (16, " info")]),
            ("prm a # ; prm b", &[(0, "prm a # ; prm b")]),
            ("prm a;b; info", &[(0, "prm a;b"), (8, " info")]),
        ] {
            assert_eq!(split_commands(line), expected, "{line}");
        }
    }
}
