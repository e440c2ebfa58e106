//! `superegg fit`: superquadrics from points of their surfaces.

mod report;

use std::path::Path;
use std::sync::atomic::Ordering;

use anyhow::{Context, Result, anyhow, ensure};
use superegg_exchange::read::{
    Format, Input, MeshSampling, Particles, ReadError, ReadOptions, SurfacePoints, read_surface_points,
};
use superegg_exchange::write::convention::Convention;
use superegg_fit::{Fit, FitOptions, PartCount, PartsProgress, fit, fit_parts_while};
use superegg_geom::glam::{DQuat, DVec3};
use superegg_lang::write_session;

use crate::args::FitArgs;
use crate::console;
use crate::files;
use crate::files::binary_scene;
use crate::files::csv::{fields, write_rows};
use crate::files::data::{head_of, is_scene, open_data, scene_of_particles};
use crate::outcome::Outcome;
use crate::progress::spinner;
use crate::system::interrupt::Interrupt;
use crate::text::visible_json;
use report::{Explained, Report};

/// The points that stand for a mesh.
const MESH_POINTS: usize = 20_000;
/// The linear colours of shapes, one after the other, of points and of outliers.
const SHAPE_COLORS: [[f32; 3]; 6] = [
    [0.95, 0.45, 0.1],
    [0.1, 0.4, 0.8],
    [0.2, 0.65, 0.25],
    [0.75, 0.65, 0.1],
    [0.55, 0.25, 0.7],
    [0.1, 0.6, 0.65],
];
const POINT_COLOR: [f32; 3] = [0.25, 0.3, 0.4];
const OUTLIER_COLOR: [f32; 3] = [0.8, 0.03, 0.05];
/// The radius of a point in the scene, as a part of the largest semi-axis.
const POINT_RADIUS: f64 = 0.015;

pub(crate) fn run(args: &FitArgs) -> Result<Outcome> {
    for output in [&args.output, &args.residuals].into_iter().flatten() {
        files::check_output(Some(output), &args.cloud, args.overwrite.into())?;
    }
    let is_stream =
        |file: &Option<std::path::PathBuf>| file.as_deref().is_some_and(files::is_standard_stream);
    let streams = [is_stream(&args.output), is_stream(&args.residuals), args.json];
    ensure!(
        streams.iter().filter(|is_one| **is_one).count() < 2,
        "only one of --output -, --residuals - and --json can write to standard output"
    );
    let cloud = read_cloud(args)?;
    let interrupt = (args.count != PartCount::Exactly(1)).then(Interrupt::listen).transpose()?;
    if !args.quiet {
        console::warn(format_args!("superegg: {}: {}", args.cloud.display(), cloud.reading));
    }
    let Fitted { fits, stopped } = fitted(args, &cloud.points, interrupt.as_ref())?;
    let explained = Explained::of(&fits, &cloud.points);
    let convention = args.convention.as_deref().and_then(Convention::by_name);
    let report = Report { fits: &fits, points: &cloud.points, explained: &explained, convention };
    for warning in report.warnings() {
        console::warn(format_args!("superegg: warning: {warning}"));
    }
    if let Some(output) = &args.output {
        write_scene(args, output, &report)?;
    }
    if let Some(file) = &args.residuals {
        write_residuals(file, &report)?;
    }
    if args.json {
        let json = if args.count == PartCount::Exactly(1) { report.json_of_one() } else { report.json() };
        console::print_raw(visible_json(&serde_json::to_string_pretty(&json)?))?;
    } else if !args.quiet && !streams.contains(&true) {
        console::print(report.text())?;
        if let Some(output) = &args.output {
            console::print(format_args!("{}: written", output.display()))?;
        }
    }
    Ok(stopped.map_or(Outcome::Fine, Outcome::Stopped))
}

/// The shapes that were found, and the exit code if a signal stopped the search.
struct Fitted {
    fits: Vec<Fit>,
    stopped: Option<u8>,
}

fn read_cloud(args: &FitArgs) -> Result<SurfacePoints> {
    let options = ReadOptions {
        from: args.from.as_deref().and_then(Format::by_name),
        columns: args.columns.clone(),
        ..ReadOptions::default()
    };
    let mut input = open_data(&args.cloud)?;
    let sampling = MeshSampling { count: MESH_POINTS, seed: args.seed };
    let read = read_surface_points(&mut *input, &options, sampling);
    read.map_err(|error| explained(error, &mut *input))
        .with_context(|| format!("cannot read '{}'", args.cloud.display()))
}

