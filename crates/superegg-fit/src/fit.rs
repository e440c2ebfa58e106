//! The fit of one superquadric.

use superegg_geom::glam::{DMat3, DQuat, DVec3};
use superegg_geom::{Exponents, Superquadric};

use crate::cloud::Cloud;
use crate::error::FitError;
use crate::mixture::Mixture;
use crate::normal_equations::NormalEquations;
use crate::options::FitOptions;
use crate::parameters::{Bounds, COUNT, Parameters};
use crate::refine::{Candidate, Measure, Residual};
use crate::residuals::{Residuals, distances};
use crate::rows::Points;
use crate::search::{Question, search};
use crate::surface::distance;
use crate::uncertainty::Uncertainty;
use crate::warning::FitWarning;

/// The names of the rows of [`Fit::covariance`], with their units.
pub const COVARIANCE_ROWS: [&str; COUNT] =
    ["center_x", "center_y", "center_z", "turn_x", "turn_y", "turn_z", "a", "b", "c", "e", "n"];

/// A superquadric that fits points.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Fit {
    /// Semi-axes, in the unit of the points, and exponents.
    pub shape: Superquadric,
    /// The rotation from the shape's own axes to those of the points.
    pub rotation: DQuat,
    /// The centre.
    pub center: DVec3,
    /// The standard deviation of the distances of inliers.
    pub noise: f64,
    /// The share of outliers among the points that were fitted.
    pub outliers: f64,
    /// The covariance of the parameters [`COVARIANCE_ROWS`]: the centre along the axes of the points, a
    /// rotation vector about the shape's own axes (radians), the semi-axes, and the exponents.
    pub covariance: [[f64; COUNT]; COUNT],
    /// The standard error of the surface, its root mean square over the whole of it, hidden sides
    /// included.
    pub surface_error: f64,
    /// The number of points that were fitted: all, or [`FitOptions::most_points`].
    pub used: usize,
    /// The doubts that the points leave.
    pub warnings: Vec<FitWarning>,
    /// The density of outliers over the largest density on the surface.
    background: f64,
}

/// Fits a superquadric to points of its surface with noise, outliers and hidden sides.
///
/// # Errors
/// There are fewer different points than parameters, they lie on a plane, a coordinate is not finite,
/// or an option is out of its range.
///
/// ```
/// use superegg_fit::{FitOptions, fit};
/// use superegg_geom::glam::DVec3;
/// use superegg_geom::{Exponents, Superquadric};
///
/// let shape = Superquadric::new(DVec3::new(1.0, 2.0, 1.5), Exponents::new(0.5, 1.3)?)?;
/// let points: Vec<DVec3> = shape.sample_surface(500, 1).iter().map(|at| at.point + DVec3::X).collect();
/// let found = fit(&points, &FitOptions::default())?;
/// assert!(found.residuals(&points).hausdorff() < 1e-4);
/// assert!((found.center - DVec3::X).length() < 1e-4);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn fit(points: &[DVec3], options: &FitOptions) -> Result<Fit, FitError> {
    options.check()?;
    let cloud = Cloud::new(points, options)?;
    let [least, most] = options.exponents;
    let bounds = Bounds { least, most };
    let question = Question { bounds, outliers: options.outliers, seed: options.seed };
    let found = search(&cloud.points, &question);
    let mut fit = Fit::of(&cloud, &found.best, bounds);
    fit.warnings.extend(found.rival.and_then(|rival| ambiguous(&found.best, &rival, &fit, &cloud)));
    Ok(fit)
}

/// The standard error of a rotation from which on it is undetermined, in radians.
const TURNABLE: f64 = 0.1;
/// A section is round where a turn by a radian moves the surface by less than this part of the noise.
const ROUND: f64 = 0.25;
/// The relative error of the surface above which it is uncertain.
const UNCERTAIN: f64 = 0.01;
/// The share of outliers that is worth a warning.
const MANY: f64 = 0.5;
/// The distance between two shapes that are no errors of each other, in standard errors of the surface.
const APART: f64 = 5.0;
/// The ratio of semi-axes below which a shape is thin.
const THIN: f64 = 0.01;
/// The relative noise that is worth a warning.
const MISFIT: f64 = 0.06;

