//! Patterns that blend the colour of a surface with a second colour.

use superegg_geom::glam::DVec3;
use superegg_geom::unit_vector;
use superegg_scene::Pattern;

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
    }
}

/// Blends a colour with that of the pattern.
pub(crate) fn mix(color: DVec3, pattern: &Pattern, weight: f64) -> DVec3 {
    match pattern {
        Pattern::None => color,
        Pattern::Checker { color: other, .. } | Pattern::Gradient { color: other, .. } => {
            color.lerp(*other, weight)
        }
    }
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
