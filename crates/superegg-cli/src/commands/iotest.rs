//! `superegg iotest`: points inside and outside.

use anyhow::{Result, bail};
use superegg_geom::glam::DVec3;
use superegg_lang::format_number;
use superegg_trace::CompiledScene;

use crate::args::IotestArgs;
use crate::commands::{Outcome, load_compiled, write_csv};
use crate::csv_input::{fields, read_rows};
use crate::say;

const POINT_COLUMNS: [&str; 3] = ["x", "y", "z"];
const ANSWER_COLUMNS: [&str; 6] = ["x", "y", "z", "inside", "value", "path"];
/// A grid has at most so many points along each axis.
const MOST_ALONG_AXIS: f64 = 2001.0;

pub(crate) fn run(args: &IotestArgs) -> Result<Outcome> {
    let grid = Grid::new(args.step, args.half)?;
    let (loaded, compiled) = load_compiled(&args.scene, &args.root, args.output.as_deref())?;
    let points: Box<dyn Iterator<Item = DVec3>> = match &args.points {
        None => Box::new(grid.points()),
        Some(path) => match read_rows(path, POINT_COLUMNS, |row| Ok(DVec3::from_array(row)))? {
            Ok(points) => Box::new(points.into_iter()),
            Err(complaints) => {
                complaints.iter().for_each(say::complain);
                return Ok(Outcome::ErrorsInInput);
            }
        },
    };
    write_csv(args.output.as_deref(), |writer| {
        writer.write_record(ANSWER_COLUMNS)?;
        points.into_iter().try_for_each(|point| writer.write_record(answer(&compiled, point)))
    })?;
    Ok(Outcome::of(&loaded))
}

/// The columns of one answer.
fn answer(scene: &CompiledScene, point: DVec3) -> Vec<String> {
    let tested = scene.query_point(point);
    let mut columns: Vec<String> = fields(&point.to_array()).collect();
    columns.push(u8::from(tested.inside).to_string());
    columns.extend(match tested.least {
        Some((value, path)) => [format_number(value), scene.path_name(&path)],
        None => [String::new(), String::new()],
    });
    columns
}

/// The grid of the course text: (S i, S j, S k) with |i|, |j|, |k| <= H / S.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Grid {
    step: f64,
    most: i32,
}

impl Grid {
    pub(crate) fn new(step: f64, half: f64) -> Result<Self> {
        // A quotient that falls short of a whole number by rounding counts as that number: 0.3 / 0.1.
        let most = (half / step * (1.0 + 4.0 * f64::EPSILON)).floor();
        if 2.0 * most + 1.0 > MOST_ALONG_AXIS || !most.is_finite() {
            bail!(
                "a grid with step {} as far as {} has more than {MOST_ALONG_AXIS} points along each axis; take a larger step",
                format_number(step),
                format_number(half)
            );
        }
        Ok(Self { step, most: most as i32 })
    }

    pub(crate) fn points(self) -> impl Iterator<Item = DVec3> {
        let range = move || (-self.most..=self.most).map(move |i| self.step * f64::from(i));
        range().flat_map(move |x| range().flat_map(move |y| range().map(move |z| DVec3::new(x, y, z))))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_grid_has_both_ends() {
        let count = |step, half| Grid::new(step, half).unwrap().points().count();
        assert_eq!((count(0.5, 5.0), count(0.1, 0.3), count(1.0, 0.0), count(2.0, 1.0)), (9261, 343, 1, 1));
        assert!(Grid::new(1e-9, 5.0).is_err() && Grid::new(1e-300, 1e300).is_err());
    }
}
