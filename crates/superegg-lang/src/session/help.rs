//! The help, made from the command table, the settings and the topics.

use crate::diagnostic::{Fault, FaultCode};
use crate::grammar::command::Needs;
use crate::grammar::spec::{ArgKind, CommandSpec, Group, NameKind};
use crate::grammar::table::{COMMANDS, commands_spelt, find_command};
use crate::session::help_topics::{FIRST_STEPS, TOPICS, Topic};
use crate::session::settings::{SETTINGS, SettingSpec, find_setting};
use crate::suggest::Suggestions;
use crate::text::{beside, line_width, shorten, two_columns};

/// The word of the help that lists all commands.
const ALL: &str = "all";
/// The word of the help that lists all settings.
const ALL_SETTINGS: &str = "settings";

/// The first steps and the groups; or the help of each word: a command, a group, a setting, a topic.
/// Other words are searched together in names and texts. Lines fit a terminal of so many columns.
///
/// # Errors
/// The index in `words` of a word that is nowhere, and the fault.
pub fn help(words: &[String], columns: u16) -> Result<String, (usize, Fault)> {
    let width = line_width(columns);
    if words.is_empty() {
        return Ok(overview(width));
    }
    let mut texts: Vec<String> = words.iter().filter_map(|word| explain_word(word, width)).collect();
    let unknown = || words.iter().enumerate().filter(|(_, word)| !is_explained(word));
    if let Some((first, word)) = unknown().next() {
        let searched: Vec<&str> = unknown().map(|(_, word)| word.as_str()).collect();
        texts.push(search(&searched, width).ok_or_else(|| (first, nowhere(word)))?);
    }
    Ok(texts.join("\n\n"))
}

/// Every word that the help explains.
pub(crate) fn help_words() -> impl Iterator<Item = &'static str> {
    let commands = COMMANDS.iter().map(|spec| spec.name);
    let settings = SETTINGS.iter().map(|spec| spec.name).filter(|name| find_command(name).is_none());
    let topics = TOPICS.iter().flat_map(|topic| topic.words.iter().copied());
    commands.chain(Group::ALL.map(Group::word)).chain(settings).chain(topics).chain([ALL, ALL_SETTINGS])
}

fn is_explained(word: &str) -> bool {
    explain_word(word, line_width(u16::MAX)).is_some()
}

fn explain_word(word: &str, width: usize) -> Option<String> {
    let is = |other: &&str| other.eq_ignore_ascii_case(word);
    let mut texts: Vec<String> = commands_spelt(word).map(|spec| explain(spec, width)).collect();
    texts.extend(find_setting(word).map(|setting| explain_setting(setting, width)));
    if texts.is_empty() {
        let group = Group::ALL.into_iter().find(|group| is(&group.word()));
        texts.extend(group.map(|group| list_group(group, width)));
    }
    if texts.is_empty() {
        let topic = TOPICS.iter().find(|topic| topic.words.iter().any(is));
        texts.extend(topic.map(|topic| explain_topic(topic, width)));
    }
    if texts.is_empty() && is(&ALL) {
        texts.push(list(width));
    }
    if texts.is_empty() && is(&ALL_SETTINGS) {
        texts.push(list_settings(width));
    }
    (!texts.is_empty()).then(|| texts.join("\n\n"))
}

fn nowhere(word: &str) -> Fault {
    let spellings = COMMANDS.iter().flat_map(CommandSpec::all_spellings);
    let help = Suggestions::Given.did_you_mean(
        word,
        help_words().chain(spellings),
        "'help' alone shows where to begin, 'help all' lists the commands",
    );
    Fault::new(FaultCode::UnknownCommand, format!("there is no help about '{}'", shorten(word))).help(help)
}

fn overview(width: usize) -> String {
    let mut text = String::from("First steps, line by line:\n");
    for (line, what) in FIRST_STEPS {
        text.push_str(&format!("{}\n", two_columns(&format!("  {line}"), what, width)));
    }
    let heading = "Commands, by group ('help GROUP' explains them, 'help all' lists all):";
    text.push_str(&beside("\n", heading, 0, width));
    for group in Group::ALL {
        let names = COMMANDS.iter().filter(|spec| spec.group == group).map(|spec| spec.name);
        let names = names.collect::<Vec<_>>().join(" ");
        text.push_str(&beside(&format!("\n  {}", group.word()), &names, 14, width));
    }
    let topics =
        TOPICS.iter().map(|topic| topic.words[0]).chain([ALL_SETTINGS]).collect::<Vec<_>>().join(", ");
    text.push_str("\n\n");
    text.push_str(&two_columns("  help setColor, ? setColor", "explains a command or a setting", width));
    text.push('\n');
    text.push_str(&two_columns("  help soft shadows", "searches the help for words", width));
    text.push('\n');
    text.push_str(&two_columns("  help TOPIC", &format!("explains one of: {topics}"), width));
    text
}

