//! The line of a text that sets the exponents of a primitive, for sliders.

use serde::Serialize;
use superegg_lang::{Command, PrimitiveCommand, Session, format_number, parse_line, split_commands};

use crate::file::run_text;
use crate::text::{lines_of, units_of};

/// The decimals of a slider's numbers.
const DECIMALS: f64 = 1e3;

/// The exponents of a primitive, and where the text sets them.
#[derive(Serialize)]
pub(crate) struct Exponents {
    name: String,
    e: f64,
    n: f64,
    /// The command as typed, such as `exp`.
    word: String,
    /// The line, from 0, and the columns to replace, in UTF-16 units. Where `is_new` is true, the command is put into a line
    /// of its own behind that line.
    line: usize,
    from: usize,
    to: usize,
    is_new: bool,
}

/// The last command of a text that sets the exponents of a primitive, or where one can be added: behind the line that
/// selects the primitive for the first time.
pub(crate) fn find(text: &str, session: &Session, name: &str) -> Option<Exponents> {
    let shape = session.scene().primitive(name).ok()?.shape.exponents();
    let mut running = Session::default();
    let mut found: Option<Exponents> = None;
    for (line, content) in lines_of(text).enumerate() {
        let was_selected = running.selected() == Some(name);
        drop(run_text(&mut running, content));
        let is_selected = running.selected() == Some(name);
        if !(is_selected || was_selected) {
            continue;
        }
        let of_line = |word: &str, from: usize, to: usize, is_new: bool| Exponents {
            name: name.to_owned(),
            e: shape.e(),
            n: shape.n(),
            word: word.to_owned(),
            line,
            from,
            to,
            is_new,
        };
        let sets = |command: &str| {
            let parsed = parse_line(command).ok().flatten();
            parsed.is_some_and(|parsed| {
                matches!(parsed.command, Command::Primitive(PrimitiveCommand::SetExponents { .. }))
            })
        };
        for (start, end, command) in commands(content) {
            if is_selected && sets(command) {
                let word = command.split_whitespace().next().unwrap_or("setExponent");
                found = Some(of_line(word, start, end, false));
            }
        }
        if found.is_none() && is_selected {
            found = Some(of_line("setExponent", 0, 0, true));
        }
    }
    found
}

/// The commands of a line with their columns in UTF-16 units, without comments.
fn commands(line: &str) -> Vec<(usize, usize, &str)> {
    let bare = line.split('#').next().unwrap_or_default();
    let columns = |(column, command): (usize, &'_ str)| {
        let indent = command.chars().take_while(|c| c.is_whitespace()).count();
        (units_of(bare, column + indent), units_of(bare, column + command.trim_end().chars().count()))
    };
    let parts = split_commands(bare).into_iter().filter(|(_, command)| !command.trim().is_empty());
    parts
        .map(|part| {
            let (start, end) = columns(part);
            (start, end, part.1.trim())
        })
        .collect()
}

/// A command that sets exponents, with numbers as a slider has them.
pub(crate) fn line(word: &str, e: f64, n: f64) -> String {
    let number = |x: f64| format_number((x * DECIMALS).round() / DECIMALS);
    format!("{word} {} {}", number(e), number(n))
}
