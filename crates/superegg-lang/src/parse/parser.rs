//! The parser: a line to a command.

use std::borrow::Cow;
use std::ops::Range;

use smallvec::SmallVec;

use crate::color::{color_names, is_hexadecimal};
use crate::diagnostic::{Fault, FaultCode};
use crate::grammar::command::{Command, ObjectCommand};
use crate::grammar::spec::{
    Arg, ArgKind, Args, Build, CommandSpec, NameKind, Range as NumberRange, Shorthand, not_keyable,
    parse_size, size_form,
};
use crate::grammar::table::{COMMANDS, SHARED_SPELLING, commands_spelt, find_command};
use crate::parse::number::{format_number, parse_number};
use crate::parse::words::{Quoting, Word, Words, split_plain, split_words};
use crate::suggest::Suggestions;
use crate::text::{one_of, shorten};

/// The columns of words. Most lines have few.
pub type Columns = SmallVec<[Range<usize>; 6]>;

/// A parsed line: the command, its row of the table, and the columns of its words.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Parsed {
    /// The command.
    pub command: Command,
    /// The row of the command table.
    pub spec: &'static CommandSpec,
    /// The columns of the command and of each positional argument, in characters from 0. Options
    /// and image sizes, which may stand anywhere, are not included.
    pub columns: Columns,
    /// The nested command, for a command that takes a line (`key`).
    pub keyed: Option<Box<Parsed>>,
}

impl Parsed {
    /// The columns of a word, 0 being the command; those of the command if there is no such word.
    pub(crate) fn word_columns(&self, word: usize) -> Range<usize> {
        self.columns.get(word).unwrap_or(&self.columns[0]).clone()
    }

    /// The columns of all arguments.
    pub(crate) fn argument_columns(&self) -> Range<usize> {
        let first = self.columns.get(1).unwrap_or(&self.columns[0]);
        first.start..self.columns[self.columns.len() - 1].end
    }
}

/// The words of a line. Quotes are special only if the command, or the one that it sets keys of, takes a file. A `#` begins a word
/// where the command takes a colour, and a comment elsewhere. The command `sky sun` is one word, `daylight`.
pub(crate) fn words_of_command(line: &str) -> Words<'_> {
    let mut words = split_command(line);
    // The commands are at the begin of the line, and after that of a key and its frame.
    for at in [0, 2] {
        let Some([sky, sun]) = words.get(at..at + 2) else { break };
        let is_command =
            || at == 0 || command_of(words[0].text, &words[1..]).is_some_and(CommandSpec::takes_line);
        if sky.text.eq_ignore_ascii_case("sky") && sun.text.eq_ignore_ascii_case("sun") && is_command() {
            words[at] = Word { text: "daylight", columns: sky.columns.start..sun.columns.end };
            words.remove(at + 1);
        }
    }
    words
}

fn split_command(line: &str) -> Words<'_> {
    if let Some(words) = split_plain(line) {
        return words;
    }
    let words = split_words(line, Quoting::Plain, &begins_color);
    let takes_file =
        || innermost(&words).is_some_and(|(spec, _)| spec.all_args().any(|arg| arg.kind == ArgKind::File));
    if line.contains('"') && takes_file() { split_words(line, Quoting::Quoted, &|_, _| false) } else { words }
}

