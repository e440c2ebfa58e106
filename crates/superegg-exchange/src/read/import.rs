//! The content of a frame of a file, and the streams that files are read from.

use std::io::{Read, Seek};

use super::particles::Particles;

/// A stream that readers take: a file, or bytes in a `Cursor`.
pub trait Input: Read + Seek {}

impl<T: Read + Seek> Input for T {}

/// The content of a frame of a file.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
#[expect(clippy::large_enum_variant, reason = "one value a file")]
pub enum Content {
    /// Superquadrics as columns.
    Particles(Particles),
    /// Lines of the modelling language: a scene with objects, lights or a camera.
    Script(String),
}

/// One frame as read.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Import {
    /// The content of the frame.
    pub content: Content,
    /// How the numbers were read, for example "sizes as semi-axes, exponents e = 2/blockiness2,
    /// n = 2/blockiness1, rotation from quat1..4". One line.
    pub reading: String,
    /// Parts that were skipped or cannot be trusted, one line each.
    pub warnings: Vec<String>,
}

impl Import {
    /// An import without warnings.
    pub fn new(content: Content, reading: impl Into<String>) -> Self {
        Self { content, reading: reading.into(), warnings: Vec::new() }
    }
}
