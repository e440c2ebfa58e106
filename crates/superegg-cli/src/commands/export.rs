//! `superegg export`: converts a scene for another program.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, anyhow};
use superegg_exchange::write::export::{ExportFormat, ExportOptions, export};
use superegg_exchange::write::meshes::Tolerance;
use superegg_exchange::write::ply::Precision;

use crate::args::ExportArgs;
use crate::console;
use crate::files;
use crate::files::scene::load;
use crate::inspect::framing::framed_root;
use crate::outcome::Outcome;

pub(crate) fn run(args: &ExportArgs) -> Result<Outcome> {
    let format = ExportFormat::of(&args.output)?;
    files::check_output(Some(&args.output), &args.scene, args.overwrite.into())?;
    let loaded = load(&args.scene)?;
    loaded.print_diagnostics();
    let root = loaded.root_or_warn(args.root.object.as_deref())?;
    let root = root.ok_or_else(|| anyhow!("there is nothing to export"))?;
    let scene = loaded.session.scene();
    let depth = args.depth.unwrap_or(scene.depth);
    let size = (scene.picture.width, scene.picture.height);
    let framed = framed_root(scene, Some(&root), depth, size);
    let scene = framed.as_ref().unwrap_or(scene);
    let written = export(scene, &root, format, &options(args, format, depth)?)?;
    if let Some(companion) = &written.companion {
        let path = companion_path(&args.output);
        files::check_output(Some(&path), &args.scene, args.overwrite.into())?;
        files::write(&path, companion)?;
    }
    files::write(&args.output, &written.bytes)?;
    for loss in &written.losses {
        console::warn(format_args!("{}: warning: {loss}", args.output.display()));
    }
    Ok(Outcome::of_input(loaded.has_errors()))
}

/// The file of materials beside an .obj file.
fn companion_path(output: &Path) -> PathBuf {
    output.with_extension("mtl")
}

fn options(args: &ExportArgs, format: ExportFormat, depth: u32) -> Result<ExportOptions> {
    let materials = companion_path(&args.output);
    let materials = materials.file_name().and_then(|name| name.to_str());
    if format == ExportFormat::Obj {
        materials.context("the name of an .obj file must be valid UTF-8")?;
    }
    let tolerance =
        if args.absolute { Tolerance::Absolute(args.tolerance) } else { Tolerance::Relative(args.tolerance) };
    Ok(ExportOptions {
        depth: Some(depth),
        tolerance,
        precision: if args.double { Precision::Double } else { Precision::Single },
        grid: args.grid.into(),
        value: args.value.into(),
        materials: materials.unwrap_or_default().to_owned(),
    })
}