/// The command of a line and the words after it; for a command that takes a line (`key`), those of that line.
fn innermost<'w, 't>(mut words: &'w [Word<'t>]) -> Option<(&'static CommandSpec, &'w [Word<'t>])> {
    loop {
        let (first, rest) = words.split_first()?;
        let spec = command_of(first.text, rest)?;
        match line_within(spec, rest) {
            Some(within) => words = within,
            None => return Some((spec, rest)),
        }
    }
}

/// Whether a `#` begins a colour, given the words before it and the text after it.
///
/// Where the command needs a colour any word is one, or the fault would be a missing argument.
/// Where a colour is optional, a comment may begin instead: only three or six hexadecimal digits
/// are a colour, followed by nothing, a number, an axis or another `#`.
fn begins_color(words: &[Word<'_>], after: &str) -> bool {
    let Some((spec, rest)) = innermost(words) else { return false };
    let position = spec.position_after(rest.iter().map(|word| word.text));
    let is_color =
        |arg: &Arg| arg.shorthand == Some(Shorthand::Color) && matches!(arg.kind, ArgKind::Number(_));
    if !spec.positional_args().nth(position).is_some_and(is_color) {
        return false;
    }
    let ends = |c: char| c.is_whitespace() || c == '#';
    let digits = after.split(ends).next().unwrap_or_default();
    if !spec.counts().any(|count| count == position) {
        return !digits.is_empty();
    }
    let next = after[digits.len()..].trim_start();
    let is_followed = next.is_empty()
        || next.starts_with('#')
        || next
            .split(ends)
            .next()
            .is_some_and(|word| parse_number(word).is_ok() || Shorthand::Axis.numbers_of(word).is_some());
    is_hexadecimal(digits) && is_followed
}

/// Parses one line. Returns `None` for a line without a command: blank, or a comment.
///
/// # Errors
/// An unknown command, a wrong number of arguments, or an argument outside its range.
///
/// ```
/// use superegg_lang::{Command, PrimitiveCommand, parse_line};
///
/// let parsed = parse_line("index 1.33  # water").unwrap().unwrap();
/// assert_eq!(parsed.command, Command::Primitive(PrimitiveCommand::SetIndex(1.33)));
/// assert_eq!(parsed.spec.name, "setIndex");
/// assert_eq!(parse_line("transalte 1 2 3").unwrap_err().help.as_deref(), Some("did you mean 'translate'?"));
/// assert!(parse_line("# a comment").unwrap().is_none());
/// ```
pub fn parse_line(line: &str) -> Result<Option<Parsed>, Fault> {
    parse_suggesting(line, Suggestions::Given)
}

/// As [`parse_line`].
pub(crate) fn parse_suggesting(line: &str, suggestions: Suggestions) -> Result<Option<Parsed>, Fault> {
    check_text(line)?;
    let words = words_of_command(line);
    words.split_first().map(|(first, rest)| parse_words(first, rest, suggestions)).transpose()
}

/// Checks that a line has no zero byte: files with one are not read, so a scene with such a name could not be loaded again.
pub(crate) fn check_text(line: &str) -> Result<(), Fault> {
    let Some(at) = memchr::memchr(0, line.as_bytes()) else { return Ok(()) };
    let column = line[..at].chars().count();
    let fault = Fault::new(FaultCode::NotText, "a zero byte, which no text has");
    Err(fault.help("remove it").at(column..column + 1))
}

/// The words of the nested command, if the command takes one and it has begun.
pub(crate) fn line_within<'w, 'a>(spec: &CommandSpec, rest: &'w [Word<'a>]) -> Option<&'w [Word<'a>]> {
    rest.get(1..).filter(|_| spec.takes_line())
}

