//! `superegg iotest`: inside-outside tests of points.

use anyhow::Result;
use rayon::prelude::*;
use superegg_geom::glam::DVec3;
use superegg_lang::format_number;
use superegg_trace::{CompiledScene, PointLimits};

use crate::args::IotestArgs;
use crate::commands::input::load_compiled;
use crate::console;
use crate::files;
use crate::files::answers::Answers;
use crate::files::csv::{fields, path_field, write_rows};
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
    files::check_output(args.output.as_deref(), &args.scene, args.overwrite.into())?;
    let (loaded, compiled) = load_compiled(&args.scene, &args.root)?;
    let mut limits = PointLimits::default();
    limits.boxes = args.limit.unwrap_or(limits.boxes);
    let test = PointTest { scene: &compiled, all: args.all, distance: args.distance, limits };
    let mut outcome = Outcome::of_input(loaded.has_errors());
    match args.points.as_ref().or(args.point_file.as_ref()) {
        None => {
            if !test.write_grid(grid, args)? {
                outcome = Outcome::ErrorsInInput;
            }
        }
        Some(path) => {
            let answers = Answers {
                questions: POINT_COLUMNS,
                answers: test.columns(),
                make: &|row| Ok(DVec3::from_array(row)),
                answer: &|point| test.row(*point).map_err(|TooMuchWork| (0, TOO_MANY.to_owned())),
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
    limits: PointLimits,
}

/// The answer for a point needs more work than the limits allow.
struct TooMuchWork;

impl PointTest<'_> {
    /// The columns of an output row.
    fn columns(&self) -> Vec<&'static str> {
        let mut columns = RESULT_COLUMNS.to_vec();
        columns.extend(ALL_COLUMNS.iter().filter(|_| self.all));
        columns.extend(DISTANCE_COLUMNS.iter().filter(|_| self.distance));
        columns
    }

    /// The output row of a point. Without any primitive in the scene, value and path are empty.
    fn row(&self, point: DVec3) -> Result<Vec<String>, TooMuchWork> {
        let limits = self.limits;
        let nearest = self.scene.nearest_primitive(point, &limits);
        let mut is_complete = nearest.as_ref().is_none_or(|nearest| nearest.is_complete);
        let mut row: Vec<String> = fields(&point.to_array()).collect();
        let inside = nearest.as_ref().is_some_and(|nearest| nearest.inside);
        row.push(u8::from(inside).to_string());
        row.extend(match nearest {
            Some(nearest) => [format_number(nearest.value), path_field(self.scene, &nearest.path)],
            None => [String::new(), String::new()],
        });
        if self.all {
            let (holders, is_all) = self.scene.primitives_holding(point, MOST_HOLDERS, &limits);
            is_complete &= is_all;
            let paths: Vec<String> =
                holders.iter().map(|holder| path_field(self.scene, &holder.path)).collect();
            row.extend([holders.len().to_string(), paths.join(" ")]);
        }
        if self.distance {
            let distance = self.scene.signed_distance(point, &limits);
            is_complete &= distance.as_ref().is_none_or(|distance| distance.is_complete);
            row.extend(match distance {
                Some(found) => [
                    format_number(found.distance),
                    format_number(found.error),
                    path_field(self.scene, &found.path),
                ],
                None => [String::new(), String::new(), String::new()],
            });
        }
        if is_complete { Ok(row) } else { Err(TooMuchWork) }
    }

    /// Writes the answer for each point of a grid. A point without an answer has only its
    /// coordinates. Returns whether all points have one.
    fn write_grid(&self, grid: Grid, args: &IotestArgs) -> Result<bool> {
        let mut unanswered = 0u64;
        write_rows(args.output.as_deref(), |writer| {
            writer.write_record(self.columns())?;
            let mut points = grid.points();
            loop {
                let chunk: Vec<DVec3> = points.by_ref().take(CHUNK).collect();
                if chunk.is_empty() {
                    return Ok(());
                }
                let rows: Vec<_> = chunk.par_iter().map(|&point| self.row(point)).collect();
                for (point, row) in chunk.iter().zip(rows) {
                    unanswered += u64::from(row.is_err());
                    writer.write_record(row.unwrap_or_else(|TooMuchWork| {
                        let mut row: Vec<String> = fields(&point.to_array()).collect();
                        row.resize(self.columns().len(), String::new());
                        row
                    }))?;
                }
            }
        })?;
        if unanswered > 0 {
            console::warn(format_args!("superegg: error: {TOO_MANY}, at {unanswered} points of the grid"));
        }
        Ok(unanswered == 0)
    }
}

const TOO_MANY: &str =
    "more primitives surround the point than the limit; --limit BOXES allows more, a smaller depth has fewer";
