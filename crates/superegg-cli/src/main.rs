//! The command `superegg`: arguments, files, printing, exit codes. The only crate that prints.

mod args;
mod commands;
mod csv_input;
mod files;
mod folders;
mod interrupt;
mod load;
mod long_render;
mod memory;
mod modeller;
mod part_file;
mod picture_file;
mod pointless;
mod prompt;
mod say;
mod share;

use std::process::ExitCode;

use clap::Parser;

use crate::args::{Args, Command};
use crate::commands::Outcome;

/// Wrong usage, or a file that cannot be read or written.
const EXIT_USAGE: u8 = 2;

fn main() -> ExitCode {
    let args = Args::try_parse().unwrap_or_else(|error| {
        // A slip in a command's name would be taken for the name of a scene.
        match std::env::args()
            .nth(1)
            .filter(|_| error.use_stderr())
            .and_then(|word| args::no_such_command(&word))
        {
            Some(told) => {
                say::complain(format_args!("superegg: {told}"));
                std::process::exit(EXIT_USAGE.into());
            }
            None => error.exit(),
        }
    });
    let Some(command) = args.command else { return finish(commands::model::run(args.scene.as_deref())) };
    finish(match command {
        Command::Render(args) => commands::render::run(&args),
        Command::Animate(args) => commands::animate::run(&args),
        Command::Merge(args) => commands::merge::run(&args),
        Command::Intersect(args) => commands::intersect::run(&args),
        Command::Iotest(args) => commands::iotest::run(&args),
        Command::Info(args) => commands::info::run(&args),
        Command::Check(args) => commands::check::run(&args),
        Command::Bench(args) => commands::bench::run(&args),
        Command::Export(args) => commands::export::run(&args),
        Command::Run(args) => commands::run::run(&args),
        Command::View(args) => commands::view::run(&args),
    })
}

fn finish(outcome: anyhow::Result<Outcome>) -> ExitCode {
    match outcome {
        Ok(Outcome::Fine) => ExitCode::SUCCESS,
        Ok(Outcome::ErrorsInInput) => ExitCode::from(1),
        Ok(Outcome::Stopped(code)) => ExitCode::from(code),
        Err(error) if is_broken_pipe(&error) => ExitCode::SUCCESS,
        Err(error) => {
            say::complain(format_args!("superegg: {error:#}"));
            ExitCode::from(EXIT_USAGE)
        }
    }
}

/// The reader of a pipe has had enough: not an error of ours.
fn is_broken_pipe(error: &anyhow::Error) -> bool {
    error
        .chain()
        .filter_map(|cause| cause.downcast_ref::<std::io::Error>())
        .any(|cause| cause.kind() == std::io::ErrorKind::BrokenPipe)
}
