//! `superegg iotest`: inside-outside tests of points.

use anyhow::Result;
use superegg_geom::glam::DVec3;
use superegg_lang::format_number;
use superegg_trace::CompiledScene;

use crate::args::IotestArgs;
use crate::commands::input::load_compiled;
use crate::console;
use crate::files::csv::{fields, read_rows, write_rows};
use crate::inspect::grid::Grid;
use crate::outcome::Outcome;

const POINT_COLUMNS: [&str; 3] = ["x", "y", "z"];
const RESULT_COLUMNS: [&str; 6] = ["x", "y", "z", "inside", "value", "path"];

pub(crate) fn run(args: &IotestArgs) -> Result<Outcome> {
    let grid = Grid::new(args.step, args.extent)?;
    let (loaded, compiled) = load_compiled(&args.scene, &args.root, args.output.as_deref())?;
    let points: Box<dyn Iterator<Item = DVec3>> = match &args.points {
        None => Box::new(grid.points()),
        Some(path) => match read_rows(path, POINT_COLUMNS, |row| Ok(DVec3::from_array(row)))? {
            Ok(points) => Box::new(points.into_iter()),
            Err(errors) => {
                errors.iter().for_each(console::warn);
                return Ok(Outcome::ErrorsInInput);
            }
        },
    };
    write_rows(args.output.as_deref(), |writer| {
        writer.write_record(RESULT_COLUMNS)?;
        points.into_iter().try_for_each(|point| writer.write_record(result_row(&compiled, point)))
    })?;
    Ok(Outcome::of_input(loaded.has_errors()))
}

/// The output row of a point. A point in no bounding box has an empty value and path.
fn result_row(scene: &CompiledScene, point: DVec3) -> Vec<String> {
    let answer = scene.query_point(point);
    let mut row: Vec<String> = fields(&point.to_array()).collect();
    row.push(u8::from(answer.inside).to_string());
    row.extend(match answer.least {
        Some((value, path)) => [format_number(value), scene.path_name(&path)],
        None => [String::new(), String::new()],
    });
    row
}
