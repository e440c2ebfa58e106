//! The command `superegg`: arguments, files, printing, exit codes. The only crate that prints.

mod args;
mod commands;
mod csv_input;
mod files;
mod load;
mod memory;
mod say;

use std::process::ExitCode;

use clap::Parser;

use crate::args::{Args, Command};
use crate::commands::Outcome;

/// Wrong usage, or a file that cannot be read or written.
const EXIT_USAGE: u8 = 2;

fn main() -> ExitCode {
    let outcome = match Args::parse().command {
        Command::Render(args) => commands::render::run(&args),
        Command::Intersect(args) => commands::intersect::run(&args),
        Command::Iotest(args) => commands::iotest::run(&args),
        Command::Info(args) => commands::info::run(&args),
        Command::Check(args) => commands::check::run(&args),
        Command::Bench(args) => commands::bench::run(&args),
        Command::Export(args) => commands::export::run(&args),
        Command::Run(args) => commands::run::run(&args),
    };
    match outcome {
        Ok(Outcome::Fine) => ExitCode::SUCCESS,
        Ok(Outcome::ErrorsInInput) => ExitCode::from(1),
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
