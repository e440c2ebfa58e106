//! The hint after the cursor: the arguments still to come.

use superegg_scene::Entity;

use crate::assist::names::next_arg;
use crate::grammar::command::Needs;
use crate::grammar::spec::{Arg, ArgKind, CommandSpec};
use crate::grammar::table::{COMMANDS, commands_spelt, find_command};
use crate::parse::number::parse_number;
use crate::parse::parser::{line_within, words_of_command};
use crate::parse::words::Word;
use crate::session::interpreter::Session;
use crate::session::settings::find_setting;

/// The text to show after the end of a line.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Hint {
    /// The rest of the command's name, which the user may accept; empty if the name is complete.
    pub rest_of_name: String,
    /// The remaining arguments with their ranges, or what is wrong.
    pub arguments: String,
}

/// The hint for a line with the cursor at its end.
pub fn hint(session: &Session, line: &str) -> Option<Hint> {
    if line.contains('#') {
        return None;
    }
    let words = words_of_command(line);
    let is_at_word = !line.ends_with(char::is_whitespace);
    let mut words: &[Word<'_>] = &words;
    // Descend into a nested line, once it has begun.
    while let Some((first, rest)) = words.split_first()
        && let Some(within) = find_command(first.text).and_then(|spec| line_within(spec, rest))
        && !within.is_empty()
    {
        words = within;
    }
    let (first, rest) = words.split_first()?;
    let (spec, rest_of_name) = match command_so_far(first.text, rest) {
        Some(spec) => (spec, String::new()),
        None if rest.is_empty() => match find_setting(first.text) {
            Some(setting) => {
                let gap = if is_at_word { " " } else { "" };
                let arguments = format!("{gap}VALUE({})", setting.kind.describe());
                return Some(Hint { rest_of_name: String::new(), arguments });
            }
            None if is_at_word => only_command(first.text)?,
            None => return None,
        },
        None => return None,
    };
    let mut arguments = arguments_after(spec, spec.position_after(rest.iter().map(|word| word.text)));
    let others: Vec<_> = commands_spelt(first.text).skip(1).filter(|_| rest.is_empty()).collect();
    for other in &others {
        arguments.push_str(&format!(" or {}", arguments_after(other, 0)));
    }
    if let Some(setting) = rest.first().and_then(|word| find_setting(word.text))
        && next_arg(spec, rest).is_some_and(|arg| arg.kind == ArgKind::Value)
    {
        arguments = format!("VALUE({})", setting.kind.describe());
    }
    if is_at_word && !arguments.is_empty() {
        arguments.insert(0, ' ');
    }
    if let Some(wrong) = wrong_number(spec, rest).filter(|_| is_at_word) {
        arguments = wrong;
    }
    if others.is_empty() && !is_selected(session, spec.needs()) {
        arguments.push_str(match spec.needs() {
            Needs::Nothing => "",
            Needs::Primitive => "   needs a selected primitive",
            Needs::Object => "   needs a selected object",
        });
    }
    (!arguments.is_empty() || !rest_of_name.is_empty()).then_some(Hint { rest_of_name, arguments })
}

/// The command of an incomplete line. For two with one spelling it is the one that takes numbers, if
/// the first argument is a number.
fn command_so_far(first: &str, rest: &[Word<'_>]) -> Option<&'static CommandSpec> {
    let is_of_numbers =
        (1..=2).contains(&rest.len()) && rest.iter().all(|word| parse_number(word.text).is_ok());
    commands_spelt(first).nth(usize::from(is_of_numbers)).or_else(|| find_command(first))
}

/// The range of the last word, if it is a number outside it.
fn wrong_number(spec: &CommandSpec, rest: &[Word<'_>]) -> Option<String> {
    let (last, before) = rest.split_last()?;
    let ArgKind::Number(range) = next_arg(spec, before)?.kind else { return None };
    let number = parse_number(last.text).ok()?;
    let name = next_arg(spec, before)?.name;
    (!range.contains(number)).then(|| format!("   {name} must be {}", range.describe()))
}

/// The only command with this prefix, and the rest of its name.
fn only_command(word: &str) -> Option<(&'static CommandSpec, String)> {
    let begins = |name: &str| name.get(..word.len()).is_some_and(|start| start.eq_ignore_ascii_case(word));
    let mut fitting = COMMANDS.iter().filter(|spec| begins(spec.name));
    let spec = fitting.next()?;
    fitting.next().is_none().then(|| (spec, spec.name[word.len()..].to_owned()))
}

/// The arguments from an index on; optional ones in brackets.
fn arguments_after(spec: &CommandSpec, index: usize) -> String {
    let mut words = Vec::new();
    let mut at = 0;
    for (part, args) in spec.args.iter().enumerate() {
        let (open, close) = if part == 0 { ("", "") } else { ("[", "]") };
        let shown: Vec<String> = args
            .iter()
            .filter(|arg| {
                at += 1;
                at > index || matches!(arg.kind, ArgKind::Words(_) | ArgKind::Line)
            })
            .map(brief)
            .collect();
        if !shown.is_empty() {
            words.push(format!("{open}{}{close}", shown.join(" ")));
        }
    }
    words.join(" ")
}

fn brief(arg: &Arg) -> String {
    match arg.kind {
        ArgKind::Number(range) if !range.brief().is_empty() => format!("{}({})", arg.name, range.brief()),
        ArgKind::Choice(choices) => choices.join("|"),
        ArgKind::Words(_) | ArgKind::Line => format!("{} ...", arg.name),
        _ => arg.name.to_owned(),
    }
}

fn is_selected(session: &Session, needs: Needs) -> bool {
    let selected = session.selected().and_then(|name| session.scene().get(name));
    match needs {
        Needs::Nothing => true,
        Needs::Primitive => matches!(selected, Some(Entity::Primitive(_))),
        Needs::Object => matches!(selected, Some(Entity::Object(_))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shown(line: &str) -> Option<String> {
        let mut session = Session::default();
        session.run_line("prm ball").unwrap();
        hint(&session, line).map(|hint| format!("{}|{}", hint.rest_of_name, hint.arguments))
    }

    #[test]
    fn what_is_still_to_come_is_shown_with_its_range() {
        for (line, expected) in [
            ("setColor", "| r(0..1) g(0..1) b(0..1)"),
            ("setColor ", "|r(0..1) g(0..1) b(0..1)"),
            ("setColor 1 ", "|g(0..1) b(0..1)"),
            ("color 1 0.5", "| b(0..1)"),
            ("setExpo", "nent| e(>=0) n(>=0)"),
            ("camera 1 2 3 4 5 6 ", "|[fov_deg(0..180)]"),
            ("info ball", "| [NAME ...]"),
            ("xs ", "|x y z   needs a selected object"),
            ("render 64x48 ", "|[FILE] [WxH]"),
            ("set wireframe ", "|VALUE(on or off)"),
            ("stop", "| [render]"),
            ("ao ", "|NAME [ALIAS] or samples(0, 1 .. 65536) distance(>0)"),
            ("ao ball ", "|[ALIAS]   needs a selected object"),
            ("ao 16 ", "|distance(>0)"),
            (
                "setPattern",
                "| none|checker|gradient|noise|marble|wood [r(0..1) g(0..1) b(0..1)] [size|x] [y z]",
            ),
            ("key ", "|FRAME COMMAND ..."),
            ("key 2 ", "|COMMAND ..."),
            ("key 2 setColor 1 ", "|g(0..1) b(0..1)"),
            ("key 2 rotate ", "|x y z degrees   needs a selected object"),
            ("exp 1 -3", "|   n must be 0 or above"),
            ("wireframe", "| VALUE(on or off)"),
            ("noise ", "|VALUE(from 0 to 1)"),
            ("sky sun ", "|elevation(0..90) turbidity(1.7..10) [azimuth]"),
        ] {
            assert_eq!(shown(line).as_deref(), Some(expected), "{line}");
        }
        for line in ["", "   ", "set", "setC", "setColor 1 1 1", "nonsense", "coeff # 1", "ß"] {
            let hint = shown(line);
            assert!(hint.is_none() || line == "set", "{line}: {hint:?}");
        }
    }
}
