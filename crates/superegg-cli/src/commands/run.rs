//! `superegg run`: runs a file of commands as a session.

use std::io::{BufRead, BufReader};

use anyhow::{Context, Result, bail};

use crate::args::RunArgs;
use crate::commands::model::run_lines;
use crate::files;
use crate::outcome::Outcome;

pub(crate) fn run(args: &RunArgs) -> Result<Outcome> {
    if files::is_standard_stream(&args.file) {
        return run_lines(&mut std::io::stdin().lock(), "-", None, false);
    }
    let cannot_read = || format!("cannot read '{}'", args.file.display());
    if args.file.is_dir() {
        bail!("{}: it is a folder", cannot_read());
    }
    let file = std::fs::File::open(&args.file).with_context(cannot_read)?;
    let lines: &mut dyn BufRead = &mut BufReader::new(file);
    run_lines(lines, &args.file.display().to_string(), None, false)
}
