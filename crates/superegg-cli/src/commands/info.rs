//! `superegg info`: what a scene has.

use anyhow::{Result, bail};

use crate::args::InfoArgs;
use crate::commands::Outcome;
use crate::load::load;
use crate::say;

pub(crate) fn run(args: &InfoArgs) -> Result<Outcome> {
    let loaded = load(&args.scene)?;
    loaded.print_diagnostics();
    match loaded.session.describe(&args.names) {
        Ok(text) => say::out(text)?,
        Err(fault) => bail!("{}; {}", fault.message, fault.help.unwrap_or_default()),
    }
    Ok(Outcome::of(&loaded))
}
