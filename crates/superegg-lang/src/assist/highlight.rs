//! Syntax highlighting of a line.

use std::ops::Range;

use crate::assist::names::{is_name_of, names_of, next_arg};
use crate::color::color_names;
use crate::grammar::spec::{ArgKind, CommandSpec, NameKind, Shorthand, parse_size, size_form};
use crate::grammar::table::COMMANDS;
use crate::parse::number::parse_number;
use crate::parse::parser::command_of;
use crate::parse::parser::{line_within, words_of_command};
use crate::parse::words::Word;
use crate::session::interpreter::Session;
use crate::session::settings::{SETTINGS, can_be, find_setting};

/// The class of a part of a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Paint {
    /// A command.
    Command,
    /// An existing name.
    Name,
    /// A valid number, size, option or choice.
    Value,
    /// A word that is wrong however the line continues.
    Wrong,
    /// A comment.
    Comment,
}

/// The classified parts of a line, as ranges of bytes in order. The last word is not wrong while it
/// may still become valid.
pub fn highlight(session: &Session, line: &str) -> Vec<(Range<usize>, Paint)> {
    let words = words_of_command(line);
    let mut bytes_of_columns: Vec<usize> = line.char_indices().map(|(byte, _)| byte).collect();
    bytes_of_columns.push(line.len());
    let bytes = |columns: &Range<usize>| bytes_of_columns[columns.start]..bytes_of_columns[columns.end];
    let mut parts = Vec::new();
    let (mut line_words, mut fits): (&[Word<'_>], fn(&CommandSpec) -> bool) = (&words, |_| true);
    while let Some((first, rest)) = line_words.split_first() {
        let spec = command_of(first.text, rest);
        let first_paint = match spec {
            Some(spec) if fits(spec) => Some(Paint::Command),
            None if find_setting(first.text).is_some() => Some(Paint::Command),
            None if rest.is_empty() && begins_command(first.text) => None,
            _ => Some(Paint::Wrong),
        };
        parts.extend(first_paint.map(|paint| (bytes(&first.columns), paint)));
        let within = spec.and_then(|spec| line_within(spec, rest)).unwrap_or(&[]);
        let own = &rest[..rest.len() - within.len()];
        for (i, word) in own.iter().enumerate().filter(|_| spec.is_some()) {
            let is_typed = i + 1 == rest.len() && bytes(&word.columns).end == line.len();
            let paint = spec.and_then(|spec| paint_of(session, spec, &rest[..i], word, is_typed));
            parts.extend(paint.map(|paint| (bytes(&word.columns), paint)));
        }
        if let (None, Some(setting), Some(value)) = (spec, find_setting(first.text), rest.first()) {
            let is_typed = rest.len() == 1 && bytes(&value.columns).end == line.len();
            let paint = if can_be(setting.name, value.text) { Some(Paint::Value) } else { None };
            parts.extend(
                paint.or((!is_typed).then_some(Paint::Wrong)).map(|paint| (bytes(&value.columns), paint)),
            );
        }
        (line_words, fits) = (within, CommandSpec::is_keyable);
    }
    let end_of_words = words.last().map_or(0, |word| bytes(&word.columns).end);
    if let Some(comment) = line[end_of_words..].find('#') {
        parts.push((end_of_words + comment..line.len(), Paint::Comment));
    }
    parts
}

/// The class of an argument, given the arguments before it.
fn paint_of(
    session: &Session,
    spec: &CommandSpec,
    before: &[Word<'_>],
    word: &Word<'_>,
    is_typed: bool,
) -> Option<Paint> {
    let text = word.text;
    let right_or_wrong = |is_right: bool| Some(if is_right { Paint::Value } else { Paint::Wrong });
    let unless_typed = |begins: bool| (!(is_typed && begins)).then_some(Paint::Wrong);
    if spec.is_position_free(text) {
        return right_or_wrong(size_form(text).is_none() || parse_size(text).is_ok());
    }
    let Some(arg) = next_arg(spec, before) else { return Some(Paint::Wrong) };
    if arg.shorthand.is_some_and(|shorthand| shorthand.numbers_of(text).is_some()) {
        return Some(Paint::Value);
    }
    match arg.kind {
        // A word that may become the name of a colour.
        ArgKind::Number(_)
            if arg.shorthand == Some(Shorthand::Color)
                && is_typed
                && (text.starts_with('#') || color_names().any(|name| begins(name, text))) =>
        {
            None
        }
        ArgKind::Number(range) => match parse_number(text) {
            Ok(number) => right_or_wrong(range.contains(number)),
            Err(_) => {
                unless_typed(matches!(text, "-" | "+" | "." | "-." | "+.") || text.ends_with(['e', 'E', '-']))
            }
        },
        ArgKind::Name(of) | ArgKind::Words(of) => {
            let is_there = is_name_of(session, of, text)
                || (matches!(of, NameKind::Entity)
                    && matches!(arg.kind, ArgKind::Words(_))
                    && is_word_of_info(text));
            let may_be_new = match of {
                // Other words are searched for.
                NameKind::New | NameKind::HelpWord => true,
                NameKind::PrimitiveOrNew | NameKind::ObjectOrNew => session.scene().get(text).is_none(),
                _ => false,
            };
            if is_there {
                Some(Paint::Name)
            } else if may_be_new {
                None
            } else {
                unless_typed(names_of(session, of).iter().any(|name| begins(name, text)))
            }
        }
        ArgKind::Choice(choices) => {
            if choices.iter().any(|choice| choice.eq_ignore_ascii_case(text)) {
                Some(Paint::Value)
            } else {
                unless_typed(choices.iter().any(|choice| begins(choice, text)))
            }
        }
        ArgKind::Value => match before.last().map(|setting| can_be(setting.text, text)) {
            Some(true) => Some(Paint::Value),
            _ => unless_typed(true),
        },
        ArgKind::File | ArgKind::Size | ArgKind::Line => None,
    }
}

fn is_word_of_info(word: &str) -> bool {
    ["all", "selected"].iter().any(|known| known.eq_ignore_ascii_case(word))
}

fn begins(name: &str, start: &str) -> bool {
    name.get(..start.len()).is_some_and(|head| head.eq_ignore_ascii_case(start))
}

fn begins_command(start: &str) -> bool {
    let settings = SETTINGS.iter().map(|setting| setting.name);
    COMMANDS
        .iter()
        .flat_map(CommandSpec::all_spellings)
        .chain(settings)
        .any(|spelling| begins(spelling, start))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shown(line: &str) -> String {
        let mut session = Session::default();
        for line in ["prm ball", "obj man", "ap ball head"] {
            session.run_line(line).unwrap();
        }
        let letter = |paint| match paint {
            Paint::Command => 'c',
            Paint::Name => 'n',
            Paint::Value => 'v',
            Paint::Wrong => 'w',
            Paint::Comment => '#',
        };
        let mut marks = vec![b'.'; line.len()];
        for (range, paint) in highlight(&session, line) {
            marks[range].fill(letter(paint) as u8);
        }
        String::from_utf8(marks).unwrap()
    }

    #[test]
    fn each_word_is_what_it_is() {
        for (line, expected) in [
            ("setColor 1 2 .5", "cccccccc.v.w.vv"),
            ("xs 1 tw 3", "cc.v.ww.v"),
            ("xs -", "cc.."),
            ("xs - 2", "cc.w.v"),
            ("setCol", "......"),
            ("setColr 1", "wwwwwww.."),
            ("ap ball arm", "cc.nnnn...."),
            ("ap ba", "cc..."),
            ("ap ba x", "cc.ww.."),
            ("prm new # c", "ccc.....###"),
            ("prm man", "ccc.www"),
            ("info ball selected", "cccc.nnnn.nnnnnnnn"),
            ("render a.png 64x48 9", "cccccc.......vvvvv.w"),
            ("set size 64x48", "ccc.nnnn.vvvvv"),
            ("coeff 1 1 1 1", "ccccc.v.v.v.w"),
            ("ao 16 2", "cc.vv.v"),
            ("ao man 2", "cc.nnn.."),
            ("key 24 rotate 0 0 x", "ccc.vv.cccccc.v.v.w"),
            ("key 24 rotat", "ccc.vv......"),
            ("key x delete ball", "ccc.w.wwwwww.nnnn"),
            ("unkey all rotate", "ccccc.nnn.nnnnnn"),
            ("color #ff8000 # c", "ccccc.vvvvvvv.###"),
            ("color #ff8", "ccccc.vvvv"),
            ("color #ff80", "ccccc......"),
            ("color #ff80 1", "ccccc.wwwww.v"),
            ("color orange 1", "ccccc.vvvvvv.w"),
            ("color oran", "ccccc....."),
            ("color oran 1", "ccccc.wwww.v"),
            ("light l 0 0 0 #f80 2 # c", "ccccc...v.v.v.vvvv.v.###"),
            ("light l 0 0 0 #fading", "ccccc...v.v.v.#######"),
            ("xs 1 2 3 #fff", "cc.v.v.v.####"),
            ("up -z", "cc.vv"),
            ("zzz", "www"),
            ("sky sun 40 3 60", "ccccccc.vv.v.vv"),
            ("SKY  Sun 40 .5 # c", "cccccccc.vv.ww.###"),
            ("key 4 sky sun 40", "ccc.v.ccccccc.vv"),
            ("prm a sky sun", "ccc...www.www"),
            ("sky orange", "ccc.vvvvvv"),
        ] {
            assert_eq!(shown(line), expected, "{line}");
        }
    }

    #[test]
    fn parts_are_in_order_and_within_any_line() {
        let session = Session::default();
        for line in ["größe # ß", "load \"a # b\" # c", "\"", "#", " \u{3000}xs\u{a0}1", "save \"ü"] {
            let mut last = 0;
            for (range, _) in highlight(&session, line) {
                assert!(range.start >= last && line.get(range.clone()).is_some(), "{line}");
                last = range.end;
            }
        }
    }
}
