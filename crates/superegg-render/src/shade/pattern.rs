//! Patterns that blend the colour of a surface with a second colour.

use std::f64::consts::PI;

use superegg_geom::glam::DVec3;
use superegg_geom::unit_vector;
use superegg_scene::Pattern;

use crate::shade::noise::octaves;

/// The weight of the pattern's colour at a point in the space of the pattern, in [0, 1].
///
/// `extents` is the size of the footprint along the three axes. A checker is averaged exactly over
/// a box of this size. `reach` is the support function of the shape; `None` for a floor, on which a
/// gradient is a triangle wave.
pub(crate) fn weight(
    pattern: &Pattern,
    point: DVec3,
    extents: DVec3,
    reach: Option<&dyn Fn(DVec3) -> f64>,
) -> f64 {
    let width = extents.max_element();
    match *pattern {
        Pattern::None => 0.0,
        Pattern::Checker { size, .. } => {
            let sign: f64 = (0..3).map(|axis| mean_sign(point[axis] / size, extents[axis] / size)).product();
            0.5 - 0.5 * sign
        }
        Pattern::Gradient { direction, .. } => {
            let along = unit_vector(direction).unwrap_or(DVec3::Z);
            let distance = point.dot(along);
            match reach {
                Some(reach) => (0.5 + 0.5 * distance / reach(along)).clamp(0.0, 1.0),
                None => (1.0 - (distance - 2.0 * (0.5 * distance).floor() - 1.0).abs()).clamp(0.0, 1.0),
            }
        }
        Pattern::Noise { size, .. } => (0.5 + octaves(point / size, width / size)).clamp(0.0, 1.0),
        Pattern::Marble { size, .. } => {
            let (at, width) = (point / size, width / size);
            let vein = (PI * (at.x + 2.0 * octaves(at, width))).sin().abs();
            // Narrow veins; from afar their mean.
            faded((1.0 - vein).powi(3), MEAN_VEIN, width)
        }
        Pattern::Wood { size, .. } => {
            let (at, width) = (point / size, width / size);
            let radius = at.truncate().length() + 0.4 * octaves(at * DVec3::new(0.7, 0.7, 0.1), width);
            let ring = radius.rem_euclid(1.0);
            // Late wood gets darker slowly and ends at once.
            faded(ring * ring * (1.0 - ring.powi(16)), MEAN_RING, width)
        }
    }
}

/// The mean weight of a vein of marble: the integral of (1 - sin)^3 over half a turn.
const MEAN_VEIN: f64 = 2.5 - 22.0 / (3.0 * PI);
/// The mean weight of a ring of wood.
const MEAN_RING: f64 = 1.0 / 3.0 - 1.0 / 19.0;

/// A weight that goes over to its mean where a footprint of this width, in periods, holds a period.
fn faded(weight: f64, mean: f64, width: f64) -> f64 {
    // Beyond the range of numbers there are no periods.
    if !weight.is_finite() {
        return mean;
    }
    mean + (weight - mean) * (2.0 - 2.0 * width).clamp(0.0, 1.0)
}

/// Blends a colour with that of the pattern.
pub(crate) fn mix(color: DVec3, pattern: &Pattern, weight: f64) -> DVec3 {
    pattern.color().map_or(color, |other| color.lerp(other, weight))
}

/// The mean of a square wave (+1 on [0, 1), -1 on [1, 2), period 2) over an interval of `width`
/// around `x`.
fn mean_sign(x: f64, width: f64) -> f64 {
    // The integral of the square wave is a triangle wave.
    let integral = |x: f64| 1.0 - (x - 2.0 * (0.5 * x).floor() - 1.0).abs();
    if width < 1e-6 {
        return if (0.5 * x).fract().rem_euclid(1.0) < 0.5 { 1.0 } else { -1.0 };
    }
    let mean = (integral(x + 0.5 * width) - integral(x - 0.5 * width)) / width;
    // Rounding must not make a colour negative.
    if mean.is_finite() { mean.clamp(-1.0, 1.0) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_go_by_turns_and_far_ones_blend() {
        let checker = Pattern::Checker { color: DVec3::ONE, size: 0.5 };
        let at = |x: f64, y: f64, z: f64, width: f64| {
            weight(&checker, DVec3::new(x, y, z), DVec3::splat(width), None)
        };
        assert_eq!(
            [at(0.1, 0.1, 0.1, 0.0), at(-0.1, 0.1, 0.1, 0.0), at(0.6, 0.6, 0.1, 0.0)],
            [0.0, 1.0, 0.0]
        );
        let all = (0..1000).map(|i| at(0.37 * f64::from(i), 0.11 * f64::from(i), 0.0, 0.001 * f64::from(i)));
        assert!(all.into_iter().all(|weight| (0.0..=1.0).contains(&weight)));
        assert!((at(0.1, 0.1, 0.1, 1e6) - 0.5).abs() < 1e-4 && at(f64::MAX, 0.0, 0.0, 1.0).is_finite());
        // The footprint is centred on the edge of a cell.
        assert!((at(0.5, 0.25, 0.25, 0.1) - 0.5).abs() < 1e-12);
    }

    #[test]
    fn the_mean_is_that_of_many_points() {
        for (x, width) in [(0.3, 0.5), (1.9, 0.7), (-0.4, 3.3), (5.05, 0.2)] {
            let points = (0..10_000).map(|i| x + width * ((f64::from(i) + 0.5) / 10_000.0 - 0.5));
            let slow = points.map(|x| mean_sign(x, 0.0)).sum::<f64>() / 10_000.0;
            assert!((mean_sign(x, width) - slow).abs() < 1e-3, "{x} {width}");
        }
    }

    #[test]
    fn noise_marble_and_wood_are_weights_whose_mean_is_seen_from_afar() {
        for pattern in [
            Pattern::Noise { color: DVec3::X, size: 0.3 },
            Pattern::Marble { color: DVec3::X, size: 0.3 },
            Pattern::Wood { color: DVec3::X, size: 0.3 },
        ] {
            let points = || (0..40_000).map(|i| DVec3::new(0.0371, 0.0113, -0.0293) * f64::from(i) % 13.7);
            let at = |point: DVec3, width: f64| weight(&pattern, point, DVec3::splat(width), None);
            let values: Vec<f64> = points().map(|point| at(point, 0.0)).collect();
            assert!(values.iter().all(|value| (0.0..=1.0).contains(value)), "{pattern:?}");
            let mean = values.iter().sum::<f64>() / values.len() as f64;
            assert!((at(DVec3::ONE, 1.0) - mean).abs() < 0.04, "{pattern:?} {mean}");
            assert!(values.iter().any(|value| (value - mean).abs() > 0.15), "{pattern:?}");
            assert!(at(DVec3::splat(f64::MAX), 0.0).is_finite());
        }
    }

    #[test]
    fn a_gradient_goes_across_the_shape() {
        let gradient = Pattern::Gradient { color: DVec3::X, direction: DVec3::Z };
        let at = |z: f64| weight(&gradient, DVec3::Z * z, DVec3::ZERO, Some(&|_| 2.0));
        assert_eq!([at(-2.0), at(0.0), at(2.0)], [0.0, 0.5, 1.0]);
        let floor = |z: f64| weight(&gradient, DVec3::Z * z, DVec3::ZERO, None);
        assert_eq!(
            [floor(0.0), floor(0.25), floor(1.0), floor(2.0), floor(-0.5)],
            [0.0, 0.25, 1.0, 0.0, 0.5]
        );
    }
}
