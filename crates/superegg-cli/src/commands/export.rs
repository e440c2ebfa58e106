//! `superegg export`: a scene for another program.

use anyhow::{Result, anyhow, bail};
use superegg_exchange::povray::to_povray;
use superegg_scene::Scene;

use crate::args::ExportArgs;
use crate::commands::Outcome;
use crate::files;
use crate::load::load;

pub(crate) fn run(args: &ExportArgs) -> Result<Outcome> {
    let extension = args.output.extension().and_then(|extension| extension.to_str()).unwrap_or_default();
    if !extension.eq_ignore_ascii_case("pov") {
        bail!("'{}' names no format that can be written; end it in .pov (POV-Ray)", args.output.display());
    }
    files::check_writable_place(Some(&args.output), &args.scene)?;
    let loaded = load(&args.scene)?;
    loaded.print_diagnostics();
    let root = loaded.root_or_warn(args.root.object.as_deref())?;
    let scene: &Scene = loaded.session.scene();
    let root = root.ok_or_else(|| anyhow!("there is nothing to export"))?;
    let text = to_povray(scene, &root, args.depth.unwrap_or(scene.depth))?;
    files::write(&args.output, text.as_bytes())?;
    Ok(Outcome::of(&loaded))
}
