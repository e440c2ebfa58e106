//! The printed report of fits.

use serde_json::{Map, Value, json};
use superegg_exchange::write::convention::Convention;
use superegg_fit::{COVARIANCE_ROWS, Fit, Residuals};
use superegg_geom::glam::DVec3;
use superegg_lang::format_number;

use crate::text::counted;

/// The shape that each point is of, and how far it is from it.
pub(super) struct Explained {
    /// The signed distance from the point's shape, for outliers from the nearest one.
    pub(super) distances: Vec<f64>,
    /// The probability that the point is of the shape.
    pub(super) inliers: Vec<f64>,
    /// The index of the shape; `None` for outliers.
    pub(super) shape_of: Vec<Option<usize>>,
}

impl Explained {
    pub(super) fn of(fits: &[Fit], points: &[DVec3]) -> Self {
        let all: Vec<Residuals> = fits.iter().map(|fit| fit.residuals(points)).collect();
        let (mut distances, mut inliers, mut shape_of) = (Vec::new(), Vec::new(), Vec::new());
        for index in 0..points.len() {
            let best = |better: &dyn Fn(usize, usize) -> bool| {
                (0..all.len()).fold(0, |best, shape| if better(shape, best) { shape } else { best })
            };
            let likely = best(&|a, b| all[a].inliers[index] > all[b].inliers[index]);
            let is_outlier = all[likely].inliers[index] < 0.5;
            let near = best(&|a, b| all[a].distances[index].abs() < all[b].distances[index].abs());
            let shape = if is_outlier { near } else { likely };
            distances.push(all[shape].distances[index]);
            inliers.push(all[shape].inliers[index]);
            shape_of.push((!is_outlier).then_some(shape));
        }
        Self { distances, inliers, shape_of }
    }

    fn outlier_share(&self) -> f64 {
        1.0 - self.inliers.iter().sum::<f64>() / self.inliers.len().max(1) as f64
    }

    /// The number of points of a shape, the root mean square and the largest of their distances.
    fn distances_from(&self, shape: usize) -> (usize, f64, f64) {
        let (mut count, mut squares, mut weights, mut largest) = (0, 0.0, 0.0, 0f64);
        for ((distance, weight), of) in self.distances.iter().zip(&self.inliers).zip(&self.shape_of) {
            if *of == Some(shape) {
                count += 1;
                squares += weight * distance * distance;
                weights += weight;
                largest = largest.max(distance.abs());
            }
        }
        (count, (squares / weights.max(f64::MIN_POSITIVE)).sqrt(), largest)
    }
}

/// Fits, and how far the points are from them.
pub(super) struct Report<'a> {
    pub(super) fits: &'a [Fit],
    pub(super) points: &'a [DVec3],
    pub(super) explained: &'a Explained,
    pub(super) convention: Option<Convention>,
}

