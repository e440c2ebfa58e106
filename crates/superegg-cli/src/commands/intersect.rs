//! `superegg intersect`: the first hit of each ray.

use anyhow::{Result, anyhow};
use superegg_geom::Ray;
use superegg_geom::glam::DVec3;
use superegg_lang::format_number;
use superegg_trace::{CompiledScene, LimitReached, RayLimits};

use crate::args::IntersectArgs;
use crate::commands::input::load_compiled;
use crate::console;
use crate::files;
use crate::files::answers::Answers;
use crate::files::csv::{RowFault, fields, path_field};
use crate::inspect::ray::{RayMethod, describe_camera_ray, first_hit};
use crate::outcome::Outcome;

const RAY_COLUMNS: [&str; 6] = ["ox", "oy", "oz", "dx", "dy", "dz"];
const HIT_COLUMNS: [&str; 10] = ["hit", "t", "px", "py", "pz", "nx", "ny", "nz", "leaving", "path"];

pub(crate) fn run(args: &IntersectArgs) -> Result<Outcome> {
    files::check_output(args.output.as_deref(), &args.scene, args.overwrite.into())?;
    let (loaded, compiled) = load_compiled(&args.scene, &args.root)?;
    let outcome = Outcome::of_input(loaded.has_errors());
    let limits = args.limit.map_or_else(RayLimits::default, |boxes| RayLimits::default().with_boxes(boxes));
    let method = if args.fast { RayMethod::Fast } else { RayMethod::Exact(limits) };
    let Some(path) = args.rays.as_ref().or(args.ray_file.as_ref()) else {
        let camera = &loaded.session.scene().camera;
        console::print(describe_camera_ray(&compiled, camera, method).map_err(with_limit)?)?;
        return Ok(outcome);
    };
    let answers = Answers {
        questions: RAY_COLUMNS,
        answers: HIT_COLUMNS.to_vec(),
        make: &ray_of_row,
        answer: &|ray| hit_row(&compiled, ray, method).map_err(|error| (0, with_limit(error).to_string())),
    };
    let is_right = answers.write(path, args.output.as_deref())?;
    Ok(if is_right { outcome } else { Outcome::ErrorsInInput })
}

/// The ray of a row. A zero direction is an error.
fn ray_of_row([ox, oy, oz, dx, dy, dz]: [f64; 6]) -> Result<Ray, RowFault> {
    let ray = Ray::new(DVec3::new(ox, oy, oz), DVec3::new(dx, dy, dz));
    if ray.direction == DVec3::ZERO {
        return Err((3, "the direction dx,dy,dz is 0,0,0, which has no length".to_owned()));
    }
    Ok(ray)
}

/// The error of a ray, with the flag that allows more work.
fn with_limit(error: LimitReached) -> anyhow::Error {
    anyhow!("{error}; --limit BOXES allows more")
}

/// The output row of a ray. A miss has 0 and empty fields.
fn hit_row(scene: &CompiledScene, ray: &Ray, method: RayMethod) -> Result<Vec<String>, LimitReached> {
    let Some(hit) = first_hit(scene, ray, method)? else {
        let mut row = vec![String::new(); HIT_COLUMNS.len()];
        row[0].push('0');
        return Ok(row);
    };
    let surface = scene.interaction(&hit);
    let mut row = vec!["1".to_owned(), format_number(hit.t)];
    row.extend(fields(&surface.position.to_array()));
    row.extend(fields(&surface.normal.to_array()));
    row.extend([u8::from(hit.leaving).to_string(), path_field(scene, &hit.path)]);
    Ok(row)
}