impl Fit {
    pub(crate) fn of(cloud: &Cloud, found: &Candidate, bounds: Bounds) -> Self {
        let Candidate { shape, mixture, .. } = found;
        let points = Points::new(&cloud.points);
        let mut measure = Measure::default();
        measure.set(&points, shape, Residual::Closest);
        let area = shape.rough_area();
        let mixture = mixture.with_area(area);
        let mut weights = Vec::new();
        mixture.weights(&points, &measure.linear.distances, area, &mut weights);
        let total: f64 = weights.iter().flatten().sum();
        let information = NormalEquations::of(&measure.linear, &weights).matrix;
        let outliers = cloud.left_out + (1.0 - cloud.left_out) * (1.0 - total / points.total);
        let uncertainty = Uncertainty::of(&information, total, mixture.sigma);
        Self {
            shape: shape_of(shape, cloud.scale),
            rotation: rotation_of(&shape.axes),
            center: cloud.origin + cloud.scale * shape.center,
            noise: cloud.scale * mixture.sigma,
            outliers,
            covariance: in_units_of_points(&uncertainty.covariance, shape, cloud.scale),
            surface_error: cloud.scale * uncertainty.surface,
            used: cloud.points.len(),
            warnings: warnings(shape, &mixture, &uncertainty, outliers, bounds),
            background: mixture.background(area),
        }
    }

    /// The distances of points to the surface, and how probably they are of it. The relative error is
    /// proven to be 1e-6; of more than 100,000 points only that of those away from the surface is, and a
    /// few near edges have a distance that is too large by a part of the noise. A point that is not
    /// finite has the distance nan.
    pub fn residuals(&self, points: &[DVec3]) -> Residuals {
        let unit = self.shape.radii().max_element();
        let back = self.rotation.inverse();
        let own: Vec<DVec3> = points.iter().map(|point| back * ((*point - self.center) / unit)).collect();
        let exponents = self.shape.exponents();
        let shape = Superquadric::new(self.shape.radii() / unit, exponents).unwrap_or(self.shape);
        let distances = distances(&shape, &own, self.noise / unit);
        let rate = -0.5 * (unit / self.noise).powi(2);
        let inliers = distances.iter().map(|distance| {
            let density = (rate * distance * distance).exp();
            density / (density + self.background)
        });
        Residuals { inliers: inliers.collect(), distances: distances.iter().map(|d| unit * d).collect() }
    }

    /// The density of outliers over the largest density on the surface: with it [`Fit::restored`] makes a fit that
    /// has the same residuals.
    pub fn background(&self) -> f64 {
        self.background
    }

    /// A fit from numbers that were kept. Outliers, covariance, error, number of points and warnings are to be
    /// set: they are 0 and none.
    ///
    /// ```
    /// use superegg_fit::{Fit, FitOptions, fit};
    /// use superegg_geom::Superquadric;
    /// use superegg_geom::glam::DVec3;
    ///
    /// let points: Vec<DVec3> = Superquadric::unit_sphere().sample_surface(500, 1).iter().map(|at| at.point).collect();
    /// let found = fit(&points, &FitOptions::default())?;
    /// let kept = Fit::restored(found.shape, found.rotation, found.center, found.noise, found.background());
    /// assert_eq!(kept.residuals(&points), found.residuals(&points));
    /// # Ok::<(), superegg_fit::FitError>(())
    /// ```
    pub fn restored(
        shape: Superquadric,
        rotation: DQuat,
        center: DVec3,
        noise: f64,
        background: f64,
    ) -> Self {
        Self {
            shape,
            rotation,
            center,
            noise,
            outliers: 0.0,
            covariance: [[0.0; COUNT]; COUNT],
            surface_error: 0.0,
            used: 0,
            warnings: Vec::new(),
            background,
        }
    }

