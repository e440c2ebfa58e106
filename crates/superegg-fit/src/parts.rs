//! Several superquadrics for one cloud.

mod explain;
mod group;
mod model;
mod watch;

use superegg_geom::glam::DVec3;

use crate::cloud::Cloud;
use crate::error::FitError;
use crate::fit::Fit;
use crate::options::{FitOptions, MOST_PARTS, PartCount};
use crate::parameters::Bounds;
use crate::search::Question;
use explain::Explainer;
pub use watch::PartsProgress;
use watch::Watch;

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
    fit_parts_while(points, options, count, &mut |_| true)
}

/// As [`fit_parts`], while `goes_on` returns true. It is called before each fit of a group of points, which
/// takes milliseconds. Once it has returned false the search ends with the shapes that it has: a whole
/// description of the points, though some shapes may be split or merged less than they should be, and there
/// may be more of them than [`PartCount::Exactly`] wants.
///
/// ```
/// use superegg_fit::{FitOptions, PartCount, fit_parts_while};
/// use superegg_geom::Superquadric;
/// use superegg_geom::glam::DVec3;
///
/// let ball = Superquadric::unit_sphere().sample_surface(500, 1);
/// let points: Vec<DVec3> = ball.iter().flat_map(|at| [at.point, at.point + 5.0 * DVec3::X]).collect();
/// let mut calls = 0;
/// let found = fit_parts_while(&points, &FitOptions::default(), PartCount::Auto, &mut |progress| {
///     assert_eq!(progress.fits, calls);
///     calls += 1;
///     true
/// })?;
/// assert_eq!(found.len(), 2);
/// assert!(calls >= 2);
/// # Ok::<(), superegg_fit::FitError>(())
/// ```
///
/// # Errors
/// As for [`fit_parts`].
pub fn fit_parts_while(
    points: &[DVec3],
    options: &FitOptions,
    count: PartCount,
    goes_on: &mut dyn FnMut(PartsProgress) -> bool,
) -> Result<Vec<Fit>, FitError> {
    options.check()?;
    if !matches!(count, PartCount::Auto | PartCount::Exactly(1..=MOST_PARTS)) {
        return Err(FitError::Option("the number of parts must be from 1 to 64"));
    }
    let cloud = Cloud::new(points, options)?;
    let [least, most] = options.exponents;
    let bounds = Bounds { least, most };
    let question = Question { bounds, outliers: options.outliers, seed: options.seed };
    let found = Explainer::new(&cloud.points, question, Watch::new(goes_on)).parts(count);
    let fit_of = |(shape, members): (_, Vec<usize>)| {
        let points = members.iter().map(|&index| cloud.points[index]).collect();
        Fit::of(&Cloud { points, left_out: 0.0, ..cloud }, &shape, bounds)
    };
    Ok(found.into_iter().map(fit_of).collect())
}
