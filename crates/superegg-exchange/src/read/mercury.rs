//! VTU files of MercuryDPM.
//!
//! axesScales are full widths, phiAndTheta = (e, n), orientationTensor has nine numbers row by row,
//! from body to world. Source: MercuryDPM's writer of superquadrics.

use superegg_geom::glam::{DMat3, DQuat, DVec3};

use super::check;
use super::error::ReadError;
use super::import::{Content, Import};
use super::options::ReadOptions;
use super::particles::Particles;
use super::vtk::{self, DataSet};
use super::vtk_columns::{extra_columns, is_asked_for, required, row_error, rows_of};

const AXES: &str = "axesScales";
const EXPONENTS: &str = "phiAndTheta";
const ORIENTATION: &str = "orientationTensor";

fn is_own(name: &str) -> bool {
    [AXES, EXPONENTS, ORIENTATION].contains(&name)
}

/// Whether a file with these arrays comes from MercuryDPM.
pub(super) fn is_mercury(outline: &DataSet) -> bool {
    [AXES, ORIENTATION].iter().any(|name| outline.array(name).is_some())
}

/// Reads one file.
///
/// # Errors
/// The file is wrong, or an array is missing.
pub(super) fn read(bytes: &[u8], options: &ReadOptions) -> Result<Import, ReadError> {
    let wanted = |name: &str, components| is_own(name) || is_asked_for(options, name, components);
    let data = vtk::read(bytes, &wanted)?;
    let mut warnings = Vec::new();
    let widths = required::<3>(&data, AXES)?;
    let exponents = required::<2>(&data, EXPONENTS)?;
    let orientations = rows_of::<9>(&data, ORIENTATION)?;
    if orientations.is_none() {
        warnings.push(format!("the file has no {ORIENTATION}: particles are not turned"));
    }
    let mut particles = Particles { step: data.step, ..Particles::default() };
    for (row, ((point, widths), pair)) in data.points.iter().zip(widths).zip(exponents).enumerate() {
        let part = |name: &'static str| move |message: String| row_error(name, row, message);
        let position = check::position(*point).map_err(part("Points"))?;
        let radii = check::semi_axes(DVec3::from_array(*widths) * 0.5, options).map_err(part(AXES))?;
        let exponents = check::exponents(pair[0], pair[1]).map_err(part(EXPONENTS))?;
        let rotation = match orientations.map(|rows| rows[row]) {
            None => DQuat::IDENTITY,
            Some(numbers) => {
                let matrix = DMat3::from_cols_array(&numbers).transpose();
                check::rotation_of_matrix(matrix).map_err(part(ORIENTATION))?
            }
        };
        particles.push(position, radii, exponents, rotation);
    }
    particles.extra = extra_columns(&data, options)?;
    let reading = "sizes from axesScales as full widths; exponents (e, n) from phiAndTheta; rotation from \
        orientationTensor, row by row, body to world";
    Ok(Import { content: Content::Particles(particles), reading: reading.to_owned(), warnings })
}