fn list(width: usize) -> String {
    let groups = Group::ALL.map(|group| list_group(group, width)).join("\n\n");
    let words = Group::ALL.map(Group::word).join(", ");
    format!(
        "{groups}\n\n{}",
        beside(
            "",
            &format!(
                "Case does not matter; # starts a comment. 'help COMMAND' explains one. 'help GROUP' lists one of {words}."
            ),
            0,
            width
        )
    )
}

fn list_group(group: Group, width: usize) -> String {
    let specs = COMMANDS.iter().filter(|spec| spec.group == group);
    let lines = specs.map(|spec| command_line(spec, width)).collect::<Vec<_>>();
    format!("{}\n{}", group.title(), lines.join("\n"))
}

/// A command with its arguments and what it does.
fn command_line(spec: &CommandSpec, width: usize) -> String {
    let call = format!("{} {}", spec.all_spellings().collect::<Vec<_>>().join(", "), spec.usage());
    two_columns(&format!("  {}", call.trim_end()), spec.summary, width)
}

fn list_settings(width: usize) -> String {
    let lines: Vec<String> = SETTINGS.iter().map(|setting| setting_line(setting, width)).collect();
    let heading = "Settings: 'set NAME VALUE' changes one, 'get' lists them with their values";
    format!("{}\n{}", beside("", heading, 0, width), lines.join("\n"))
}

fn setting_line(setting: &SettingSpec, width: usize) -> String {
    let what = format!("{} ({})", setting.summary, setting.kind.describe());
    two_columns(&format!("  set {}", setting.name), &what, width)
}

fn explain_topic(topic: &Topic, width: usize) -> String {
    let lines = topic.lines.iter().map(|(left, right)| two_columns(&format!("  {left}"), right, width));
    let commands = topic.commands.iter().filter_map(|name| find_command(name));
    let settings = topic.settings.iter().filter_map(|name| find_setting(name));
    let all: Vec<String> = lines
        .chain(commands.map(|spec| command_line(spec, width)))
        .chain(settings.map(|setting| setting_line(setting, width)))
        .collect();
    format!("{}\n{}", beside("", topic.title, 0, width), all.join("\n"))
}

fn explain_setting(setting: &SettingSpec, width: usize) -> String {
    let mut text = format!("set {} VALUE", setting.name);
    text.push_str(&beside("\n", setting.summary, 2, width));
    text.push_str(&beside("\n  VALUE:", &setting.kind.describe(), 11, width));
    text.push_str(&format!("\n  default: {}", setting.default_text()));
    text.push_str(&format!("\n  example: set {} {}", setting.name, setting.example_text()));
    text
}

/// The commands, settings and topics that mention all these words; `None` if there are none.
fn search(words: &[&str], width: usize) -> Option<String> {
    let wanted: Vec<String> = words.iter().map(|word| stem(word)).collect();
    let mentions = |texts: &[&str]| {
        let all = folded(&texts.join(" "));
        wanted.iter().all(|word| all.contains(word.as_str()))
    };
    let commands = COMMANDS.iter().filter(|spec| {
        let spellings = spec.all_spellings().collect::<Vec<_>>().join(" ");
        mentions(&[&spellings, spec.summary, spec.default, spec.example, &spec.usage()])
    });
    let settings = SETTINGS.iter().filter(|setting| mentions(&[setting.name, setting.summary]));
    let topics = TOPICS.iter().filter(|topic| {
        let lines = topic.lines.iter().map(|(left, right)| format!("{left} {right}")).collect::<Vec<_>>();
        mentions(&[topic.title, &topic.words.join(" "), &lines.join(" ")])
    });
    let found: Vec<String> = commands
        .map(|spec| command_line(spec, width))
        .chain(settings.map(|setting| setting_line(setting, width)))
        .chain(topics.map(|topic| two_columns(&format!("  help {}", topic.words[0]), topic.title, width)))
        .collect();
    let named = words.iter().map(|word| shorten(word)).collect::<Vec<_>>().join(" ");
    (!found.is_empty())
        .then(|| format!("{}\n{}", beside("About", &format!("'{named}':"), 0, width), found.join("\n")))
}

/// A word as it is searched: without case and the ending of a plural.
fn stem(word: &str) -> String {
    let folded = folded(word);
    match folded.strip_suffix('s') {
        Some(singular) if singular.len() >= 3 => singular.to_owned(),
        _ => folded,
    }
}

/// A text without case, in American spelling.
fn folded(text: &str) -> String {
    text.to_lowercase().replace("colour", "color").replace("centre", "center")
}

fn explain(spec: &CommandSpec, width: usize) -> String {
    let mut text = format!("{} {}", spec.name, spec.usage()).trim_end().to_owned();
    text.push_str(&beside("\n", spec.summary, 2, width));
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
        text.push_str(&beside("\n  settings:", &names, 12, width));
    }
    if !spec.default.is_empty() {
        text.push_str(&beside("\n  default:", spec.default, 11, width));
    }
    text.push_str(&format!("\n  example: {}", example_line(spec)));
    text
}

