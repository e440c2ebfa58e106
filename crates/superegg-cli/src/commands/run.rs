//! `superegg run`: runs a file of commands as a session.

use std::io::{BufRead, BufReader};

use anyhow::{Context, Result, bail};

use crate::args::RunArgs;
use crate::commands::model::run_lines;
use crate::files;
use crate::modeller::Input;
use crate::outcome::Outcome;

pub(crate) fn run(args: &RunArgs) -> Result<Outcome> {
    if files::is_standard_stream(&args.file) {
        let source = Input::Lines { name: "-".to_owned(), is_file: false };
        return run_lines(&mut std::io::stdin().lock(), source, None, false);
    }
    let cannot_read = || format!("cannot read '{}'", args.file.display());
    files::check_plain_file(&args.file)?;
    if args.file.is_dir() {
        bail!("{}: it is a folder", cannot_read());
    }
    let file = std::fs::File::open(&args.file).with_context(cannot_read)?;
    let lines: &mut dyn BufRead = &mut BufReader::new(file);
    let source = Input::Lines { name: args.file.display().to_string(), is_file: true };
    run_lines(lines, source, None, false)
}
