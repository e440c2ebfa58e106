//! `superegg sample`: points spread evenly over the surfaces of a scene.

use anyhow::{Context, Result, bail};
use rayon::prelude::*;
use superegg_exchange::points::{CloudPoint, to_npy, to_ply, to_xyz};
use superegg_trace::{CompiledScene, PointLimits, ScenePoint, SceneSurfaces};

use crate::args::SampleArgs;
use crate::commands::input::{MOST_INSTANCES, load_compiled, too_many_instances};
use crate::console;
use crate::files;
use crate::files::csv::{fields, path_field, write_rows};
use crate::outcome::Outcome;
use crate::text::counted;

/// The format of a point cloud.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum CloudFormat {
    Ply,
    Csv,
    Xyz,
    Npy,
}

pub(crate) fn run(args: &SampleArgs) -> Result<Outcome> {
    let format = format_of(args)?;
    files::check_output(Some(&args.output), &args.scene, args.overwrite.into())?;
    let (loaded, compiled) = load_compiled(&args.scene, &args.root)?;
    let surfaces =
        SceneSurfaces::of(&compiled, MOST_INSTANCES).with_context(|| too_many_instances(&compiled))?;
    let mut points = surfaces.sample(args.count as usize, args.seed);
    if points.is_empty() && args.count > 0 {
        bail!("the scene has no surface to sample");
    }
    let drawn = points.len();
    if args.union {
        let limits = PointLimits::default();
        points = points.into_par_iter().filter(|point| !surfaces.is_covered(point, &limits)).collect();
    }
    write(args, format, &compiled, &surfaces, &points)?;
    if !args.quiet && !files::is_standard_stream(&args.output) {
        let inside = if args.union {
            format!(" ({} inside other primitives left out)", drawn - points.len())
        } else {
            String::new()
        };
        console::print(format_args!(
            "{}: {} of {}{inside}, total area {:.9}",
            args.output.display(),
            counted(points.len(), "point"),
            counted(surfaces.instances().len(), "instance"),
            surfaces.total_area(),
        ))?;
    }
    Ok(Outcome::of_input(loaded.has_errors()))
}

/// The format that the end of the output's name stands for; CSV for standard output.
fn format_of(args: &SampleArgs) -> Result<CloudFormat> {
    if files::is_standard_stream(&args.output) {
        return Ok(CloudFormat::Csv);
    }
    let extension = args.output.extension().and_then(|extension| extension.to_str()).unwrap_or_default();
    match extension.to_ascii_lowercase().as_str() {
        "ply" => Ok(CloudFormat::Ply),
        "csv" => Ok(CloudFormat::Csv),
        "xyz" => Ok(CloudFormat::Xyz),
        "npy" => Ok(CloudFormat::Npy),
        _ => bail!(
            "'{}' names no format of point clouds; end it in .ply, .csv, .xyz or .npy",
            args.output.display()
        ),
    }
}

fn write(
    args: &SampleArgs,
    format: CloudFormat,
    scene: &CompiledScene,
    surfaces: &SceneSurfaces<'_>,
    points: &[ScenePoint],
) -> Result<()> {
    if format == CloudFormat::Csv {
        return write_csv(args, scene, surfaces, points);
    }
    let cloud: Vec<CloudPoint> = points
        .par_iter()
        .map(|point| CloudPoint {
            position: point.point.to_array(),
            normal: point.normal.to_array(),
            instance_id: scene.instance_id(&surfaces.instances()[point.instance].path),
        })
        .collect();
    let bytes = match format {
        CloudFormat::Ply => to_ply(&cloud),
        CloudFormat::Npy => to_npy(&cloud),
        CloudFormat::Xyz | CloudFormat::Csv => to_xyz(&cloud).into_bytes(),
    };
    files::write(&args.output, &bytes)
}

fn write_csv(
    args: &SampleArgs,
    scene: &CompiledScene,
    surfaces: &SceneSurfaces<'_>,
    points: &[ScenePoint],
) -> Result<()> {
    write_rows(Some(&args.output), |writer| {
        writer.write_record(["x", "y", "z", "nx", "ny", "nz", "instance_id", "path"])?;
        for point in points {
            let path = &surfaces.instances()[point.instance].path;
            let mut row: Vec<String> = fields(&point.point.to_array()).collect();
            row.extend(fields(&point.normal.to_array()));
            row.extend([scene.instance_id(path).to_string(), path_field(scene, path)]);
            writer.write_record(row)?;
        }
        Ok(())
    })
}
