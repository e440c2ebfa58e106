//! `superegg info`: the contents of a scene, or how a picture was made.

use anyhow::{Result, bail};

use crate::args::InfoArgs;
use crate::console;
use crate::files::notes::described;
use crate::files::scene::load;
use crate::outcome::Outcome;

pub(crate) fn run(args: &InfoArgs) -> Result<Outcome> {
    if let Some(text) = described(&args.scene)? {
        console::print(text.trim_end())?;
        return Ok(Outcome::Fine);
    }
    let loaded = load(&args.scene)?;
    loaded.print_diagnostics();
    match loaded.session.describe(&args.names) {
        Ok(text) => console::print(text)?,
        Err(fault) => bail!("{}; {}", fault.message, fault.help.unwrap_or_default()),
    }
    Ok(Outcome::of_input(loaded.has_errors()))
}
