//! `superegg completions` and `superegg man`: files of an installation, made from the arguments.

use std::path::Path;

use anyhow::{Result, bail};
use clap::{Command, CommandFactory};

use crate::args::{Args, CompletionsArgs, ManArgs};
use crate::console;
use crate::files;
use crate::outcome::Outcome;

/// The name of the program.
const NAME: &str = "superegg";

/// Prints the completions of a shell.
pub(crate) fn print_completions(args: &CompletionsArgs) -> Result<Outcome> {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut Args::command(), NAME, &mut script);
    console::print_raw(String::from_utf8_lossy(&script).trim_end())?;
    Ok(Outcome::Fine)
}

/// Writes the man pages of the program and of each command.
pub(crate) fn write_man_pages(args: &ManArgs) -> Result<Outcome> {
    let folder = &args.folder;
    if !folder.is_dir() {
        bail!("cannot write man pages into '{}': there is no such folder", folder.display());
    }
    let mut program = Args::command();
    program.build();
    let commands: Vec<Command> =
        program.get_subcommands().filter(|command| command.get_name() != "help").cloned().collect();
    let mut pages = vec![(NAME.to_owned(), program)];
    pages.extend(commands.into_iter().map(|command| (format!("{NAME}-{}", command.get_name()), command)));
    for (name, command) in pages {
        let mut page = Vec::new();
        let version = env!("CARGO_PKG_VERSION");
        let man = clap_mangen::Man::new(command.version(version)).title(name.to_uppercase());
        man.render(&mut page)?;
        let path = folder.join(format!("{name}.1"));
        files::check_output(Some(&path), Path::new(""), args.overwrite.into())?;
        files::write(&path, &page)?;
        console::print(path.display())?;
    }
    Ok(Outcome::Fine)
}
