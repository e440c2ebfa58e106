//! `superegg export`: converts a scene for another program.

use anyhow::{Result, anyhow, bail};
use superegg_exchange::povray::to_povray;

use crate::args::ExportArgs;
use crate::files;
use crate::files::scene::load;
use crate::inspect::framing::framed_root;
use crate::outcome::Outcome;

pub(crate) fn run(args: &ExportArgs) -> Result<Outcome> {
    let extension = args.output.extension().and_then(|extension| extension.to_str()).unwrap_or_default();
    if !extension.eq_ignore_ascii_case("pov") {
        bail!("'{}' names no format that can be written; end it in .pov (POV-Ray)", args.output.display());
    }
    files::check_output(Some(&args.output), &args.scene)?;
    let loaded = load(&args.scene)?;
    loaded.print_diagnostics();
    let root = loaded.root_or_warn(args.root.object.as_deref())?;
    let root = root.ok_or_else(|| anyhow!("there is nothing to export"))?;
    let scene = loaded.session.scene();
    let depth = args.depth.unwrap_or(scene.depth);
    let size = (scene.picture.width, scene.picture.height);
    let framed = framed_root(scene, Some(&root), depth, size);
    let text = to_povray(framed.as_ref().unwrap_or(scene), &root, depth)?;
    files::write(&args.output, text.as_bytes())?;
    Ok(Outcome::of_input(loaded.has_errors()))
}
