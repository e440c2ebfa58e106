//! Standard output and standard error, without panics.
//!
//! No name can control the terminal: all text goes through [`visible`], except pictures and JSON.
//! Errors have colours where the terminal, its environment and `--color` want them.

use std::fmt::Display;
use std::io::{self, Write};

use anstream::{AutoStream, ColorChoice};
use anyhow::{Context, Result};
use superegg_lang::visible;

const ERROR: &str = "\x1b[1;31m";
const WARNING: &str = "\x1b[1;33m";
const HELP: &str = "\x1b[1;36m";
const END: &str = "\x1b[0m";

/// Prints a line on standard output.
///
/// # Errors
/// Standard output cannot be written: the pipe is closed or the disk is full.
pub(crate) fn print(text: impl Display) -> Result<()> {
    print_raw(visible(&text.to_string()))
}

/// Prints a line on standard output with its control characters.
///
/// # Errors
/// As for [`print`].
pub(crate) fn print_raw(text: impl Display) -> Result<()> {
    writeln!(io::stdout().lock(), "{text}").context(CANNOT_PRINT)
}

/// Prints text with colours for a terminal on standard output, without a line break at its end.
///
/// # Errors
/// As for [`print`].
pub(crate) fn print_styled(text: impl Display) -> Result<()> {
    let mut output = anstream::stdout();
    write!(output, "{text}").and_then(|()| output.flush()).context(CANNOT_PRINT)
}

const CANNOT_PRINT: &str = "cannot write to standard output";

/// Prints a line on standard error. A failure is ignored: there is no other output to report it on.
pub(crate) fn warn(text: impl Display) {
    let _ = writeln!(anstream::stderr(), "{}", painted(&visible(&text.to_string())));
}

/// Prints the error that ends a command.
pub(crate) fn fail(error: impl Display) {
    let text = visible(&error.to_string());
    let _ = writeln!(anstream::stderr(), "{ERROR}superegg{END}: {text}");
}

/// Whether a line editor on standard output paints.
pub(crate) fn paints_output() -> bool {
    AutoStream::choice(&io::stdout()) != ColorChoice::Never
}

/// A message with its severity, its marks and its help in colours.
pub(crate) fn painted(message: &str) -> String {
    let severities = [("error[", ERROR), ("warning[", WARNING), ("warning: ", WARNING), ("error: ", ERROR)];
    let first = message.lines().next().unwrap_or_default();
    let found = severities.iter().filter_map(|(word, color)| Some((first.find(word)?, *word, *color))).min();
    let Some((start, word, color)) = found else { return message.to_owned() };
    let end = match word.strip_suffix('[') {
        Some(_) => first[start..].find(']').map_or(first.len(), |end| start + end + 1),
        None => start + word.len() - ": ".len(),
    };
    let mut text = format!("{}{color}{}{END}{}", &first[..start], &first[start..end], &first[end..]);
    for line in message.lines().skip(1) {
        text.push('\n');
        let marks = line.find('^').filter(|_| line.trim_start_matches([' ', '|', '^']).is_empty());
        match (marks, line.strip_prefix("    = help:")) {
            (Some(marks), _) => text.extend([&line[..marks], color, &line[marks..], END]),
            (None, Some(help)) => text.extend(["    = ", HELP, "help", END, ":", help]),
            (None, None) => text.push_str(line),
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_are_added_and_nothing_else() {
        for message in [
            "a.scn:1:2: error[out-of-range]: b must be 1\n    | color 2\n    |       ^\n    = help: say 1",
            "superegg: warning: nothing is selected",
            "p.csv:2:4: error: z 'x' is not a number",
            "a.png: 8x8, 1 instance",
            "warning[unused]: 'error[x]' is in no object",
            "",
        ] {
            let painted = painted(message);
            assert_eq!(anstream::adapter::strip_str(&painted).to_string(), message);
            assert_eq!(painted.contains('\x1b'), message.contains("error") || message.contains("warning"));
        }
        assert!(painted("warning[unused]: 'error[x]'").starts_with("\x1b[1;33mwarning[unused]\x1b[0m:"));
    }
}