/// The command of a spelling with its arguments. `ao` with exactly two numbers is ambientOcclusion;
/// with other arguments it is addObject, its older meaning.
pub(crate) fn command_of(first: &str, rest: &[Word<'_>]) -> Option<&'static CommandSpec> {
    let is_number = |word: &Word<'_>| parse_number(word.text).is_ok();
    let is_second =
        first.eq_ignore_ascii_case(SHARED_SPELLING) && rest.len() == 2 && rest.iter().all(is_number);
    commands_spelt(first).nth(usize::from(is_second))
}

/// The command of the words of a line.
pub(crate) fn parse_words<'a>(
    first: &Word<'a>,
    rest: &[Word<'a>],
    suggestions: Suggestions,
) -> Result<Parsed, Fault> {
    let spec = command_of(first.text, rest).ok_or_else(|| unknown_command(first, suggestions))?;
    if let Some(args) = read_plain(spec, first, rest) {
        let columns = std::iter::once(first).chain(rest).map(|word| word.columns.clone()).collect();
        return Ok(Parsed { command: spec.build.command(&args), spec, columns, keyed: None });
    }
    let mut args = Args::none(first.text);
    let keyed = match line_within(spec, rest).and_then(<[_]>::split_first) {
        Some((first, rest)) => Some(Box::new(parse_keyed(first, rest, suggestions)?)),
        None => None,
    };
    let words_within = line_within(spec, rest).and_then(<[_]>::split_first);
    let rest = fill(spec, split_positional(spec, rest, &mut args, suggestions)?.into_iter());
    check_count(spec, first, &rest, suggestions)?;
    let last_repeated = spec.all_args().last().filter(|_| spec.is_variadic());
    let positional = spec.positional_args().chain(last_repeated.into_iter().cycle());
    for (Filled { word, number }, arg) in rest.iter().zip(positional) {
        match arg.kind {
            // A nested line is read below.
            ArgKind::Line => {}
            ArgKind::Number(range) => args.numbers.push(match number {
                Some(number) => *number,
                None => read_number(spec, arg, range, word, suggestions)
                    .map_err(|fault| with_color_help(fault, spec, &rest))?,
            }),
            ArgKind::Choice(choices) => {
                check_choice(spec, choices, word, suggestions)?;
                args.words.push(word.text.into());
            }
            ArgKind::File if word.text.is_empty() => {
                let fault = Fault::new(FaultCode::NoFile, "the name of the file is empty");
                return Err(fault.help(usage_help(spec)).at(word.columns.clone()));
            }
            ArgKind::Name(_) | ArgKind::File | ArgKind::Value | ArgKind::Words(_) | ArgKind::Size => {
                args.words.push(word.text.into());
            }
        }
    }
    if let (Some(keyed), Some((_, within))) = (&keyed, words_within) {
        args.words.extend(fill(keyed.spec, within.iter()).iter().map(Filled::text));
    }
    let command = spec.build.command(&args);
    let columns = std::iter::once(first)
        .chain(rest.iter().map(|filled| filled.word))
        .map(|word| word.columns.clone())
        .collect();
    Ok(Parsed { command, spec, columns, keyed })
}

/// The command of the words of a valid line about the selected object, if its arguments are numbers
/// and names alone. `None` for any other line, valid or not.
pub(crate) fn plain_object_command<'a>(first: &Word<'a>, rest: &[Word<'a>]) -> Option<ObjectCommand> {
    let spec = command_of(first.text, rest)?;
    let Build::Object(build) = spec.build else { return None };
    Some(build(&read_plain(spec, first, rest)?))
}

/// The arguments of a valid line of a command that takes numbers and names alone, as nearly all
/// lines of large scenes are. `None` for any other line, valid or not: it is read with all rules.
#[inline]
fn read_plain<'a>(spec: &CommandSpec, first: &Word<'a>, rest: &[Word<'a>]) -> Option<Args<'a>> {
    if !spec.options.is_empty() {
        return None;
    }
    let mut args = Args::none(first.text);
    let mut words = rest.iter();
    for (index, part) in spec.args.iter().enumerate() {
        if index > 0 && words.len() == 0 {
            break;
        }
        for arg in *part {
            let word = words.next()?;
            match arg.kind {
                // A word for three numbers is no number, and read with all rules.
                ArgKind::Number(range) => {
                    args.numbers.push(parse_number(word.text).ok().filter(|x| range.contains(*x))?);
                }
                ArgKind::Name(_) => args.words.push(Cow::Borrowed(word.text)),
                _ => return None,
            }
        }
    }
    (words.len() == 0).then_some(args)
}

/// A word at one position. A word that stands for three numbers fills three positions.
#[derive(Clone, Copy, Debug)]
struct Filled<'w, 'a> {
    word: &'w Word<'a>,
    /// The number of a shorthand at this position.
    number: Option<f64>,
}

impl<'a> Filled<'_, 'a> {
    fn text(&self) -> Cow<'a, str> {
        match self.number {
            Some(number) => Cow::Owned(format_number(number)),
            None => Cow::Borrowed(self.word.text),
        }
    }
}

/// The positional words of a line, by position.
type Positions<'w, 'a> = SmallVec<[Filled<'w, 'a>; 12]>;

/// The positional words, one for each position.
fn fill<'w, 'a>(spec: &CommandSpec, words: impl Iterator<Item = &'w Word<'a>>) -> Positions<'w, 'a>
where
    'a: 'w,
{
    let mut filled = Positions::new();
    for word in words {
        match spec.shorthand_at(filled.len(), word.text) {
            Some(numbers) => {
                filled.extend(numbers.to_array().map(|number| Filled { word, number: Some(number) }));
            }
            None => filled.push(Filled { word, number: None }),
        }
    }
    filled
}

/// Parses a nested line; its command must be keyable.
fn parse_keyed<'a>(first: &Word<'a>, rest: &[Word<'a>], suggestions: Suggestions) -> Result<Parsed, Fault> {
    match command_of(first.text, rest) {
        Some(spec) if !spec.is_keyable() => Err(not_keyable(spec).at(first.columns.clone())),
        _ => parse_words(first, rest, suggestions),
    }
}

/// Separates options and the image size from the positional arguments, which it returns.
fn split_positional<'w, 'a>(
    spec: &CommandSpec,
    rest: &'w [Word<'a>],
    args: &mut Args<'a>,
    suggestions: Suggestions,
) -> Result<SmallVec<[&'w Word<'a>; 12]>, Fault> {
    let takes_size = spec.all_args().any(|arg| matches!(arg.kind, ArgKind::Size));
    let mut positional = SmallVec::new();
    for word in rest {
        let option = spec.options.iter().copied().find(|option| option.eq_ignore_ascii_case(word.text));
        if let Some(option) = option {
            args.options.push(option);
        } else if takes_size && args.size.is_none() && size_form(word.text).is_some() {
            let size = parse_size(word.text).map_err(|message| {
                Fault::new(FaultCode::OutOfRange, message).help(usage_help(spec)).at(word.columns.clone())
            })?;
            args.size = Some(size);
        } else if !spec.options.is_empty() && word.text.starts_with("--") {
            let message = format!("{} has no option '{}'", spec.name, shorten(word.text));
            let help = suggestions.did_you_mean(word.text, spec.options.iter().copied(), &usage_help(spec));
            return Err(Fault::new(FaultCode::UnknownOption, message).help(help).at(word.columns.clone()));
        } else {
            positional.push(word);
        }
    }
    Ok(positional)
}

