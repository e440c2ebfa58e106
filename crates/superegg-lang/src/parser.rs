//! One line of text to one command.

use std::ops::Range;

use crate::command::Command;
use crate::diagnostic::Fault;
use crate::number::parse_number;
use crate::suggest::nearest;
use crate::table::{ArgKind, Args, COMMANDS, CommandSpec, Range as NumberRange, find_command};

/// A parsed line: the command, its row of the table, and where its words stand.
#[derive(Clone, Debug)]
pub struct Parsed {
    /// The command.
    pub command: Command,
    /// Its row of the table.
    pub spec: &'static CommandSpec,
    /// The characters of each word, the command's own first, counted from 0.
    pub columns: Vec<Range<usize>>,
}

struct Word<'a> {
    text: &'a str,
    columns: Range<usize>,
}

/// The words of a line up to a `#`, which starts a comment anywhere.
fn split_words(line: &str) -> Vec<Word<'_>> {
    let line = line.split('#').next().unwrap_or_default();
    let mut words = Vec::new();
    let mut start: Option<(usize, usize)> = None;
    let end = std::iter::once((line.len(), ' '));
    for (column, (byte, c)) in line.char_indices().chain(end).enumerate() {
        match (c.is_whitespace(), start) {
            (false, None) => start = Some((byte, column)),
            (true, Some((first_byte, first_column))) => {
                words.push(Word { text: &line[first_byte..byte], columns: first_column..column });
                start = None;
            }
            _ => {}
        }
    }
    words
}

/// Reads one line. `None` is a line without a command: blank, or a comment.
///
/// # Errors
/// An unknown command, a wrong number of arguments, or an argument out of its range.
pub fn parse_line(line: &str) -> Result<Option<Parsed>, Fault> {
    let words = split_words(line);
    let Some((first, rest)) = words.split_first() else {
        return Ok(None);
    };
    let spec = find_command(first.text).ok_or_else(|| unknown_command(first))?;
    check_count(spec, first, rest)?;
    let mut args = Args { words: Vec::new(), numbers: Vec::new() };
    let last_repeated = spec.all_args().last().filter(|_| spec.is_variadic());
    for (word, arg) in rest.iter().zip(spec.all_args().chain(last_repeated.into_iter().cycle())) {
        match arg.kind {
            ArgKind::Number(range) => args.numbers.push(read_number(spec, arg.name, range, word)?),
            ArgKind::Name | ArgKind::File | ArgKind::Words => args.words.push(word.text),
        }
    }
    let command = (spec.build)(&args);
    Ok(Some(Parsed { command, spec, columns: words.into_iter().map(|word| word.columns).collect() }))
}

fn unknown_command(word: &Word<'_>) -> Fault {
    let spellings = COMMANDS.iter().flat_map(CommandSpec::all_spellings);
    let help = match nearest(word.text, spellings) {
        Some(near) => format!("did you mean '{near}'?"),
        None => "'help' lists the commands".to_owned(),
    };
    Fault::new("unknown-command", format!("there is no command '{}'", shorten(word.text)))
        .help(help)
        .at(word.columns.clone())
}

fn check_count(spec: &CommandSpec, first: &Word<'_>, rest: &[Word<'_>]) -> Result<(), Fault> {
    let counts = spec.counts();
    let given = rest.len();
    let most = counts.last().copied().unwrap_or(0);
    if counts.contains(&given) || (counts.is_empty() && given == 0) || spec.is_variadic() {
        return Ok(());
    }
    let wanted: Vec<String> =
        if counts.is_empty() { vec!["no".into()] } else { counts.iter().map(ToString::to_string).collect() };
    let plural = if wanted == ["1"] { "" } else { "s" };
    let message = format!("{} takes {} argument{plural}, not {given}", spec.name, one_of(&wanted));
    let columns = if given > most {
        rest[most].columns.start..rest[given - 1].columns.end
    } else {
        first.columns.start..rest.last().unwrap_or(first).columns.end
    };
    Err(Fault::new("argument-count", message).help(usage_help(spec)).at(columns))
}

fn read_number(spec: &CommandSpec, arg: &str, range: NumberRange, word: &Word<'_>) -> Result<f64, Fault> {
    let number = parse_number(word.text).map_err(|error| {
        Fault::new("not-a-number", format!("'{}' {error}", shorten(word.text)))
            .help(format!("{arg} of {} must be {}, such as 2, .5 or 1e-3", spec.name, range.describe()))
            .at(word.columns.clone())
    })?;
    if range.contains(number) {
        return Ok(number);
    }
    let message = format!("{arg} of {} must be {}, not {}", spec.name, range.describe(), shorten(word.text));
    Err(Fault::new("out-of-range", message).help(usage_help(spec)).at(word.columns.clone()))
}

