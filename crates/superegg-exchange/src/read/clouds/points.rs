//! Points as spheres.

use superegg_geom::glam::{DQuat, DVec3};

use crate::read::error::ReadError;
use crate::read::options::ReadOptions;
use crate::read::particles::Particles;
use crate::read::spacing;

/// The points as spheres of one radius, with that radius.
///
/// # Errors
/// A coordinate is not finite, or the radius of the options is not above 0.
pub(crate) fn spheres(points: Vec<DVec3>, options: &ReadOptions) -> Result<(Particles, f64), ReadError> {
    if let Some(index) = points.iter().position(|point| !point.is_finite()) {
        let message = format!("expected finite coordinates, found {}", points[index]);
        return Err(ReadError::part(format!("point {index}"), message));
    }
    let radius = options.point_radius.unwrap_or_else(|| spacing::point_radius(&points));
    if !(radius > 0.0 && radius.is_finite()) {
        return Err(ReadError::File(format!("the radius of points must be above 0, found {radius}")));
    }
    let count = points.len();
    let particles = Particles {
        positions: points,
        radii: vec![DVec3::splat(radius); count],
        exponents: vec![[1.0, 1.0]; count],
        rotations: vec![DQuat::IDENTITY; count],
        ..Particles::default()
    };
    Ok((particles, radius))
}
