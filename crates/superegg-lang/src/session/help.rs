//! The help, made from the command table.

use crate::diagnostic::{Fault, FaultCode};
use crate::grammar::command::Needs;
use crate::grammar::spec::{ArgKind, CommandSpec, Group, NameKind};
use crate::grammar::table::{COMMANDS, commands_spelt};
use crate::session::settings::SETTINGS;
use crate::suggest::Suggestions;
use crate::text::{beside, shorten, two_columns};

/// The list of commands by groups, or the help of each named command or group.
///
/// # Errors
/// The index in `names` of a word that is no command or group, and the fault.
pub fn help(names: &[String]) -> Result<String, (usize, Fault)> {
    if names.is_empty() {
        return Ok(list());
    }
    let texts: Result<Vec<String>, _> =
        names.iter().enumerate().map(|(i, name)| explain_named(i, name)).collect();
    Ok(texts?.join("\n\n"))
}

fn explain_named(i: usize, name: &str) -> Result<String, (usize, Fault)> {
    let group = || Group::ALL.into_iter().find(|group| group.word().eq_ignore_ascii_case(name));
    let texts: Vec<String> = commands_spelt(name).map(explain).collect();
    let text = (!texts.is_empty()).then(|| texts.join("\n\n"));
    text.or_else(|| group().map(list_group)).ok_or_else(|| {
        let words = COMMANDS.iter().flat_map(CommandSpec::all_spellings).chain(Group::ALL.map(Group::word));
        let fault = Fault::new(FaultCode::UnknownCommand, format!("there is no command '{}'", shorten(name)));
        (i, fault.help(Suggestions::Given.did_you_mean(name, words, "'help' alone lists the commands")))
    })
}

fn list() -> String {
    let groups = Group::ALL.map(list_group).join("\n\n");
    let words = Group::ALL.map(Group::word).join(", ");
    format!(
        "{groups}\n\nCase does not matter; # starts a comment. 'help COMMAND' explains one.\n\
         'help GROUP' lists one of\n{words}."
    )
}

fn list_group(group: Group) -> String {
    let mut text = group.title().to_owned();
    for spec in COMMANDS.iter().filter(|spec| spec.group == group) {
        let call = format!("{} {}", spec.all_spellings().collect::<Vec<_>>().join(", "), spec.usage());
        text.push('\n');
        text.push_str(&two_columns(&format!("  {}", call.trim_end()), spec.summary));
    }
    text
}

fn explain(spec: &CommandSpec) -> String {
    let mut text = format!("{} {}", spec.name, spec.usage()).trim_end().to_owned();
    text.push_str(&beside("\n", spec.summary, 2));
    if !spec.spellings.is_empty() {
        text.push_str(&format!("\n  also: {}", spec.spellings.join(", ")));
    }
    for arg in spec.all_args() {
        if let ArgKind::Number(range) = arg.kind {
            text.push_str(&format!("\n  {}: {}", arg.name, range.describe()));
        }
    }
    match spec.needs() {
        Needs::Nothing => {}
        Needs::Primitive => text.push_str("\n  needs: a selected primitive"),
        Needs::Object => text.push_str("\n  needs: a selected object"),
    }
    if spec
        .all_args()
        .any(|arg| matches!(arg.kind, ArgKind::Name(NameKind::Setting) | ArgKind::Words(NameKind::Setting)))
    {
        let names = SETTINGS.iter().map(|setting| setting.name).collect::<Vec<_>>().join(" ");
        text.push_str(&format!("\n{}", two_columns("  settings:", &names)));
    }
    if !spec.default.is_empty() {
        text.push_str(&beside("\n  default:", spec.default, 11));
    }
    text.push_str(&format!("\n  example: {}", spec.example));
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_list_has_every_command_once() {
        let text = help(&[]).unwrap();
        let flat = text.split_whitespace().collect::<Vec<_>>().join(" ");
        for spec in COMMANDS {
            assert_eq!(flat.matches(spec.summary).count(), 1, "{}", spec.name);
        }
        for line in text.lines() {
            assert!(line.chars().count() < 80, "{line}");
        }
        let group = help(&["Editing".into()]).unwrap();
        assert!(text.contains(&group) && group.contains("undo [N]") && !group.contains("setColor"));
    }

    #[test]
    fn one_command_is_explained_by_any_spelling() {
        let text = help(&["XS".into(), "coeff".into()]).unwrap();
        assert!(
            text.lines().all(|line| line.chars().count() < 80)
                && text.contains("translate x y z")
                && text.contains("x: above 0")
                && text.contains("also: coeff")
        );
        let both = help(&["ao".into()]).unwrap();
        assert!(
            both.contains("addObject NAME [ALIAS]") && both.contains("ambientOcclusion samples distance")
        );
    }
}