fn check_choice(
    spec: &CommandSpec,
    choices: &[&str],
    word: &Word<'_>,
    suggestions: Suggestions,
) -> Result<(), Fault> {
    if choices.iter().any(|choice| choice.eq_ignore_ascii_case(word.text)) {
        return Ok(());
    }
    let message = format!("{} does not know '{}'", spec.name, shorten(word.text));
    let help = suggestions.did_you_mean(word.text, choices.iter().copied(), &usage_help(spec));
    Err(Fault::new(FaultCode::UnknownWord, message).help(help).at(word.columns.clone()))
}

fn unknown_command(word: &Word<'_>, suggestions: Suggestions) -> Fault {
    let spellings = COMMANDS.iter().flat_map(CommandSpec::all_spellings);
    let help = suggestions.did_you_mean(word.text, spellings, "'help' lists the commands");
    Fault::new(FaultCode::UnknownCommand, format!("there is no command '{}'", shorten(word.text)))
        .help(help)
        .at(word.columns.clone())
}

/// The fault of a word that should be a shorthand: a single word that is no number, where three
/// numbers begin.
fn wrong_shorthand(spec: &CommandSpec, rest: &[Filled<'_, '_>], suggestions: Suggestions) -> Option<Fault> {
    let (word, shorthand) = rest.iter().zip(spec.positional_args()).find_map(|(filled, arg)| {
        let is_wrong = filled.number.is_none() && parse_number(filled.word.text).is_err();
        Some((filled.word, arg.shorthand.filter(|_| is_wrong)?))
    })?;
    Some(no_shorthand(shorthand, word, suggestions))
}

