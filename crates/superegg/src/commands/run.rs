//! `superegg run`: a file of commands as a session.

use anyhow::Result;

use crate::args::RunArgs;
use crate::commands::Outcome;
use crate::load::{Mode, load};

pub(crate) fn run(args: &RunArgs) -> Result<Outcome> {
    let loaded = load(&args.file, Mode::Session)?;
    loaded.print_diagnostics();
    Ok(Outcome::of(&loaded))
}
