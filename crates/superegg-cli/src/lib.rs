//! The program `superegg`: command-line arguments, files, console output and exit codes.
//!
//! No other crate of the workspace prints. Modules use only modules that stand above them in this
//! list.

mod console;
mod outcome;
mod progress;
mod system;
mod text;

mod annotate;

mod files;
mod inspect;
mod long;

mod args;

mod modeller;
mod prompt;

mod commands;

use std::process::ExitCode;

use clap::Parser;

use crate::args::{Args, Command};
use crate::outcome::{EXIT_ERRORS, EXIT_USAGE, Outcome};

fn main() -> ExitCode {
    let args = Args::try_parse().unwrap_or_else(|error| {
        // Without this check a misspelt command is taken for the name of a scene.
        match std::env::args()
            .nth(1)
            .filter(|_| error.use_stderr())
            .and_then(|word| args::unknown_command(&word))
        {
            Some(error) => {
                console::warn(format_args!("superegg: {error}"));
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
        Command::Import(args) => commands::import::run(&args),
        Command::Sample(args) => commands::sample::run(&args),
        Command::Measure(args) => commands::measure::run(&args),
        Command::Info(args) => commands::info::run(&args),
        Command::Check(args) => commands::check::run(&args),
        Command::Bench(args) => commands::bench::run(&args),
        Command::Export(args) => commands::export::run(&args),
        Command::Run(args) => commands::run::run(&args),
        Command::View(args) => commands::view::run(&args),
    })
}

/// The exit code of a command; prints its error.
fn finish(result: anyhow::Result<Outcome>) -> ExitCode {
    match result {
        Ok(Outcome::Fine) => ExitCode::SUCCESS,
        Ok(Outcome::ErrorsInInput) => ExitCode::from(EXIT_ERRORS),
        Ok(Outcome::Stopped(code)) => ExitCode::from(code),
        Err(error) if is_broken_pipe(&error) => ExitCode::SUCCESS,
        Err(error) => {
            console::warn(format_args!("superegg: {error:#}"));
            ExitCode::from(EXIT_USAGE)
        }
    }
}

/// Whether the reader of a pipe has closed it, which is not an error.
fn is_broken_pipe(error: &anyhow::Error) -> bool {
    error
        .chain()
        .filter_map(|cause| cause.downcast_ref::<std::io::Error>())
        .any(|cause| cause.kind() == std::io::ErrorKind::BrokenPipe)
}