fn no_shorthand(shorthand: Shorthand, word: &Word<'_>, suggestions: Suggestions) -> Fault {
    let (what, mut help) = match shorthand {
        Shorthand::Color => {
            let help = "give three linear numbers, #rrggbb, #rgb, or a CSS name such as orange";
            ("a colour", suggestions.did_you_mean(word.text, color_names(), help))
        }
        Shorthand::Axis => ("a direction", "give x, y or z, or three numbers".to_owned()),
    };
    if joins_numbers(word.text) {
        help = "separate numbers by blanks, not by commas".to_owned();
    }
    Fault::new(FaultCode::NotANumber, format!("'{}' is not {what}", shorten(word.text)))
        .help(help)
        .at(word.columns.clone())
}

fn check_count(
    spec: &CommandSpec,
    first: &Word<'_>,
    rest: &[Filled<'_, '_>],
    suggestions: Suggestions,
) -> Result<(), Fault> {
    let given = rest.len();
    let most = spec.counts().last().unwrap_or(0);
    let is_one = spec.counts().any(|count| count == given) || (spec.args.is_empty() && given == 0);
    if is_one || (spec.is_variadic() && (!spec.takes_line() || given >= most)) {
        return Ok(());
    }
    if spec.takes_line() {
        let fault =
            Fault::new(FaultCode::ArgumentCount, format!("{} takes a frame and a command", spec.name));
        let end = rest.last().map_or(first.columns.end, |filled| filled.word.columns.end);
        return Err(fault.help(usage_help(spec)).at(first.columns.start..end));
    }
    if let Some(fault) = wrong_shorthand(spec, rest, suggestions) {
        return Err(fault);
    }
    let mut wanted: Vec<String> = spec.counts().map(|count| count.to_string()).collect();
    wanted.dedup();
    if wanted.is_empty() {
        wanted.push("no".into());
    }
    let plural = if wanted == ["1"] { "" } else { "s" };
    if let Some(Filled { word, .. }) =
        rest.get(most).filter(|_| spec.all_args().any(|arg| arg.kind == ArgKind::Size))
    {
        let message = format!("'{}' is not the size of a picture, such as 640x480", shorten(word.text));
        return Err(Fault::new(FaultCode::ArgumentCount, message)
            .help(usage_help(spec))
            .at(word.columns.clone()));
    }
    let message = format!("{} takes {} argument{plural}, not {given}", spec.name, one_of(&wanted));
    let columns = if given > most {
        rest[most].word.columns.start..rest[given - 1].word.columns.end
    } else {
        first.columns.start..rest.last().map_or(first.columns.end, |filled| filled.word.columns.end)
    };
    let help =
        slip_help(spec, rest).unwrap_or_else(|| match rest.iter().find(|filled| filled.number.is_some()) {
            Some(Filled { word, .. }) => {
                let alone = format!("'{}' alone stands for three numbers", shorten(word.text));
                let next = spec.counts().find(|count| *count > given).unwrap_or(given);
                let missing: Vec<&str> =
                    spec.positional_args().take(next).skip(given).map(|arg| arg.name).collect();
                if missing.is_empty() { alone } else { format!("{alone}; missing: {}", missing.join(" ")) }
            }
            None => usage_help(spec),
        });
    Err(Fault::new(FaultCode::ArgumentCount, message).help(help).at(columns))
}

fn read_number(
    spec: &CommandSpec,
    arg: &Arg,
    range: NumberRange,
    word: &Word<'_>,
    suggestions: Suggestions,
) -> Result<f64, Fault> {
    let is_color_word = |word: &str| word.starts_with('#');
    if let Some(shorthand) = arg.shorthand.filter(|_| is_color_word(word.text)) {
        return Err(no_shorthand(shorthand, word, suggestions));
    }
    let arg = arg.name;
    let number = parse_number(word.text).map_err(|error| {
        let help = if joins_numbers(word.text) {
            no_commas_help(spec)
        } else {
            format!("{arg} of {} must be {}; for example: {}", spec.name, range.describe(), spec.example)
        };
        Fault::new(FaultCode::NotANumber, format!("'{}' {error}", shorten(word.text)))
            .help(help)
            .at(word.columns.clone())
    })?;
    if range.contains(number) {
        return Ok(number);
    }
    let message = format!("{arg} of {} must be {}, not {}", spec.name, range.describe(), shorten(word.text));
    let help = if spec.name == "setCoeff" && number == 0.0 {
        "a semi-axis of 0 encloses nothing; for a thin disc or rod give a small one, such as 0.001".to_owned()
    } else {
        usage_help(spec)
    };
    Err(Fault::new(FaultCode::OutOfRange, message).help(help).at(word.columns.clone()))
}

