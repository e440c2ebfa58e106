//! Tensors at points, as superquadric glyphs.

use superegg_geom::glam::{DMat3, DVec3};

use super::check;
use super::error::ReadError;
use super::glyph::{GAMMA, Glyph, THINNEST, glyph};
use super::import::{Content, Import};
use super::options::ReadOptions;
use super::particles::Particles;
use super::spacing::point_radius;
use super::vtk_columns::row_error;

/// Tensors at points.
#[derive(Clone, Debug, Default)]
pub(super) struct TensorField {
    /// The name of the array, for messages.
    pub(super) name: String,
    /// The points.
    pub(super) positions: Vec<DVec3>,
    /// The tensors.
    pub(super) tensors: Vec<DMat3>,
    /// The distance of neighbours; estimated from the points if `None`.
    pub(super) spacing: Option<f64>,
    /// Further columns.
    pub(super) extra: Vec<(String, Vec<f64>)>,
    /// The time or time step.
    pub(super) step: Option<f64>,
    /// Parts that were left out or cannot be trusted.
    pub(super) warnings: Vec<String>,
}

/// The glyphs of a field, scaled so that the largest one is as wide as the spacing of the points.
///
/// # Errors
/// A number is not finite, or the numbers are rotations.
pub(super) fn import(mut field: TensorField, options: &ReadOptions) -> Result<Import, ReadError> {
    check(&field)?;
    let glyphs: Vec<Option<Glyph>> = field.tensors.iter().map(|tensor| glyph(*tensor)).collect();
    let largest = glyphs.iter().flatten().map(|glyph| glyph.radii.max_element()).fold(0.0, f64::max);
    let spacing = field.spacing.filter(|spacing| *spacing > 0.0 && spacing.is_finite());
    let spacing = spacing.or_else(|| median_spacing(&field.positions));
    // Where there is one point alone, eigenvalues are the semi-axes.
    let scale = spacing.map_or(1.0, |spacing| spacing * 0.5 / largest);
    if largest > 0.0 && !(scale > 0.0 && scale.is_finite()) {
        let message = format!("eigenvalues up to {largest} cannot be scaled to the points' spacing");
        return Err(ReadError::part(field.name, message));
    }
    count_warnings(&mut field, &glyphs);
    let mut particles = Particles { step: field.step, ..Particles::default() };
    for (position, glyph) in field.positions.iter().zip(&glyphs) {
        if let Some(glyph) = glyph {
            let radii = glyph.radii * scale;
            let part = |message: String| ReadError::part(&field.name, message);
            let radii = check::semi_axes(radii, options).map_err(part)?;
            let [e, n] = glyph.exponents;
            particles.push(*position, radii, check::exponents(e, n).map_err(part)?, glyph.rotation);
        }
    }
    let is_drawn: Vec<bool> = glyphs.iter().map(Option::is_some).collect();
    for (name, column) in field.extra {
        let kept = column.into_iter().zip(&is_drawn).filter(|(_, is_drawn)| **is_drawn);
        particles.extra.push((name, kept.map(|(number, _)| number).collect()));
    }
    let fit = spacing.map_or_else(String::new, |spacing| {
        format!(" times {scale:.6e}, so that the largest glyph fits the spacing {spacing}")
    });
    let reading = format!(
        "tensors '{}' as Kindlmann's superquadric glyphs, gamma {GAMMA}; semi-axes are eigenvalues{fit}",
        field.name
    );
    Ok(Import { content: Content::Particles(particles), reading, warnings: field.warnings })
}

/// Rejects numbers that are not finite, and fields of rotations.
fn check(field: &TensorField) -> Result<(), ReadError> {
    for (row, (tensor, position)) in field.tensors.iter().zip(&field.positions).enumerate() {
        if !tensor.is_finite() || !position.is_finite() {
            return Err(row_error(&field.name, row, "a number is not finite"));
        }
    }
    let is_rotation = |tensor: &DMat3| (tensor.transpose() * *tensor).abs_diff_eq(DMat3::IDENTITY, 1e-3);
    let all_turn = !field.tensors.is_empty() && field.tensors.iter().all(is_rotation);
    if all_turn && field.tensors.iter().any(|tensor| asymmetry(tensor) > 1e-3) {
        let message =
            "the array holds rotations, not tensors; a file of particles has shapex, shapey, shapez too";
        return Err(ReadError::part(&field.name, message));
    }
    Ok(())
}