    /// The standard errors of the parameters [`COVARIANCE_ROWS`].
    pub fn standard_errors(&self) -> [f64; COUNT] {
        std::array::from_fn(|i| self.covariance[i][i].sqrt())
    }
}

fn shape_of(shape: &Parameters, scale: f64) -> Superquadric {
    let [e, n] = shape.exponents;
    let radii = scale * shape.radii;
    let exponents = Exponents::new(e, n).unwrap_or_default();
    Superquadric::new(radii, exponents).unwrap_or_else(|_| Superquadric::unit(exponents))
}

/// The quaternion with w >= 0.
fn rotation_of(axes: &DMat3) -> DQuat {
    let rotation = DQuat::from_mat3(axes).normalize();
    if rotation.w < 0.0 { -rotation } else { rotation }
}

/// The covariance of the centre in space and of the semi-axes, instead of the centre along the shape's
/// own axes and of the logarithms of the semi-axes.
fn in_units_of_points(
    covariance: &[[f64; COUNT]; COUNT],
    shape: &Parameters,
    scale: f64,
) -> [[f64; COUNT]; COUNT] {
    let mut jacobian = [[0.0; COUNT]; COUNT];
    for i in 0..3 {
        for j in 0..3 {
            jacobian[i][j] = scale * shape.axes.col(j)[i];
        }
        jacobian[3 + i][3 + i] = 1.0;
        jacobian[6 + i][6 + i] = scale * shape.radii[i];
    }
    jacobian[9][9] = 1.0;
    jacobian[10][10] = 1.0;
    let product = |a: &[[f64; COUNT]; COUNT], b: &dyn Fn(usize, usize) -> f64| {
        let mut result = [[0.0; COUNT]; COUNT];
        for i in 0..COUNT {
            for j in 0..COUNT {
                result[i][j] = (0..COUNT).map(|k| a[i][k] * b(k, j)).sum();
            }
        }
        result
    };
    let half = product(&jacobian, &|k, j| covariance[k][j]);
    product(&half, &|k, j| jacobian[j][k])
}

/// The warning that another shape fits as well, if its surface is farther away than the standard error of the
/// surface explains.
fn ambiguous(best: &Candidate, rival: &Candidate, fit: &Fit, cloud: &Cloud) -> Option<FitWarning> {
    let distance = distance(&rival.shape, &best.shape);
    let is_other = cloud.scale * distance > APART * fit.surface_error;
    is_other.then(|| FitWarning::Ambiguous {
        relative_distance: distance / best.shape.size(),
        other: shape_of(&rival.shape, cloud.scale),
        rotation: rotation_of(&rival.shape.axes),
        center: cloud.origin + cloud.scale * rival.shape.center,
    })
}

fn warnings(
    shape: &Parameters,
    mixture: &Mixture,
    uncertainty: &Uncertainty,
    outliers: f64,
    bounds: Bounds,
) -> Vec<FitWarning> {
    let size = shape.size();
    let mut warnings = Vec::new();
    let relative_error = uncertainty.surface / size;
    if relative_error > UNCERTAIN {
        warnings.push(FitWarning::Uncertain { relative_error });
    }
    for axis in 0..3 {
        let turn = 3 + axis;
        let is_round = uncertainty.slopes[turn] < ROUND * mixture.sigma;
        if is_round || uncertainty.is_free[turn] || uncertainty.covariance[turn][turn].sqrt() > TURNABLE {
            warnings.push(FitWarning::Turnable { axis });
        }
    }
    for (exponent, value) in ['e', 'n'].into_iter().zip(shape.exponents) {
        if value == bounds.least || value == bounds.most {
            warnings.push(FitWarning::AtBound { exponent, value });
        }
    }
    let ratio = shape.radii.min_element() / shape.radii.max_element();
    if ratio < THIN {
        warnings.push(FitWarning::Thin { ratio });
    }
    if outliers > MANY {
        warnings.push(FitWarning::ManyOutliers { share: outliers });
    }
    let relative_noise = mixture.sigma / size;
    if relative_noise > MISFIT {
        warnings.push(FitWarning::Misfit { relative_noise });
    }
    warnings
}
