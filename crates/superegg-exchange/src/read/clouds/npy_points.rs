//! A NumPy array of points.

use superegg_geom::glam::DVec3;

use super::points;
use crate::read::arrays::numpy;
use crate::read::error::ReadError;
use crate::read::format::Format;
use crate::read::import::{Content, Import};
use crate::read::options::ReadOptions;

/// The format, if these first bytes are an array of points.
pub(crate) fn recognize(head: &[u8]) -> Option<Format> {
    let shape = numpy::shape_of(head)?;
    matches!(shape[..], [_, 3] | [3]).then_some(Format::NpyPoints)
}

/// Whether an array of points may be fits as well: 11 points are 3 vectors of 11 numbers.
pub(crate) fn is_ambiguous(head: &[u8]) -> bool {
    numpy::shape_of(head).is_some_and(|shape| shape == [11, 3])
}

/// Reads an array of shape (N, 3), or (3) for one point.
///
/// # Errors
/// The file is no array of numbers of that shape, or a coordinate is not finite.
pub(crate) fn read(bytes: &[u8], options: &ReadOptions) -> Result<Import, ReadError> {
    let array = numpy::read(bytes, "array")?.numbers("array")?;
    if !matches!(array.shape[..], [_, 3] | [3]) {
        let message = format!("expected points of shape (N, 3), found {}", array.shape_text());
        return Err(ReadError::part("array", message));
    }
    let points = array.values.chunks_exact(3).map(DVec3::from_slice).collect();
    let (particles, radius) = points::spheres(points, options)?;
    let reading = format!("{} points, as spheres of radius {radius}", particles.len());
    Ok(Import::new(Content::Particles(particles), reading))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::read::arrays::numpy::tests::{npy, npy_f64};

    #[test]
    fn rows_are_points() {
        let options = ReadOptions { point_radius: Some(0.5), ..ReadOptions::default() };
        let bytes = npy_f64("(2, 3)", &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
        assert_eq!(recognize(&bytes), Some(Format::NpyPoints));
        let Content::Particles(particles) = read(&bytes, &options).unwrap().content else { unreachable!() };
        assert_eq!(particles.positions, [DVec3::new(1.0, 2.0, 3.0), DVec3::new(4.0, 5.0, 6.0)]);
        assert_eq!(particles.radii, [DVec3::splat(0.5); 2]);
        let fortran = npy("'|i1'", true, "(2, 3)", &[1, 4, 2, 5, 3, 6]);
        let Content::Particles(same) = read(&fortran, &options).unwrap().content else { unreachable!() };
        assert_eq!(same, particles);
        assert_eq!(recognize(&npy_f64("(3, 2)", &[0.0; 6])), None);
        assert!(read(&npy_f64("(3, 2)", &[0.0; 6]), &options).is_err());
        let message = read(&npy_f64("(1, 3)", &[0.0, f64::NAN, 0.0]), &options).unwrap_err().to_string();
        assert!(message.starts_with("'point 0': expected finite"), "{message}");
    }
}