/// "4, 7 or 8".
fn one_of(words: &[String]) -> String {
    match words {
        [] => String::new(),
        [word] => word.clone(),
        [first @ .., last] => format!("{} or {last}", first.join(", ")),
    }
}

fn usage_help(spec: &CommandSpec) -> String {
    format!("{}, for example: {}", format!("{} {}", spec.name, spec.usage()).trim_end(), spec.example)
}

/// A word for a message: its first characters, with control characters made visible.
pub(crate) fn shorten(word: &str) -> String {
    const LONGEST: usize = 40;
    let mut shown: String = word.chars().take(LONGEST).flat_map(visible).collect();
    if word.chars().nth(LONGEST).is_some() {
        shown.push_str("...");
    }
    shown
}

fn visible(c: char) -> impl Iterator<Item = char> {
    let escaped = c.is_control().then(|| c.escape_default());
    let plain = (!c.is_control()).then_some(c);
    escaped.into_iter().flatten().chain(plain)
}

#[cfg(test)]
mod tests {
    use superegg_geom::glam::DVec3;

    use super::*;

    fn command(line: &str) -> Command {
        parse_line(line).unwrap().unwrap().command
    }

    fn fault(line: &str) -> Fault {
        parse_line(line).unwrap_err()
    }

    #[test]
    fn blanks_tabs_carriage_returns_and_comments_are_nothing() {
        for line in ["", "   ", "\t", "\r", "# a comment", "   # another", "\t#"] {
            assert!(parse_line(line).unwrap().is_none(), "{line:?}");
        }
        let expected = Command::SetRadii(DVec3::new(1.0, 0.5, 2.0));
        for line in [
            "coeff 1. .5 2",
            "\tCOEFF\t1  .5 2   \r",
            "setcoeff 1 .5 2# glued",
            "  setCoeff 1e0 5E-1 +2 # said",
        ] {
            assert_eq!(command(line), expected, "{line:?}");
        }
    }

    #[test]
    fn names_are_any_word() {
        assert_eq!(command("obj 2nd_robot_base"), Command::Object("2nd_robot_base".into()));
        assert_eq!(command("prm größe/ü"), Command::Primitive("größe/ü".into()));
    }

    #[test]
    fn faults_say_where_what_and_what_would_be_right() {
        let slip = fault("  transalte 1 2 3");
        assert_eq!((slip.code, slip.columns.clone()), ("unknown-command", Some(2..11)));
        assert_eq!(slip.help.as_deref(), Some("did you mean 'translate'?"));

        let few = fault("coeff 1 2");
        assert_eq!((few.code, few.message.as_str()), ("argument-count", "setCoeff takes 3 arguments, not 2"));

        let many = fault("ambient 0.1 0.2 0.3");
        assert_eq!(
            (many.message.as_str(), many.columns),
            ("setAmbient takes 1 argument, not 3", Some(12..19))
        );

        let word = fault("xs 1 two 3");
        assert_eq!((word.code, word.columns), ("not-a-number", Some(5..8)));

        let range = fault("color 0 0 1.5");
        assert_eq!((range.code, range.columns), ("out-of-range", Some(10..13)));
        assert_eq!(range.message, "b of setColor must be from 0 to 1, not 1.5");
    }

    #[test]
    fn ranges_hold_at_their_ends() {
        for good in [
            "color 0 0 1",
            "exp 1e-4 8",
            "index 1",
            "index 4",
            "depth 0",
            "depth 64",
            "patch 1 10.",
            "scale -1 2 .5",
        ] {
            assert!(parse_line(good).is_ok(), "{good}");
        }
        for bad in [
            "coeff 1 0 1",
            "exp -0 1",
            "index 0.99",
            "depth 65",
            "depth 2.5",
            "patch 0 4",
            "scale 1 0 1",
            "camera 0 0 1 0 0 0 180",
            "coeff 1e-999 1 1",
            "light l 0 0 0 1 1 -1",
            "light l 0 0 0 1",
            "light l 0 0 0 1 1 1 1 1",
            "xs inf 0 0",
            "xs nan 0 0",
        ] {
            assert!(parse_line(bad).is_err(), "{bad}");
        }
    }
}
