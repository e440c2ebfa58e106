//! The README's table of commands is the command table. `SUPEREGG_BLESS=1` writes it anew.

use std::path::Path;

use superegg_lang::{COMMANDS, Group};

const BEGIN: &str = "<!-- commands: made from the command table by `SUPEREGG_BLESS=1 cargo test -p superegg-lang --test readme` -->\n";
const END: &str = "<!-- end of commands -->";

fn table() -> String {
    let mut text = String::from("\n| command | also | arguments | what it does |\n|---|---|---|---|\n");
    for group in Group::ALL {
        for spec in COMMANDS.iter().filter(|spec| spec.group == group) {
            let default =
                if spec.default.is_empty() { String::new() } else { format!(" (default: {})", spec.default) };
            text += &format!(
                "| {} | {} | {} | {}{default} |\n",
                spec.name,
                spec.spellings.join(", "),
                // A bar would begin another column.
                spec.usage().replace('|', "\\|"),
                spec.summary
            );
        }
    }
    text + "\n"
}

#[test]
fn the_readme_has_the_command_table() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../README.md");
    let readme = std::fs::read_to_string(&path).unwrap();
    let (before, rest) = readme.split_once(BEGIN).expect("the README has a place for the table");
    let (present, after) = rest.split_once(END).expect("the README ends the table");
    if std::env::var_os("SUPEREGG_BLESS").is_some() {
        std::fs::write(&path, [before, BEGIN, &table(), END, after].concat()).unwrap();
        return;
    }
    assert_eq!(present, table(), "the README's table is old");
}
