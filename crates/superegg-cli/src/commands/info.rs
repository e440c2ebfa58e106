//! `superegg info`: the contents of a scene.

use anyhow::{Result, bail};

use crate::args::InfoArgs;
use crate::console;
use crate::files::scene::load;
use crate::outcome::Outcome;

pub(crate) fn run(args: &InfoArgs) -> Result<Outcome> {
    let loaded = load(&args.scene)?;
    loaded.print_diagnostics();
    match loaded.session.describe(&args.names) {
        Ok(text) => console::print(text)?,
        Err(fault) => bail!("{}; {}", fault.message, fault.help.unwrap_or_default()),
    }
    Ok(Outcome::of_input(loaded.has_errors()))
}
