//! The program `superegg`: command-line arguments, files, console output and exit codes.
//!
//! [`run`] is the program. It is a library so that the Python package carries it, and so that
//! [`load`] reads there all that the program reads. No other crate of the workspace prints. Modules
//! use only modules that stand above them in this list.

mod console;
mod outcome;
mod progress;
mod system;
mod text;

pub mod denoise;

mod annotate;

mod files;
mod inspect;
mod long;

mod export;

mod args;

mod modeller;
mod prompt;

mod commands;

pub mod load;
pub mod save;

use std::ffi::OsString;

use superegg_lang::is_unseen;

use crate::args::{Args, ColorArg, Command};
use crate::outcome::{EXIT_ERRORS, EXIT_FINE, EXIT_USAGE, Outcome};

/// Runs the program with these arguments, of which the first is its name, and returns its exit code.
/// It takes over ctrl-c, and a second one ends the process.
pub fn run(args: impl IntoIterator<Item = OsString>) -> u8 {
    let args: Vec<OsString> = args.into_iter().collect();
    // Errors of the arguments have their colours, too.
    let color = ColorArg::among(&args);
    color.choose();
    let args = match Args::parse_with(color, &args) {
        Ok(args) => args,
        Err(error) => return refused(&error, &args),
    };
    let Some(command) = args.command else {
        return finish(commands::model::run(args.scene.as_deref(), args.course));
    };
    finish(match command {
        Command::Render(args) => commands::render::run(&args),
        Command::Animate(args) => commands::animate::run(&args),
        Command::Merge(args) => commands::merge::run(&args),
        Command::Intersect(args) => commands::intersect::run(&args),
        Command::Iotest(args) => commands::iotest::run(&args),
        Command::Import(args) => commands::import::run(&args),
        Command::Fit(args) => commands::fit::run(&args),
        Command::Sample(args) => commands::sample::run(&args),
        Command::Measure(args) => commands::measure::run(&args),
        Command::Info(args) => commands::info::run(&args),
        Command::Check(args) => commands::check::run(&args),
        Command::Bench(args) => commands::bench::run(&args),
        Command::Export(args) => commands::export::run(&args),
        Command::Run(args) => commands::run::run(&args),
        Command::View(args) => commands::view::run(&args),
        Command::Completions(args) => commands::install::print_completions(&args),
        Command::Man(args) => commands::install::write_man_pages(&args),
    })
}

/// Prints why arguments are refused, or the help that they ask for, and returns the exit code.
fn refused(error: &clap::Error, args: &[OsString]) -> u8 {
    // Without this check a misspelt command is taken for the name of a scene.
    let first = ColorArg::without(args).nth(1);
    let word = first.and_then(|word| word.clone().into_string().ok()).filter(|_| error.use_stderr());
    if let Some(error) = word.and_then(|word| args::unknown_command(&word)) {
        console::fail(error);
        return EXIT_USAGE;
    }
    if error.use_stderr() {
        // Names of files are among the arguments. One that could control the terminal costs the colours.
        let is_plain = |word: &OsString| !word.to_string_lossy().contains(is_unseen);
        if args.iter().all(is_plain) {
            // There is no other output to report a failure on.
            let _ = error.print();
        } else {
            console::warn(error.render().to_string().trim_end());
        }
        return error.exit_code().try_into().unwrap_or(EXIT_USAGE);
    }
    finish(console::print_styled(error.render().ansi()).map(|()| Outcome::Fine))
}

/// The exit code of a command; prints its error.
fn finish(result: anyhow::Result<Outcome>) -> u8 {
    match result {
        Ok(Outcome::Fine) => EXIT_FINE,
        Ok(Outcome::ErrorsInInput) => EXIT_ERRORS,
        Ok(Outcome::Stopped(code)) => code,
        Err(error) if is_broken_pipe(&error) => EXIT_FINE,
        Err(error) => {
            console::fail(format_args!("{error:#}"));
            EXIT_USAGE
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
