//! Help, made from the table.

use crate::diagnostic::Fault;
use crate::parser::shorten;
use crate::session::did_you_mean;
use crate::spec::{ArgKind, CommandSpec, Group, Needs};
use crate::table::{COMMANDS, find_command};

/// The list of commands by groups, or the text of each of those named.
///
/// # Errors
/// A word that is no command, with its place in `names`.
pub fn help(names: &[String]) -> Result<String, (usize, Fault)> {
    if names.is_empty() {
        return Ok(list());
    }
    let texts: Result<Vec<String>, _> =
        names.iter().enumerate().map(|(i, name)| explain_named(i, name)).collect();
    Ok(texts?.join("\n\n"))
}

fn explain_named(i: usize, name: &str) -> Result<String, (usize, Fault)> {
    find_command(name).map(explain).ok_or_else(|| {
        let spellings = COMMANDS.iter().flat_map(CommandSpec::all_spellings);
        let fault = Fault::new("unknown-command", format!("there is no command '{}'", shorten(name)));
        (i, fault.help(did_you_mean(name, spellings, "'help' alone lists the commands")))
    })
}

fn list() -> String {
    let mut text = String::new();
    for group in Group::ALL {
        text.push_str(&format!("{}\n", group.title()));
        for spec in COMMANDS.iter().filter(|spec| spec.group == group) {
            let call = format!("{} {}", spec.all_spellings().collect::<Vec<_>>().join(", "), spec.usage());
            text.push_str(&format!("  {:<46} {}\n", call.trim_end(), spec.summary));
        }
        text.push('\n');
    }
    text.push_str("Case does not matter; # starts a comment. 'help COMMAND' tells more.");
    text
}

fn explain(spec: &CommandSpec) -> String {
    let mut text = format!("{} {}", spec.name, spec.usage()).trim_end().to_owned();
    text.push_str(&format!("\n  {}", spec.summary));
    if !spec.spellings.is_empty() {
        text.push_str(&format!("\n  also: {}", spec.spellings.join(", ")));
    }
    for arg in spec.all_args() {
        if let ArgKind::Number(range) = arg.kind {
            text.push_str(&format!("\n  {}: {}", arg.name, range.describe()));
        }
    }
    match spec.needs {
        Needs::Nothing => {}
        Needs::Primitive => text.push_str("\n  needs: a selected primitive"),
        Needs::Object => text.push_str("\n  needs: a selected object"),
    }
    if !spec.default.is_empty() {
        text.push_str(&format!("\n  default: {}", spec.default));
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
        for spec in COMMANDS {
            assert_eq!(text.matches(spec.summary).count(), 1, "{}", spec.name);
        }
    }

    #[test]
    fn one_command_is_explained_by_any_spelling() {
        let text = help(&["XS".into(), "coeff".into()]).unwrap();
        assert!(
            text.contains("translate x y z") && text.contains("x: above 0") && text.contains("also: coeff")
        );
    }
}
