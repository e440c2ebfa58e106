//! `superegg export`: converts a scene for another program.

mod format;

use std::path::Path;

use anyhow::{Context, Result, anyhow};
use superegg_exchange::write::ems::{to_ems_npy, to_ems_text};
use superegg_exchange::write::flatten::{Instances, flatten};
use superegg_exchange::write::gltf::to_glb;
use superegg_exchange::write::grid::Grid;
use superegg_exchange::write::liggghts::{to_data_file, to_input_script};
use superegg_exchange::write::meshes::Tolerance;
use superegg_exchange::write::obj::to_obj;
use superegg_exchange::write::ply::{Precision, to_ply};
use superegg_exchange::write::povray;
use superegg_exchange::write::stl::to_stl;
use superegg_exchange::write::table::to_csv;
use superegg_exchange::write::vtp::to_vtp;
use superegg_exchange::write::written::Written;
use superegg_scene::Scene;

use self::format::ExportFormat;
use crate::args::ExportArgs;
use crate::console;
use crate::files;
use crate::files::scene::load;
use crate::inspect::framing::framed_root;
use crate::outcome::Outcome;

pub(crate) fn run(args: &ExportArgs) -> Result<Outcome> {
    let format = ExportFormat::of(&args.output)?;
    files::check_output(Some(&args.output), &args.scene)?;
    let loaded = load(&args.scene)?;
    loaded.print_diagnostics();
    let root = loaded.root_or_warn(args.root.object.as_deref())?;
    let root = root.ok_or_else(|| anyhow!("there is nothing to export"))?;
    let scene = loaded.session.scene();
    let depth = args.depth.unwrap_or(scene.depth);
    let size = (scene.picture.width, scene.picture.height);
    let framed = framed_root(scene, Some(&root), depth, size);
    let scene = framed.as_ref().unwrap_or(scene);
    let export = Export { scene, root: &root, depth, args };
    let written = export.written(format)?;
    if let Some(companion) = &written.companion {
        files::write(&companion_path(&args.output), companion)?;
    }
    files::write(&args.output, &written.bytes)?;
    for loss in &written.losses {
        console::warn(format_args!("{}: warning: {loss}", args.output.display()));
    }
    Ok(Outcome::of_input(loaded.has_errors()))
}

/// The file of materials beside an .obj file.
fn companion_path(output: &Path) -> std::path::PathBuf {
    output.with_extension("mtl")
}

/// What is exported.
struct Export<'a> {
    scene: &'a Scene,
    root: &'a str,
    depth: u32,
    args: &'a ExportArgs,
}

impl Export<'_> {
    fn written(&self, format: ExportFormat) -> Result<Written> {
        let (scene, tolerance) = (self.scene, self.tolerance());
        let precision = if self.args.double { Precision::Double } else { Precision::Single };
        Ok(match format {
            ExportFormat::PovRay => Written {
                bytes: povray::to_povray(scene, self.root, self.depth)?.into_bytes(),
                companion: None,
                losses: povray::losses(scene),
            },
            ExportFormat::Stl => to_stl(scene, &self.instances()?, tolerance)?,
            ExportFormat::Ply => to_ply(scene, &self.instances()?, tolerance, precision)?,
            ExportFormat::Obj => {
                let materials = companion_path(&self.args.output);
                let name = materials.file_name().and_then(|name| name.to_str());
                let name = name.context("the name of an .obj file must be valid UTF-8")?;
                to_obj(scene, &self.instances()?, tolerance, precision, name)?
            }
            ExportFormat::Glb => to_glb(scene, &self.instances()?, tolerance)?,
            ExportFormat::Vtp => to_vtp(scene, &self.instances()?),
            ExportFormat::LiggghtsScript => to_input_script(scene, &self.instances()?),
            ExportFormat::LiggghtsData => to_data_file(scene, &self.instances()?),
            ExportFormat::EmsText => to_ems_text(scene, &self.instances()?),
            ExportFormat::EmsNpy => to_ems_npy(scene, &self.instances()?),
            ExportFormat::Csv => to_csv(scene, &self.instances()?),
            ExportFormat::Nrrd => self.grid()?.to_nrrd(),
            ExportFormat::Vti => self.grid()?.to_vti(),
        })
    }

    fn instances(&self) -> Result<Instances> {
        Ok(flatten(self.scene, self.root, self.depth)?)
    }

    fn grid(&self) -> Result<Grid> {
        Ok(Grid::new(self.scene, &self.instances()?, self.args.value.into(), self.args.grid as usize)?)
    }

    fn tolerance(&self) -> Tolerance {
        let value = self.args.tolerance;
        if self.args.absolute { Tolerance::Absolute(value) } else { Tolerance::Relative(value) }
    }
}
