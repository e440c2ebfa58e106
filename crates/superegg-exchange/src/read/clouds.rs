//! Point clouds, shown as small spheres: PLY files and NumPy arrays.

mod npy_points;
mod ply;
mod points;

use super::error::ReadError;
use super::format::Format;

pub(crate) use npy_points::read as read_npy;
pub(crate) use ply::{is_ply, read as read_ply, read_triangles as read_ply_triangles};

/// The format of a file with these first bytes, if it is a point cloud.
pub(crate) fn recognize(head: &[u8]) -> Result<Option<Format>, ReadError> {
    let format = ply::recognize(head).or_else(|| npy_points::recognize(head));
    // Eleven points are three vectors of eleven numbers as well, which fits::recognize tells.
    Ok(format.filter(|_| !npy_points::is_ambiguous(head)))
}