/// The greatest difference of a tensor and its transpose, in its greatest number.
fn asymmetry(tensor: &DMat3) -> f64 {
    let largest = |matrix: &DMat3| matrix.to_cols_array().iter().fold(0.0f64, |most, x| most.max(x.abs()));
    let size = largest(tensor);
    if size > 0.0 { largest(&(*tensor * (1.0 / size) - tensor.transpose() * (1.0 / size))) } else { 0.0 }
}

fn count_warnings(field: &mut TensorField, glyphs: &[Option<Glyph>]) {
    let mut warn = |count: usize, text: &str| {
        if count > 0 {
            field.warnings.push(format!("{count} of {} tensors {text}", glyphs.len()));
        }
    };
    warn(glyphs.iter().filter(|glyph| glyph.is_none()).count(), "are 0 and have no glyph");
    let count = |has: fn(&Glyph) -> bool| glyphs.iter().flatten().filter(|glyph| has(glyph)).count();
    warn(count(|glyph| glyph.is_negative), "have negative eigenvalues: their absolute values count");
    let thin = format!("are flat: their smallest semi-axes are raised to {THINNEST:e} of the largest");
    warn(count(|glyph| glyph.is_flat), &thin);
    let unsymmetric = field.tensors.iter().filter(|tensor| asymmetry(tensor) > 1e-6).count();
    warn(unsymmetric, "are not symmetric: their symmetric parts count");
}

/// The median distance of nearest neighbours; `None` if all points lie in one place.
fn median_spacing(points: &[DVec3]) -> Option<f64> {
    let first = points.first()?;
    points.iter().any(|point| point != first).then(|| 2.0 * point_radius(points))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn field(tensors: Vec<DMat3>) -> TensorField {
        let positions = (0..tensors.len()).map(|at| DVec3::X * at as f64).collect();
        TensorField { name: "T".to_owned(), positions, tensors, ..TensorField::default() }
    }

    fn particles(import: Import) -> Particles {
        match import.content {
            Content::Particles(particles) => particles,
            Content::Script(_) => panic!("particles are expected"),
        }
    }

    #[test]
    fn the_largest_glyph_is_as_wide_as_the_spacing() {
        let tensors = vec![
            DMat3::from_diagonal(DVec3::new(3.0, 1.0, 1.0)),
            DMat3::IDENTITY * 4.0,
            DMat3::ZERO,
            DMat3::from_diagonal(DVec3::new(2.0, 2.0, -1.0)),
        ];
        let mut field = field(tensors);
        field.extra.push(("row".to_owned(), vec![0.0, 1.0, 2.0, 3.0]));
        let import = import(field, &ReadOptions::default()).unwrap();
        assert!(import.reading.contains("fits the spacing 1"), "{}", import.reading);
        assert_eq!(import.warnings.len(), 2, "{:?}", import.warnings);
        let particles = particles(import);
        assert_eq!(particles.radii[1], DVec3::splat(0.5));
        assert_eq!(particles.radii[0], DVec3::new(0.125, 0.125, 0.375));
        assert_eq!(particles.positions[2], DVec3::X * 3.0);
        assert_eq!(particles.extra[0].1, [0.0, 1.0, 3.0]);
    }

    #[test]
    fn rotations_and_numbers_that_are_not_finite_are_errors() {
        let turn = DMat3::from_rotation_z(0.4);
        let error = import(field(vec![DMat3::IDENTITY, turn]), &ReadOptions::default()).unwrap_err();
        assert!(error.to_string().contains("rotations"), "{error}");
        assert!(import(field(vec![DMat3::IDENTITY; 3]), &ReadOptions::default()).is_ok());
        let nan = DMat3::IDENTITY * f64::NAN;
        let error = import(field(vec![DMat3::IDENTITY, nan]), &ReadOptions::default()).unwrap_err();
        assert!(error.to_string().contains("row 2"), "{error}");
    }

    #[test]
    fn spacing_of_points() {
        let grid: Vec<DVec3> =
            (0..60).map(|at| DVec3::new((at % 4) as f64, (at / 4 % 5) as f64, (at / 20) as f64)).collect();
        assert_eq!(median_spacing(&grid), Some(1.0));
        assert_eq!(median_spacing(&[DVec3::ONE]), None);
        assert_eq!(median_spacing(&[DVec3::ONE; 7]), None);
        assert_eq!(median_spacing(&[]), None);
        let alone = particles(import(field(vec![DMat3::IDENTITY * 2.0]), &ReadOptions::default()).unwrap());
        assert_eq!(alone.radii, [DVec3::splat(2.0)]);
    }
}
