//! The result of every writer.

use superegg_geom::{MeshError, TransformError};
use thiserror::Error;

/// The content of a file, or of two.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Written {
    /// The file.
    pub bytes: Vec<u8>,
    /// The file beside it, such as the materials (.mtl) of an .obj.
    pub companion: Option<Vec<u8>>,
    /// The losses of the format or this writer, one sentence each.
    pub losses: Vec<String>,
}

/// Why a scene cannot be written in a format.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum WriteError {
    /// Nothing has this name.
    #[error("nothing is named '{0}'")]
    Unknown(String),
    /// No instance is below the root.
    #[error("'{0}' has no instance of a primitive, so there is nothing to write")]
    Empty(String),
    /// There are too many instances.
    #[error(
        "opened {depth} levels deep the scene has {count} instances, and at most {most} can be written; take fewer levels (--depth)"
    )]
    TooManyInstances {
        /// The recursion depth.
        depth: u32,
        /// The number of instances, or u64::MAX for more than that.
        count: u64,
        /// The most instances.
        most: u64,
    },
    /// The meshes have too many triangles together.
    #[error(
        "the meshes have {count} triangles, and at most {most} can be written; a tolerance of {possible:.2e} instead of {tolerance:e} is possible"
    )]
    TooManyTriangles {
        /// The number of triangles.
        count: u64,
        /// The most triangles.
        most: u64,
        /// The tolerance.
        tolerance: f64,
        /// About the least tolerance that is possible.
        possible: f64,
    },
    /// A shape has no mesh of this tolerance.
    #[error("{name}: {error}")]
    Mesh {
        /// The primitive.
        name: String,
        /// The reason.
        error: MeshError,
    },
    /// A transform leaves the range of numbers.
    #[error("{path}: {error}")]
    Transform {
        /// The path of the instance.
        path: String,
        /// The reason.
        error: TransformError,
    },
    /// There is no such grid.
    #[error("{0}")]
    Grid(String),
    /// A number is too large for the format.
    #[error("{path}: a coordinate is too large for the numbers of the format; scale the scene down")]
    Range {
        /// The path of the instance.
        path: String,
    },
}
