//! Choices of a reader.

use super::column_map::ColumnMap;
use super::format::Format;

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