/// A colour with no value as large as this is more likely a slip than one of bytes.
const LEAST_BYTE: u8 = 16;

/// Names the word for a colour whose values are out of range because they are those of a byte.
fn with_color_help(fault: Fault, spec: &CommandSpec, rest: &[Filled<'_, '_>]) -> Fault {
    if fault.code != FaultCode::OutOfRange {
        return fault;
    }
    let of_color = |arg: &Arg| arg.shorthand == Some(Shorthand::Color);
    let Some(first) = spec.positional_args().position(of_color) else { return fault };
    let numbers = rest.get(first..first + 3).unwrap_or_default();
    let bytes: Option<Vec<u8>> = numbers.iter().map(|filled| filled.word.text.parse().ok()).collect();
    match bytes.as_deref() {
        Some(&[r, g, b])
            if r.max(g).max(b) >= LEAST_BYTE
                && fault.columns.as_ref().is_some_and(|at| is_within(at, numbers)) =>
        {
            let name = spec.name;
            fault.help(format!(
                "values are 0 to 1; {r} {g} {b} looks like 8-bit values, which are one word: {name} #{r:02x}{g:02x}{b:02x}"
            ))
        }
        _ => fault,
    }
}

/// Whether columns are those of one of these words.
fn is_within(columns: &Range<usize>, words: &[Filled<'_, '_>]) -> bool {
    words.iter().any(|filled| filled.word.columns == *columns)
}

/// Whether a word is numbers with commas, such as `1,2,3` or `1,`.
fn joins_numbers(word: &str) -> bool {
    let mut parts = word.split(',').filter(|part| !part.is_empty()).peekable();
    word.contains(',') && parts.peek().is_some() && parts.all(|part| parse_number(part).is_ok())
}

fn has_commas(rest: &[Filled<'_, '_>]) -> bool {
    rest.iter().any(|filled| joins_numbers(filled.word.text))
}

fn no_commas_help(spec: &CommandSpec) -> String {
    format!("separate numbers by blanks, not by commas; for example: {}", spec.example)
}

/// The help for a wrong number of arguments that has a likely cause: commas, quotes, or a command that is written as a setting.
fn slip_help(spec: &CommandSpec, rest: &[Filled<'_, '_>]) -> Option<String> {
    let has_setting = spec.positional_args().next()?.kind == ArgKind::Name(NameKind::Setting);
    if has_commas(rest) {
        Some(no_commas_help(spec))
    } else if rest.iter().any(|filled| filled.word.text.starts_with('"')) {
        Some(format!("a name is one word without quotes, such as my_ball; for example: {}", spec.example))
    } else {
        rest.first().filter(|_| has_setting).and_then(|filled| help_for_setting(filled.word.text))
    }
}

/// The help where a command is written as a setting: `set depth 4` for `setDepth 4`, `set background white` for
/// `background white`.
pub(crate) fn help_for_setting(name: &str) -> Option<String> {
    let spec = find_command(&format!("set{name}")).or_else(|| find_command(name))?;
    Some(format!("did you mean the command '{}'? {}", spec.name, usage_help(spec)))
}

pub(crate) fn usage_help(spec: &CommandSpec) -> String {
    format!("{}, for example: {}", format!("{} {}", spec.name, spec.usage()).trim_end(), spec.example)
}

#[cfg(test)]
mod tests {
    use superegg_geom::glam::DVec3;

