//! Completion of the word at the cursor.

use crate::assist::names::{names_of, next_arg};
use crate::color::color_names;
use crate::grammar::spec::{Arg, ArgKind, CommandSpec, Shorthand};
use crate::grammar::table::COMMANDS;
use crate::parse::parser::command_of;
use crate::parse::parser::{line_within, words_of_command};
use crate::parse::words::Word;
use crate::session::interpreter::Session;
use crate::session::settings::{SETTINGS, SettingKind, find_setting};

/// The completions at a cursor.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Completion {
    /// The start of the word to replace, in bytes.
    pub start: usize,
    /// The replacements.
    pub candidates: Vec<String>,
    /// The start of a file name, if the argument is a file: the caller completes it.
    pub file: Option<String>,
}

/// Completes the word that ends at byte `at` of a line: a command, a name, an option, a setting, a
/// value. Case is ignored.
///
/// ```
/// use superegg_lang::{Session, complete};
///
/// let completion = complete(&Session::default(), "setCo", 5);
/// assert_eq!((completion.start, completion.candidates), (0, vec!["setCoeff".into(), "setColor".into()]));
/// ```
pub fn complete(session: &Session, line: &str, at: usize) -> Completion {
    let line = line.get(..at).unwrap_or(line);
    let words = words_of_command(line);
    let nothing = Completion { start: line.len(), candidates: Vec::new(), file: None };
    let is_at_word = words.last().is_some_and(|word| word.columns.end == line.chars().count());
    if !is_at_word && line.contains('#') {
        return nothing;
    }
    // The words before the cursor, and the partial word at it.
    let (before, partial) = match words.split_last() {
        // The word 'sky sun' is complete.
        Some((last, _)) if is_at_word && !line.ends_with(last.text) => return nothing,
        Some((last, before)) if is_at_word => (before, last.text),
        _ => (&words[..], ""),
    };
    let quote = usize::from(
        is_at_word
            && words
                .last()
                .is_some_and(|word| line_at(line, word.columns.start) == '"' && !word.text.starts_with('"')),
    );
    let start = line.len() - partial.len() - quote;
    let (mut before, mut fits): (&[Word<'_>], fn(&CommandSpec) -> bool) = (before, |_| true);
    let (spec, before) = loop {
        let Some((command, rest)) = before.split_first() else {
            return Completion { start, candidates: commands(partial, fits), file: None };
        };
        let Some(spec) = command_of(command.text, rest) else {
            // A line may begin with the name of a setting.
            let candidates = if rest.is_empty() { values(command.text, partial) } else { Vec::new() };
            return Completion { start, candidates, file: None };
        };
        let Some(within) = line_within(spec, rest) else { break (spec, rest) };
        (before, fits) = (within, CommandSpec::is_keyable);
    };
    let mut candidates = Vec::new();
    let mut file = None;
    if partial.starts_with('-') {
        candidates = fitting(spec.options.iter().copied(), partial);
    }
    match next_arg(spec, before).map(|arg| arg.kind) {
        Some(ArgKind::Name(of) | ArgKind::Words(of)) => {
            candidates.extend(fitting(names_of(session, of).into_iter(), partial));
        }
        Some(ArgKind::Choice(choices)) => candidates.extend(fitting(choices.iter().copied(), partial)),
        Some(ArgKind::Value) => {
            candidates.extend(values(before.last().map_or("", |word| word.text), partial));
        }
        Some(ArgKind::Number(_)) => candidates.extend(shorthands(next_arg(spec, before), partial)),
        Some(ArgKind::File) => file = Some(partial.to_owned()),
        Some(ArgKind::Size | ArgKind::Line) | None => {}
    }
    Completion { start, candidates, file }
}

fn line_at(line: &str, column: usize) -> char {
    line.chars().nth(column).unwrap_or(' ')
}

/// Command names with this prefix; other spellings only if there is none.
fn commands(partial: &str, fits: fn(&CommandSpec) -> bool) -> Vec<String> {
    let known = || COMMANDS.iter().filter(|spec| fits(spec));
    let names = fitting(known().map(|spec| spec.name), partial);
    let spellings = || {
        let mut found = fitting(known().flat_map(CommandSpec::all_spellings), partial);
        // Two commands may share a spelling.
        found.sort();
        found.dedup();
        found
    };
    let or = |found: Vec<String>, others: &dyn Fn() -> Vec<String>| {
        if found.is_empty() { others() } else { found }
    };
    // A line may begin with the name of a setting.
    let settings = || fitting(SETTINGS.iter().map(|setting| setting.name), partial);
    or(or(names, &spellings), &settings)
}

/// The allowed values of a setting, if they can be listed.
fn values(setting: &str, partial: &str) -> Vec<String> {
    match find_setting(setting).map(|spec| spec.kind) {
        Some(SettingKind::Switch) => fitting(["on", "off"].into_iter(), partial),
        Some(SettingKind::Choice(choices)) => fitting(choices.iter().copied(), partial),
        Some(SettingKind::Size) => fitting(["640x480", "1280x960", "1920x1080"].into_iter(), partial),
        _ => Vec::new(),
    }
}

/// The words that may stand for three numbers. Names of colours follow only a first letter: there
/// are 148.
fn shorthands(arg: Option<&Arg>, partial: &str) -> Vec<String> {
    match arg.and_then(|arg| arg.shorthand) {
        Some(Shorthand::Color) if !partial.is_empty() => fitting(color_names(), partial),
        Some(Shorthand::Axis) => fitting(["x", "y", "z"].into_iter(), partial),
        Some(Shorthand::Color) | None => Vec::new(),
    }
}

/// The words with this prefix; if there is none, those with it when case is ignored.
fn fitting<'a>(words: impl Iterator<Item = &'a str>, partial: &str) -> Vec<String> {
    let folded = partial.to_lowercase();
    let near: Vec<&str> = words.filter(|word| word.to_lowercase().starts_with(&folded)).collect();
    let exact: Vec<&str> = near.iter().copied().filter(|word| word.starts_with(partial)).collect();
    let found = if exact.is_empty() { near } else { exact };
    found.into_iter().map(str::to_owned).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn session() -> Session {
        let mut session = Session::default();
        for line in ["prm ball", "prm Box", "obj man", "ap ball head", "ap ball body", "obj other", "obj man"]
        {
            session.run_line(line).unwrap();
        }
        session
    }

    fn found(line: &str) -> (usize, String) {
        let completion = complete(&session(), line, line.len());
        (completion.start, completion.candidates.join(" "))
    }

    #[test]
    fn each_place_gets_what_fits_there() {
        assert_eq!(found("setCo"), (0, "setCoeff setColor".into()));
        assert_eq!(found("  SETCOL"), (2, "setColor".into()));
        assert_eq!(found("surf"), (0, "surface".into()));
        assert_eq!(found("ap b"), (3, "ball".into()));
        assert_eq!(found("ap bO"), (3, "Box".into()));
        assert_eq!(found("ap "), (3, "ball Box".into()));
        assert_eq!(found("ap ball h"), (8, String::new()));
        assert_eq!(found("ao "), (3, "man other".into()));
        assert_eq!(found("cur "), (4, "head body".into()));
        assert_eq!(found("remove he"), (7, "head".into()));
        assert_eq!(found("help und"), (5, "undo".into()));
        assert_eq!(found("info ball ma"), (10, "man".into()));
        assert_eq!(found("set prev"), (4, "preview".into()));
        assert_eq!(found("set preview k"), (12, "kitty".into()));
        assert_eq!(found("set wireframe "), (14, "on off".into()));
        assert_eq!(found("stop r"), (5, "render".into()));
        assert_eq!(found("save --h"), (5, "--history".into()));
        assert_eq!(found("nonsense b"), (9, String::new()));
        assert_eq!(found("filter "), (7, "box tent gaussian blackman mitchell".into()));
        assert_eq!(found("FILTER t"), (7, "tent".into()));
        assert_eq!(found("exposu"), (0, "exposure".into()));
        assert_eq!(found("xs 1 "), (5, String::new()));
        assert_eq!(found("ap b # ap b"), (11, String::new()));
        assert_eq!(found("key 2 rotateA"), (6, "rotateAll".into()));
        assert_eq!(found("key 2 add"), (6, String::new()));
        assert_eq!(found("key 2 floor 0 b"), (14, "ball".into()));
        assert_eq!(found("unkey "), (6, "all".into()));
        assert_eq!(found("color rebec"), (6, "rebeccapurple".into()));
        assert_eq!(found("color "), (6, String::new()));
        assert_eq!(found("light l 0 0 0 #f80 "), (19, String::new()));
        assert_eq!(found("key 2 setColor dodg"), (15, "dodgerblue".into()));
        assert_eq!(found("up "), (3, "x y z".into()));
        assert_eq!(found("sky sun"), (7, String::new()));
        assert_eq!(found("sky sun 1"), (8, String::new()));
    }

    #[test]
    fn files_are_left_to_whoever_knows_them() {
        let file = |line: &str| {
            let completion = complete(&session(), line, line.len());
            (completion.start, completion.file)
        };
        assert_eq!(file("load sce"), (5, Some("sce".into())));
        assert_eq!(file("load \"my fi"), (5, Some("my fi".into())));
        assert_eq!(file("render 640x480 a"), (15, Some("a".into())));
        assert_eq!(file("save --history "), (15, Some(String::new())));
        assert_eq!(file("ap sce").1, None);
    }

    #[test]
    fn any_cursor_is_survived() {
        let line = "load \"größe ü # \" ap ball";
        for at in 0..=line.len() + 2 {
            let completion = complete(&session(), line, at);
            assert!(completion.start <= line.len());
        }
    }
}
