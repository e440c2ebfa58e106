//! The subcommands, one file each.

pub(crate) mod animate;
pub(crate) mod bench;
pub(crate) mod check;
pub(crate) mod export;
pub(crate) mod info;
pub(crate) mod intersect;
pub(crate) mod iotest;
mod made_scene;
pub(crate) mod merge;
pub(crate) mod model;
pub(crate) mod render;
pub(crate) mod run;
pub(crate) mod view;

use std::io::{self, Write};
use std::path::Path;

use anyhow::{Context, Result};
use indicatif::{HumanCount, ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle};
use superegg_trace::CompiledScene;

use crate::args::RootArgs;
use crate::files;
use crate::load::{Loaded, load};

/// How a command ended, when it ended by itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Outcome {
    /// All well.
    Fine,
    /// The input had errors; they have been told.
    ErrorsInInput,
    /// It was asked to stop, and did in good order; this is its exit code.
    Stopped(u8),
}

impl Outcome {
    fn of(loaded: &Loaded) -> Self {
        if loaded.has_errors() { Self::ErrorsInInput } else { Self::Fine }
    }
}

/// A scene as the commands that only ask it take it, with its diagnostics told; the place of the answers is looked at first.
fn load_compiled(scene: &Path, root: &RootArgs, output: Option<&Path>) -> Result<(Loaded, CompiledScene)> {
    files::check_writable_place(output, scene)?;
    let loaded = load(scene)?;
    loaded.print_diagnostics();
    let root = loaded.root_or_warn(root.object.as_deref())?;
    let described = loaded.session.scene();
    let compiled = CompiledScene::compile(described, root.as_deref(), described.depth);
    Ok((loaded, compiled))
}

/// Rows of CSV to a file, whole or not at all, or to standard output as they come.
fn write_csv(
    output: Option<&Path>,
    rows: impl FnOnce(&mut csv::Writer<&mut dyn Write>) -> csv::Result<()>,
) -> Result<()> {
    let to_file = output.filter(|path| !files::is_standard_stream(path));
    let mut buffer = Vec::new();
    let mut stdout = io::stdout().lock();
    let sink: &mut dyn Write = if to_file.is_some() { &mut buffer } else { &mut stdout };
    let mut writer = csv::Writer::from_writer(sink);
    rows(&mut writer).map_err(io_error).context("cannot write the answers")?;
    writer.flush().context("cannot write the answers")?;
    drop(writer);
    to_file.map_or(Ok(()), |path| files::write(path, &buffer))
}

/// The error below one of CSV, its kind kept: a closed pipe is to be known as one.
fn io_error(error: csv::Error) -> io::Error {
    match error.into_kind() {
        csv::ErrorKind::Io(error) => error,
        other => io::Error::other(format!("{other:?}")),
    }
}

/// Threads to render with where nobody says.
pub(crate) fn available_threads() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}

/// "1 error", "2 errors".
pub(crate) fn counted(count: impl std::fmt::Display, noun: &str) -> String {
    let count = count.to_string();
    let plural = if count == "1" { "" } else { "s" };
    format!("{count} {noun}{plural}")
}

/// A bar of pixels on standard error, with `detail` before the times; hidden where that is no terminal.
pub(crate) fn progress_bar(pixels: u64, quiet: bool, detail: &str) -> ProgressBar {
    let target = if quiet { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr() };
    let template = format!("{{bar:40}} {{percent:>3}} %  {detail}, {{elapsed}} gone, {{eta}} to go");
    let style = ProgressStyle::with_template(&template);
    ProgressBar::with_draw_target(Some(pixels), target)
        .with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()).with_key("rate", rate))
}

/// "12,300 pixels a second", to three figures.
fn rate(state: &ProgressState, out: &mut dyn std::fmt::Write) {
    let rate = state.per_sec();
    let step = 10f64.powf((rate.max(1.0).log10().floor() - 2.0).max(0.0));
    let rounded = ((rate / step).round() * step) as u64;
    // A terminal that cannot be written to shows no bar.
    let _ = write!(out, "{} pixels a second", HumanCount(rounded));
}