    use super::*;
    use crate::grammar::command::{PrimitiveCommand, SessionCommand};

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
        let expected = Command::Primitive(PrimitiveCommand::SetRadii(DVec3::new(1.0, 0.5, 2.0)));
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
        assert_eq!(
            command("obj 2nd_robot_base"),
            Command::Session(SessionCommand::SelectObject("2nd_robot_base".into()))
        );
        assert_eq!(
            command("prm größe/ü"),
            Command::Session(SessionCommand::SelectPrimitive("größe/ü".into()))
        );
        // Columns are counted in characters.
        for (line, columns) in [("delete größe größe", 13..18), ("delete grosse größe # ü", 14..19)] {
            assert_eq!(fault(line).columns, Some(columns), "{line}");
        }
    }

    #[test]
    fn faults_say_where_what_and_what_would_be_right() {
        let slip = fault("  transalte 1 2 3");
        assert_eq!((slip.code.as_str(), slip.columns.clone()), ("unknown-command", Some(2..11)));
        assert_eq!(slip.help.as_deref(), Some("did you mean 'translate'?"));

        let few = fault("coeff 1 2");
        assert_eq!(
            (few.code.as_str(), few.message.as_str()),
            ("argument-count", "setCoeff takes 3 arguments, not 2")
        );

        let many = fault("ambient 0.1 0.2 0.3");
        assert_eq!(
            (many.message.as_str(), many.columns),
            ("setAmbient takes 1 argument, not 3", Some(12..19))
        );

        for (line, help) in [
            ("setCoeff 1,2,3", "separate numbers by blanks, not by commas; for example: setCoeff 2 1 0.5"),
            ("setCoeff 1, 2, 3", "separate numbers by blanks, not by commas; for example: setCoeff 2 1 0.5"),
            ("setColor 1,0,0", "separate numbers by blanks, not by commas"),
            (
                "primitive \"my ball\"",
                "a name is one word without quotes, such as my_ball; for example: primitive ball",
            ),
            ("rotate 0,0,1 30", "separate numbers by blanks, not by commas"),
            ("setCoeff , 2 3", "x of setCoeff must be above 0; for example: setCoeff 2 1 0.5"),
            (
                "set lens 0.2 9",
                "did you mean the command 'lens'? lens radius [focus], for example: lens 0.2 9",
            ),
        ] {
            assert_eq!(fault(line).help.as_deref(), Some(help), "{line}");
        }

        let word = fault("xs 1 two 3");
        assert_eq!((word.code.as_str(), word.columns), ("not-a-number", Some(5..8)));

        let range = fault("color 0 0 1.5");
        assert_eq!((range.code.as_str(), range.columns), ("out-of-range", Some(10..13)));
        assert_eq!(range.message, "b of setColor must be from 0 to 1, not 1.5");
    }

    #[test]
    fn ranges_hold_at_their_ends() {
        for good in [
            "color 0 0 1",
            "exp 1e-4 8",
            "exp 0 -0",
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
            "exp -1 1",
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

    #[test]
    fn the_shared_spelling_means_one_thing_for_each_line() {
        for (line, name) in [
            ("ao 16 2", "ambientOcclusion"),
            ("AO 0 1.", "ambientOcclusion"),
            ("ao arm", "addObject"),
            ("ao arm 2", "addObject"),
            ("ao 2nd 3", "addObject"),
            ("ao 2", "addObject"),
            ("addObject 1 2", "addObject"),
        ] {
            assert_eq!(parse_line(line).unwrap().unwrap().spec.name, name, "{line}");
        }
        // Faults of the numbers are those of ambientOcclusion.
        assert_eq!(parse_line("ao 1.5 2").unwrap_err().code.as_str(), "out-of-range");
    }

    #[test]
    fn every_row_is_complete_and_its_example_parses_to_itself() {
        for spec in COMMANDS {
            assert!(!spec.summary.is_empty() && !spec.summary.ends_with('.'), "{}", spec.name);
            let parsed = parse_line(spec.example).unwrap().unwrap();
            assert_eq!(parsed.spec.name, spec.name, "{}", spec.example);
            for spelling in spec.all_spellings() {
                assert!(commands_spelt(&spelling.to_uppercase()).any(|found| found.name == spec.name));
            }
        }
    }
}