/// The example of a command behind all that it needs, so that the line can be pasted into a new
/// session.
pub fn example_line(spec: &CommandSpec) -> String {
    let before = match spec.name {
        "addObject" => "object arm; object robot; ",
        "addPrimitive" => "primitive ball; object snowman; ",
        "delete" | "rename" | "copy" | "undo" | "show" | "info" | "frame" | "render" | "preview"
        | "iotest" | "intersect" | "save" | "export" => "primitive ball; ",
        "redo" => "primitive ball; undo; ",
        "unhide" => "primitive ball; object snowman; addPrimitive ball head; hide head; ",
        "setCursor" | "remove" | "renameChild" | "hide" => {
            "primitive ball; object snowman; addPrimitive ball head; "
        }
        "lightRadius" | "unlight" => "light lamp 3 4 5; ",
        "floor" => "primitive tiles; ",
        "floorUp" | "unfloor" => "floor -1; ",
        "key" => "primitive ball; object snowman; addPrimitive ball; ",
        "unkey" => "primitive ball; object snowman; addPrimitive ball; key 24 rotate z 90; ",
        _ => match spec.needs() {
            Needs::Nothing => "",
            Needs::Primitive => "primitive ball; ",
            Needs::Object => "primitive ball; object snowman; addPrimitive ball; ",
        },
    };
    format!("{before}{}", spec.example)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parse::commands::split_commands;
    use crate::session::timeline::Timeline;

    fn about(words: &str) -> String {
        let words: Vec<String> = words.split(' ').map(str::to_owned).collect();
        help(&words, 80).unwrap_or_else(|(_, fault)| panic!("{words:?}: {}", fault.message))
    }

    #[test]
    fn the_list_has_every_command_once() {
        let text = about("all");
        let flat = text.split_whitespace().collect::<Vec<_>>().join(" ");
        for spec in COMMANDS {
            assert_eq!(flat.matches(spec.summary).count(), 1, "{}", spec.name);
        }
        let group = about("Editing");
        assert!(text.contains(&group) && group.contains("undo [N]") && !group.contains("setColor"));
    }

    #[test]
    fn lines_fit_the_terminal() {
        let words: Vec<&str> = help_words().collect();
        for columns in [60, 80, 100, 300] {
            let width = line_width(columns);
            let texts = words.iter().map(|word| help(&[(*word).to_owned()], columns).unwrap());
            for text in texts.chain([help(&[], columns).unwrap()]) {
                for line in text.lines().filter(|line| !line.contains("example:")) {
                    // A command with its arguments is not broken.
                    let first = line.split(' ').next().unwrap_or_default();
                    let is_indented = line.starts_with("  ") && !line.starts_with("   ");
                    let is_call = is_indented || find_command(first).is_some();
                    assert!(line.chars().count() <= width || is_call, "{columns}: {line}");
                }
            }
        }
    }

    #[test]
    fn one_command_is_explained_by_any_spelling() {
        let text = about("XS coeff");
        assert!(
            text.contains("translate x y z") && text.contains("x: above 0") && text.contains("also: coeff")
        );
        let both = about("ao");
        assert!(
            both.contains("addObject NAME [ALIAS]") && both.contains("ambientOcclusion samples distance")
        );
    }

    #[test]
    fn settings_topics_and_texts_are_found() {
        for (words, part) in [
            ("samples", "set samples VALUE"),
            ("material", "setGloss"),
            ("lights", "lightRadius"),
            ("keys", "ctrl-r"),
            ("settings", "set exposure"),
            ("soft shadows", "lightRadius"),
            ("colour", "setColor"),
            ("depth of field", "lens"),
            ("preview", "set preview VALUE"),
            ("fov_deg", "camera"),
        ] {
            assert!(about(words).contains(part), "{words}: {}", about(words));
        }
        let (at, fault) = help(&["help".into(), "setColr".into()], 80).unwrap_err();
        assert_eq!((at, fault.help.as_deref()), (1, Some("did you mean 'setColor'?")));
    }

    #[test]
    fn every_example_can_be_pasted_into_a_new_session() {
        let lines = COMMANDS.iter().map(|spec| (spec.name, example_line(spec)));
        let steps = FIRST_STEPS.iter().map(|(line, _)| *line).collect::<Vec<_>>().join("; ");
        let glass = TOPICS.iter().find(|topic| topic.words.contains(&"glass")).unwrap();
        let glass = glass.lines.iter().map(|(name, line)| (*name, (*line).to_owned()));
        for (name, line) in lines.chain(glass).chain([("first steps", steps)]) {
            let mut timeline = Timeline::default();
            for (_, command) in split_commands(&line) {
                let done = timeline.run_line(command);
                assert!(done.is_ok(), "{name}: {command}: {done:?}");
            }
        }
    }
}
