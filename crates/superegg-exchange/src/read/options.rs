//! Choices of a reader.

use super::error::ReadError;
use super::format::Format;

/// The columns of a table, by name, for tables of no known program (`--columns`).
///
/// Written as `semi-axes=a,b,c;exponents=e,n;position=x,y,z;quaternion=w,x,y,z`.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ColumnMap {
    /// The pairs of a quantity and the names of its columns, in the order given.
    pub assignments: Vec<(String, Vec<String>)>,
}

/// Choices of a reader.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ReadOptions {
    /// The format; recognized from the content if `None`.
    pub from: Option<Format>,
    /// The columns of a plain table.
    pub columns: Option<ColumnMap>,
    /// The names of the numeric columns to keep in [`super::Particles::extra`], as in the file;
    /// names of columns that the file lacks are errors that list those it has.
    pub extra: Vec<String>,
    /// Keep all numeric columns.
    pub all_extra: bool,
    /// Semi-axes below this are raised to it; if `None`, a semi-axis that is not above 0 is an
    /// error.
    pub min_axis: Option<f64>,
    /// The radius of the spheres that stand for points; chosen from their spacing if `None`.
    pub point_radius: Option<f64>,
}

impl std::str::FromStr for ColumnMap {
    type Err = ReadError;

    /// Reads `quantity=column,column;quantity=column`.
    fn from_str(text: &str) -> Result<Self, ReadError> {
        let assignment = |part: &str| {
            let (quantity, columns) = part.split_once('=')?;
            let columns: Vec<String> = columns.split(',').map(|name| name.trim().to_owned()).collect();
            let is_complete = !quantity.trim().is_empty() && columns.iter().all(|name| !name.is_empty());
            is_complete.then(|| (quantity.trim().to_ascii_lowercase(), columns))
        };
        let parts = text.split(';').filter(|part| !part.trim().is_empty());
        let assignments: Option<Vec<_>> = parts.map(assignment).collect();
        match assignments {
            Some(assignments) if !assignments.is_empty() => Ok(Self { assignments }),
            Some(_) | None => Err(ReadError::File(
                "expected quantities and columns, such as position=x,y,z;semi-axes=a,b,c".to_owned(),
            )),
        }
    }
}
