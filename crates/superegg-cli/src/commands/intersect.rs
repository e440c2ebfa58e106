//! `superegg intersect`: where rays first cross a surface.

use anyhow::Result;
use superegg_geom::Ray;
use superegg_geom::glam::{DVec2, DVec3};
use superegg_lang::format_number;
use superegg_render::View;
use superegg_scene::Camera;
use superegg_trace::{CompiledScene, Hit};

use crate::args::IntersectArgs;
use crate::commands::{Outcome, load_compiled, write_csv};
use crate::csv_input::{RowFault, fields, read_rows};
use crate::say;

const RAY_COLUMNS: [&str; 6] = ["ox", "oy", "oz", "dx", "dy", "dz"];
const ANSWER_COLUMNS: [&str; 10] = ["hit", "t", "px", "py", "pz", "nx", "ny", "nz", "leaving", "path"];

pub(crate) fn run(args: &IntersectArgs) -> Result<Outcome> {
    let (loaded, compiled) = load_compiled(&args.scene, &args.root, args.output.as_deref())?;
    let Some(path) = &args.rays else {
        say::out(tell_camera_ray(&compiled, &loaded.session.scene().camera, args.fast))?;
        return Ok(Outcome::of(&loaded));
    };
    match read_rows(path, RAY_COLUMNS, ray_of_row)? {
        Ok(rays) => {
            write_csv(args.output.as_deref(), |writer| {
                writer.write_record(ANSWER_COLUMNS)?;
                rays.iter().try_for_each(|ray| writer.write_record(answer(&compiled, ray, args.fast)))
            })?;
            Ok(Outcome::of(&loaded))
        }
        Err(complaints) => {
            complaints.iter().for_each(say::complain);
            Ok(Outcome::ErrorsInInput)
        }
    }
}

/// A row as a ray; a direction of no length is an error.
fn ray_of_row([ox, oy, oz, dx, dy, dz]: [f64; 6]) -> Result<Ray, RowFault> {
    let ray = Ray::new(DVec3::new(ox, oy, oz), DVec3::new(dx, dy, dz));
    if ray.direction == DVec3::ZERO {
        return Err((3, "the direction dx,dy,dz is 0,0,0, which leads nowhere".to_owned()));
    }
    Ok(ray)
}

fn intersect(scene: &CompiledScene, ray: &Ray, fast: bool) -> Option<Hit> {
    if fast { scene.intersect_fast(ray) } else { scene.intersect(ray, None) }
}

/// The columns of one answer.
fn answer(scene: &CompiledScene, ray: &Ray, fast: bool) -> Vec<String> {
    let Some(hit) = intersect(scene, ray, fast) else {
        return std::iter::once("0".to_owned())
            .chain((1..ANSWER_COLUMNS.len()).map(|_| String::new()))
            .collect();
    };
    let surface = scene.interaction(&hit);
    let mut columns = vec!["1".to_owned(), format_number(hit.t)];
    columns.extend(fields(&surface.position.to_array()));
    columns.extend(fields(&surface.normal.to_array()));
    columns.extend([u8::from(hit.leaving).to_string(), scene.path_name(&hit.path)]);
    columns
}

/// The ray of the course's intersection test, in words: from the camera along the direction it looks in, with a unit direction.
pub(crate) fn tell_camera_ray(scene: &CompiledScene, camera: &Camera, fast: bool) -> String {
    let middle = View::new(camera, 2, 2).ray(DVec2::ONE);
    let ray = Ray::new(middle.origin, middle.direction.normalize());
    let from = format!("the ray from the camera at {} along {}", told(ray.origin), told(ray.direction));
    format!("{from}\n{}", tell_hit(scene, intersect(scene, &ray, fast).as_ref()))
}

/// Where a ray first meets a surface, in words.
pub(crate) fn tell_hit(scene: &CompiledScene, hit: Option<&Hit>) -> String {
    let Some(hit) = hit else { return "meets nothing".to_owned() };
    let surface = scene.interaction(hit);
    let verb = if hit.leaving { "leaves" } else { "meets" };
    format!(
        "{verb} {}\nat t = {}\nin the point {}\nwhere the normal is {}",
        scene.path_name(&hit.path),
        format_number(hit.t),
        told(surface.position),
        told(surface.normal)
    )
}

fn told(v: DVec3) -> String {
    fields(&v.to_array()).collect::<Vec<_>>().join(" ")
}