impl Report<'_> {
    /// The warnings, with the number of the shape if there are several.
    pub(super) fn warnings(&self) -> Vec<String> {
        let of_shape = |(index, fit): (usize, &Fit)| {
            let prefix = if self.fits.len() > 1 { format!("shape {}: ", index + 1) } else { String::new() };
            fit.warnings.iter().map(|warning| format!("{prefix}{warning}")).collect::<Vec<_>>()
        };
        self.fits.iter().enumerate().flat_map(of_shape).collect()
    }

    /// The parameters as the chosen program has them.
    fn parameters(&self, fit: &Fit) -> Option<(&'static str, Vec<(&'static str, f64)>)> {
        let Fit { shape, rotation, center, .. } = fit;
        let convention = self.convention?;
        Some((convention.name, convention.parameters(shape.radii(), shape.exponents(), *rotation, *center)))
    }

    pub(super) fn text(&self) -> String {
        let mut blocks: Vec<String> =
            self.fits.iter().enumerate().map(|(index, fit)| self.text_of(index, fit)).collect();
        let used: usize = self.fits.iter().map(|fit| fit.used).max().unwrap_or(0);
        let count = self.points.len();
        let thinned = if self.fits.len() == 1 && used < count {
            format!(", {used} of them fitted")
        } else {
            String::new()
        };
        let outliers = 100.0 * self.explained.outlier_share();
        blocks.push(format!("{}{thinned}: {outliers:.1} % outliers", counted(count, "point")));
        blocks.join("\n")
    }

    fn text_of(&self, index: usize, fit: &Fit) -> String {
        let Fit { shape, rotation, center, noise, surface_error, .. } = fit;
        let errors = fit.standard_errors();
        let with_errors = |numbers: &[f64], errors: &[f64]| {
            let texts = numbers.iter().zip(errors).map(|(x, error)| {
                let digits = decimals(*error);
                format!("{x:.digits$} +- {error:.digits$}")
            });
            texts.collect::<Vec<_>>().join(", ")
        };
        let exponents = [shape.exponents().e(), shape.exponents().n()];
        let [x, y, z, w] = rotation.to_array().map(|x| format!("{x:.6}"));
        let (count, rms, largest) = self.explained.distances_from(index);
        let mut lines = Vec::new();
        if self.fits.len() > 1 {
            lines.push(format!("shape {}: {}", index + 1, counted(count, "point")));
        }
        lines.extend([
            format!("semi-axes a b c: {}", with_errors(&shape.radii().to_array(), &errors[6..9])),
            format!("exponents e n: {}", with_errors(&exponents, &errors[9..11])),
            format!("centre: {}", with_errors(&center.to_array(), &errors[..3])),
            format!("rotation w x y z: {w} {x} {y} {z}"),
            format!(
                "distances: noise {}, root mean square {}, largest of an inlier {}; standard error of the surface {}",
                short(*noise),
                short(rms),
                short(largest),
                short(*surface_error)
            ),
        ]);
        if let Some((name, parameters)) = self.parameters(fit) {
            let words = parameters.iter().map(|(name, number)| format!("{name} {}", format_number(*number)));
            lines.push(format!("{name}: {}", words.collect::<Vec<_>>().join("  ")));
        }
        lines.join("\n")
    }

    /// The one shape, with what concerns all points.
    pub(super) fn json_of_one(&self) -> Value {
        let mut report = self.fits.first().map_or_else(|| json!({}), |fit| self.json_of(0, fit));
        report["points"] = self.points.len().into();
        report["outliers"] = self.explained.outlier_share().into();
        report
    }

    /// All shapes.
    pub(super) fn json(&self) -> Value {
        let shapes: Vec<Value> =
            self.fits.iter().enumerate().map(|(index, fit)| self.json_of(index, fit)).collect();
        json!({
            "points": self.points.len(),
            "outliers": self.explained.outlier_share(),
            "shapes": shapes,
        })
    }

    fn json_of(&self, index: usize, fit: &Fit) -> Value {
        let Fit { shape, rotation, center, noise, covariance, surface_error, used, warnings, .. } = fit;
        let [x, y, z, w] = rotation.to_array();
        let (count, rms, largest) = self.explained.distances_from(index);
        let mut report = json!({
            "semi_axes": shape.radii().to_array(),
            "exponents": { "e": shape.exponents().e(), "n": shape.exponents().n() },
            "center": center.to_array(),
            "rotation": [w, x, y, z],
            "inliers": count,
            "fitted_points": used,
            "noise": noise,
            "rms": rms,
            "hausdorff": largest,
            "surface_error": surface_error,
            "covariance_rows": COVARIANCE_ROWS,
            "covariance": covariance,
            "warnings": warnings.iter().map(ToString::to_string).collect::<Vec<_>>(),
        });
        if let Some((name, parameters)) = self.parameters(fit) {
            let parameters: Map<String, Value> =
                parameters.into_iter().map(|(name, number)| (name.to_owned(), number.into())).collect();
            report["convention"] = name.into();
            report["parameters"] = parameters.into();
        }
        report
    }
}

/// The decimals that show two digits of an error.
fn decimals(error: f64) -> usize {
    if error > 0.0 { (1.0 - error.log10().floor()).clamp(0.0, 12.0) as usize } else { 6 }
}

/// A number with four significant digits.
fn short(x: f64) -> String {
    let digits = if x > 0.0 { (3.0 - x.log10().floor()).clamp(0.0, 12.0) as usize } else { 0 };
    format!("{x:.digits$}")
}
