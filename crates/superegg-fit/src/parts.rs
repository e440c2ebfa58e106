//! Several superquadrics for one cloud.

mod explain;
mod group;
mod model;

use superegg_geom::glam::DVec3;

use crate::cloud::Cloud;
use crate::error::FitError;
use crate::fit::Fit;
use crate::options::{FitOptions, MOST_PARTS, PartCount};
use crate::parameters::Bounds;
use crate::search::Question;
use explain::Explainer;

/// Fits superquadrics to points of one or more objects, or of one object in parts. The parts are in the
/// order of their numbers of points, the largest first.
///
/// Groups of points that no neighbours join are looked at one by one. A superquadric is fitted to a group;
/// where it leaves points over, or is far from them, the rest is a group again, or the group is halved, if
/// the parts describe the points shorter than one shape does. Then points go to the part that explains them
/// best and the shapes are refined, in turns, and parts are merged while that shortens the description.
///
/// # Errors
/// As for [`crate::fit`], and a number of parts that is 0 or above [`MOST_PARTS`].
pub fn fit_parts(points: &[DVec3], options: &FitOptions, count: PartCount) -> Result<Vec<Fit>, FitError> {
    options.check()?;
    if !matches!(count, PartCount::Auto | PartCount::Exactly(1..=MOST_PARTS)) {
        return Err(FitError::Option("the number of parts must be from 1 to 64"));
    }
    let cloud = Cloud::new(points, options)?;
    let [least, most] = options.exponents;
    let bounds = Bounds { least, most };
    let question = Question { bounds, outliers: options.outliers, seed: options.seed };
    let found = Explainer::new(&cloud.points, question).parts(count);
    let fit_of = |(shape, members): (_, Vec<usize>)| {
        let points = members.iter().map(|&index| cloud.points[index]).collect();
        Fit::of(&Cloud { points, left_out: 0.0, ..cloud }, &shape, bounds)
    };
    Ok(found.into_iter().map(fit_of).collect())
}