/// The error for a file that is not recognized; that for a scene names the command that samples it.
fn explained(error: ReadError, input: &mut dyn Input) -> anyhow::Error {
    match (&error, head_of(input)) {
        (ReadError::Unrecognized, Ok(head)) if is_scene(&head) => {
            anyhow!("this is a scene of superegg, not points; 'superegg sample' gives points of its surfaces")
        }
        _ => error.into(),
    }
}

fn fitted(args: &FitArgs, points: &[DVec3], interrupt: Option<&Interrupt>) -> Result<Fitted> {
    let options = FitOptions {
        seed: args.seed,
        outliers: args.outliers,
        exponents: args.exponents.as_slice().try_into().unwrap_or(FitOptions::default().exponents),
        most_points: args.points as usize,
    };
    let found = match interrupt {
        None => {
            let fits = fit(points, &options).map(|one| vec![one]);
            fits.map(|fits| Fitted { fits, stopped: None })
        }
        Some(interrupt) => {
            let progress = spinner(args.quiet);
            let mut goes_on = |at: PartsProgress| {
                let parts = if at.parts == 0 { String::new() } else { format!(", {} shapes", at.parts) };
                progress.set_message(format!("{} fits{parts}", at.fits));
                progress.tick();
                !interrupt.flag().load(Ordering::Relaxed)
            };
            let fits = fit_parts_while(points, &options, args.count, &mut goes_on);
            progress.finish_and_clear();
            interrupt.work_ended();
            let is_stopped = interrupt.flag().load(Ordering::Relaxed);
            if is_stopped {
                console::warn("superegg: stopped; the shapes are those found so far");
            }
            fits.map(|fits| Fitted { fits, stopped: is_stopped.then(|| interrupt.exit_code()) })
        }
    };
    let found = found.with_context(|| format!("cannot fit a shape to '{}'", args.cloud.display()))?;
    ensure!(!found.fits.is_empty(), "no part of '{}' has enough points for a shape", args.cloud.display());
    Ok(found)
}

fn write_scene(args: &FitArgs, output: &Path, report: &Report<'_>) -> Result<()> {
    let mut shapes = Particles::default();
    for Fit { shape, rotation, center, .. } in report.fits {
        let exponents = [shape.exponents().e(), shape.exponents().n()];
        shapes.push(*center, shape.radii(), exponents, *rotation);
    }
    shapes.colors = SHAPE_COLORS.into_iter().cycle().take(report.fits.len()).collect();
    let mut parts = vec![("fit", shapes)];
    if args.with_cloud {
        let largest = report.fits.iter().map(|fit| fit.shape.radii().max_element()).fold(0.0, f64::max);
        let mut cloud = Particles::default();
        for point in report.points {
            cloud.push(*point, DVec3::splat(POINT_RADIUS * largest), [1.0, 1.0], DQuat::IDENTITY);
        }
        let color = |shape: &Option<usize>| if shape.is_none() { OUTLIER_COLOR } else { POINT_COLOR };
        cloud.colors = report.explained.shape_of.iter().map(color).collect();
        parts.push(("cloud", cloud));
    }
    let session = scene_of_particles(parts)?;
    if binary_scene::has_extension(output) {
        binary_scene::write(output, session.scene(), session.selected())
    } else {
        files::write(output, write_session(&session).as_bytes())
    }
}

/// Writes a row for each point: its distance from its shape or the nearest one, the probability that it is
/// of that, and the number of the shape from 1, 0 for outliers.
fn write_residuals(file: &Path, report: &Report<'_>) -> Result<()> {
    let Explained { distances, inliers, shape_of } = report.explained;
    write_rows(Some(file), |writer| {
        writer.write_record(["x", "y", "z", "distance", "inlier", "shape"])?;
        for (index, point) in report.points.iter().enumerate() {
            let [x, y, z] = point.to_array();
            let shape = shape_of[index].map_or(0, |shape| shape + 1);
            let numbers = [x, y, z, distances[index], inliers[index]];
            writer.write_record(fields(&numbers).chain([shape.to_string()]))?;
        }
        Ok(())
    })
}
