//! `superegg export`: converts a scene for another program.

use anyhow::{Result, anyhow};
use superegg_exchange::write::export::ExportOptions;
use superegg_exchange::write::meshes::Tolerance;
use superegg_exchange::write::ply::Precision;

use crate::args::ExportArgs;
use crate::console;
use crate::export::{Export, export_targets};
use crate::files;
use crate::files::scene::load;
use crate::outcome::Outcome;

pub(crate) fn run(args: &ExportArgs) -> Result<Outcome> {
    for target in export_targets(&args.output)? {
        files::check_output(Some(&target), &args.scene, args.overwrite.into())?;
    }
    let loaded = load(&args.scene)?;
    loaded.print_diagnostics();
    let root = loaded.root_or_warn(args.root.object.as_deref())?;
    let root = root.ok_or_else(|| anyhow!("there is nothing to export"))?;
    let scene = loaded.session.scene();
    let exported = Export { scene, root: &root, output: &args.output, options: options(args) }.write()?;
    if let Some(note) = &exported.note {
        console::warn(format_args!("superegg: {note}"));
    }
    for loss in &exported.losses {
        console::warn(format_args!("{}: warning: {loss}", args.output.display()));
    }
    Ok(Outcome::of_input(loaded.has_errors()))
}

fn options(args: &ExportArgs) -> ExportOptions {
    let tolerance =
        if args.absolute { Tolerance::Absolute(args.tolerance) } else { Tolerance::Relative(args.tolerance) };
    ExportOptions {
        depth: args.depth,
        tolerance,
        precision: if args.double { Precision::Double } else { Precision::Single },
        grid: args.grid.into(),
        value: args.value.into(),
        ..ExportOptions::default()
    }
}
