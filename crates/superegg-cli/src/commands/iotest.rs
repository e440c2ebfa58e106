//! `superegg iotest`: inside-outside tests of points.

use anyhow::Result;
use rayon::prelude::*;
use superegg_geom::glam::DVec3;
use superegg_lang::format_number;
use superegg_trace::{CompiledScene, PointLimits};

use crate::args::IotestArgs;
use crate::commands::input::load_compiled;
use crate::console;
use crate::files::answers::Answers;
use crate::files::csv::{fields, write_rows};
use crate::inspect::grid::Grid;
use crate::outcome::Outcome;

const POINT_COLUMNS: [&str; 3] = ["x", "y", "z"];
const RESULT_COLUMNS: [&str; 6] = ["x", "y", "z", "inside", "value", "path"];
const ALL_COLUMNS: [&str; 2] = ["holders", "holder_paths"];
const DISTANCE_COLUMNS: [&str; 3] = ["distance", "distance_error", "distance_path"];

/// The most primitives that are listed for one point.
const MOST_HOLDERS: usize = 1000;
/// The points of the grid that are tested at a time, on all cores.
const CHUNK: usize = 1 << 13;

pub(crate) fn run(args: &IotestArgs) -> Result<Outcome> {
    let grid = Grid::new(args.step, args.extent)?;
    let (loaded, compiled) = load_compiled(&args.scene, &args.root, args.output.as_deref())?;
    let test = PointTest { scene: &compiled, all: args.all, distance: args.distance };
    let mut outcome = Outcome::of_input(loaded.has_errors());
    match args.points.as_ref().or(args.point_file.as_ref()) {
        None => test.write_grid(grid, args)?,
        Some(path) => {
            let answers = Answers {
                questions: POINT_COLUMNS,
                answers: test.columns(),
                make: &|row| Ok(DVec3::from_array(row)),
                answer: &|point| test.row(*point),
            };
            if !answers.write(path, args.output.as_deref())? {
                outcome = Outcome::ErrorsInInput;
            }
        }
    }
    Ok(outcome)
}

/// The test of each point.
struct PointTest<'a> {
    scene: &'a CompiledScene,
    all: bool,
    distance: bool,
}

impl PointTest<'_> {
    /// The columns of an output row.
    fn columns(&self) -> Vec<&'static str> {
        let mut columns = RESULT_COLUMNS.to_vec();
        columns.extend(ALL_COLUMNS.iter().filter(|_| self.all));
        columns.extend(DISTANCE_COLUMNS.iter().filter(|_| self.distance));
        columns
    }

    /// The output row of a point, and a warning if the search was not complete. Without any
    /// primitive in the scene, value and path are empty.
    fn row(&self, point: DVec3) -> (Vec<String>, Option<&'static str>) {
        let limits = PointLimits::default();
        let nearest = self.scene.nearest_primitive(point, &limits);
        let mut is_complete = nearest.as_ref().is_none_or(|nearest| nearest.is_complete);
        let mut row: Vec<String> = fields(&point.to_array()).collect();
        let inside = nearest.as_ref().is_some_and(|nearest| nearest.inside);
        row.push(u8::from(inside).to_string());
        row.extend(match nearest {
            Some(nearest) => [format_number(nearest.value), self.scene.path_name(&nearest.path)],
            None => [String::new(), String::new()],
        });
        if self.all {
            let (holders, is_all) = self.scene.primitives_holding(point, MOST_HOLDERS, &limits);
            is_complete &= is_all;
            let paths: Vec<String> =
                holders.iter().map(|holder| self.scene.path_name(&holder.path)).collect();
            row.extend([holders.len().to_string(), paths.join(" ")]);
        }
        if self.distance {
            let distance = self.scene.signed_distance(point, &limits);
            is_complete &= distance.as_ref().is_none_or(|distance| distance.is_complete);
            row.extend(match distance {
                Some(found) => [
                    format_number(found.distance),
                    format_number(found.error),
                    self.scene.path_name(&found.path),
                ],
                None => [String::new(), String::new(), String::new()],
            });
        }
        (row, (!is_complete).then_some(TOO_MANY))
    }

    fn write_grid(&self, grid: Grid, args: &IotestArgs) -> Result<()> {
        let mut incomplete = 0u64;
        write_rows(args.output.as_deref(), |writer| {
            writer.write_record(self.columns())?;
            let mut points = grid.points();
            loop {
                let chunk: Vec<DVec3> = points.by_ref().take(CHUNK).collect();
                if chunk.is_empty() {
                    return Ok(());
                }
                let rows: Vec<_> = chunk.par_iter().map(|&point| self.row(point)).collect();
                for (row, warning) in rows {
                    incomplete += u64::from(warning.is_some());
                    writer.write_record(row)?;
                }
            }
        })?;
        if incomplete > 0 {
            console::warn(format_args!("superegg: warning: {TOO_MANY}, at {incomplete} points of the grid"));
        }
        Ok(())
    }
}

const TOO_MANY: &str =
    "more primitives surround the point than can be tested; the best answer found is given";
