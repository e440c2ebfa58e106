//! The commands and settings in docs/language.md are those of the tables. `SUPEREGG_BLESS=1` writes them anew.

use std::path::{Path, PathBuf};

use superegg_lang::{
    ArgKind, COMMANDS, CommandSpec, Group, Needs, SETTINGS, SettingSpec, Settings, example_line,
};
use superegg_scene::Picture;

const BEGIN: &str = "<!-- commands: made from the command table by `SUPEREGG_BLESS=1 cargo test -p superegg-lang --test reference` -->\n";
const END: &str = "<!-- end of commands -->";

fn docs() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs")
}

/// A phrase as a sentence.
fn sentence(phrase: &str) -> String {
    let mut letters = phrase.chars();
    let first = letters.next().map(|letter| letter.to_uppercase().to_string()).unwrap_or_default();
    format!("{first}{}.", letters.as_str())
}

/// The picture of a command, described by the comment that its scene begins with.
fn picture(name: &str) -> Option<String> {
    let scene = std::fs::read_to_string(docs().join(format!("pictures/language/{name}.scn"))).ok()?;
    let about = scene.lines().next()?.trim_start_matches("# ");
    Some(format!(
        "![{about}](pictures/language/{name}.png)\n\n{about} ([scene](pictures/language/{name}.scn))\n"
    ))
}

fn command(spec: &CommandSpec) -> String {
    let mut text = format!(
        "### {}\n\n```text\n{}\n```\n\n",
        spec.name,
        format!("{} {}", spec.name, spec.usage()).trim_end()
    );
    text += &format!("{}\n\n", sentence(spec.summary));
    let mut facts = Vec::new();
    if !spec.spellings.is_empty() {
        let spellings: Vec<String> = spec.spellings.iter().map(|word| format!("`{word}`")).collect();
        facts.push(format!("Also: {}", spellings.join(", ")));
    }
    // Neighbours with the same range share a line.
    let mut ranges: Vec<(Vec<&str>, String)> = Vec::new();
    for arg in spec.all_args() {
        let ArgKind::Number(range) = arg.kind else { continue };
        match ranges.last_mut().filter(|(_, last)| *last == range.describe()) {
            Some((names, _)) => names.push(arg.name),
            None => ranges.push((vec![arg.name], range.describe())),
        }
    }
    for (names, range) in ranges {
        let names: Vec<String> = names.iter().map(|name| format!("`{name}`")).collect();
        facts.push(format!("{}: {range}", names.join(", ")));
    }
    match spec.needs() {
        Needs::Nothing => {}
        Needs::Primitive => facts.push("Needs a selected primitive".to_owned()),
        Needs::Object => facts.push("Needs a selected object".to_owned()),
    }
    if spec.is_keyable() && spec.name != "set" {
        facts.push("Can have [keys](animation.md)".to_owned());
    }
    if !spec.default.is_empty() {
        facts.push(format!("Default: {}", spec.default));
    }
    facts.push(format!("Example: `{}`", example_line(spec)));
    text += &facts.iter().map(|fact| format!("- {fact}\n")).collect::<String>();
    text + "\n" + &picture(spec.name).map(|picture| picture + "\n").unwrap_or_default()
}

fn setting(spec: &SettingSpec) -> String {
    let default = spec.value(&Picture::default(), &Settings::default());
    let summary = spec.summary.replace("; saved with the scene", "");
    let kept = if spec.is_of_scene { "scene" } else { "session" };
    format!("| `{}` | {} | {default} | {kept} | {} |\n", spec.name, spec.kind.describe(), sentence(&summary))
}

fn reference() -> String {
    let mut text = String::from("\n");
    for group in Group::ALL {
        text += &format!("## {}\n\n", group.title());
        text += &COMMANDS.iter().filter(|spec| spec.group == group).map(command).collect::<String>();
    }
    text += "## Settings\n\n`set NAME VALUE` changes a setting and `get NAME` shows it; a line may also begin with the name. Settings of the scene are saved with it.\n\n";
    text += "| setting | values | default | belongs to | meaning |\n|---|---|---|---|---|\n";
    text += &SETTINGS.iter().map(setting).collect::<String>();
    text + "\n"
}

#[test]
fn the_language_page_has_the_tables() {
    let path = docs().join("language.md");
    let page = std::fs::read_to_string(&path).unwrap();
    let (before, rest) = page.split_once(BEGIN).expect("the page has a place for the commands");
    let (present, after) = rest.split_once(END).expect("the page ends the commands");
    if std::env::var_os("SUPEREGG_BLESS").is_some() {
        std::fs::write(&path, [before, BEGIN, &reference(), END, after].concat()).unwrap();
        return;
    }
    assert_eq!(present, reference(), "docs/language.md is old: run this test with SUPEREGG_BLESS=1");
}
