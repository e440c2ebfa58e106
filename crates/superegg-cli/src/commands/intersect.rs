//! `superegg intersect`: the first hit of each ray.

use anyhow::Result;
use superegg_geom::Ray;
use superegg_geom::glam::DVec3;
use superegg_lang::format_number;
use superegg_trace::CompiledScene;

use crate::args::IntersectArgs;
use crate::commands::input::load_compiled;
use crate::console;
use crate::files::answers::Answers;
use crate::files::csv::{RowFault, fields};
use crate::inspect::ray::{describe_camera_ray, first_hit};
use crate::outcome::Outcome;

const RAY_COLUMNS: [&str; 6] = ["ox", "oy", "oz", "dx", "dy", "dz"];
const HIT_COLUMNS: [&str; 10] = ["hit", "t", "px", "py", "pz", "nx", "ny", "nz", "leaving", "path"];

pub(crate) fn run(args: &IntersectArgs) -> Result<Outcome> {
    let (loaded, compiled) = load_compiled(&args.scene, &args.root, args.output.as_deref())?;
    let outcome = Outcome::of_input(loaded.has_errors());
    let Some(path) = args.rays.as_ref().or(args.ray_file.as_ref()) else {
        console::print(describe_camera_ray(&compiled, &loaded.session.scene().camera, args.fast))?;
        return Ok(outcome);
    };
    let answers = Answers {
        questions: RAY_COLUMNS,
        answers: HIT_COLUMNS.to_vec(),
        make: &ray_of_row,
        answer: &|ray| (hit_row(&compiled, ray, args.fast), None),
    };
    let is_right = answers.write(path, args.output.as_deref())?;
    Ok(if is_right { outcome } else { Outcome::ErrorsInInput })
}

/// The ray of a row. A zero direction is an error.
fn ray_of_row([ox, oy, oz, dx, dy, dz]: [f64; 6]) -> Result<Ray, RowFault> {
    let ray = Ray::new(DVec3::new(ox, oy, oz), DVec3::new(dx, dy, dz));
    if ray.direction == DVec3::ZERO {
        return Err((3, "the direction dx,dy,dz is 0,0,0, which leads nowhere".to_owned()));
    }
    Ok(ray)
}

/// The output row of a ray. A miss has 0 and empty fields.
fn hit_row(scene: &CompiledScene, ray: &Ray, fast: bool) -> Vec<String> {
    let Some(hit) = first_hit(scene, ray, fast) else {
        let mut row = vec![String::new(); HIT_COLUMNS.len()];
        row[0].push('0');
        return row;
    };
    let surface = scene.interaction(&hit);
    let mut row = vec!["1".to_owned(), format_number(hit.t)];
    row.extend(fields(&surface.position.to_array()));
    row.extend(fields(&surface.normal.to_array()));
    row.extend([u8::from(hit.leaving).to_string(), scene.path_name(&hit.path)]);
    row
}
