//! The parts of a binary scene file, and why a file is none.

use superegg_scene::InstanceTable;
use thiserror::Error;

/// The first bytes of a file: the name, the version, and a line end that text transfer would break.
pub const SIGNATURE: [u8; 8] = *b"sqb\x00v1\r\n";

pub(super) const TABLE: [u8; 4] = *b"TABL";
pub(super) const TEXT: [u8; 4] = *b"TEXT";
pub(super) const END: [u8; 4] = *b"END ";

/// The bits of a table's flags: whether it has ids, and whether its materials have facets.
pub(super) const HAS_IDS: u32 = 1;
pub(super) const HAS_FACETS: u32 = 2;

/// A scene as its file holds it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BinaryScene {
    /// The commands of everything but the tables.
    pub text: String,
    /// The tables with their names.
    pub tables: Vec<(String, InstanceTable)>,
}

/// Why a file is no binary scene.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum SqbError {
    /// The stream cannot be read.
    #[error(transparent)]
    Io(#[from] std::io::Error),
    /// The file does not begin with [`SIGNATURE`].
    #[error("it is no .sqb file of version 1")]
    Signature,
    /// The file ends within a section, or lacks one.
    #[error("it is incomplete: it ends within section {0}")]
    Incomplete(u32),
    /// A checksum does not fit.
    #[error("it is damaged: the checksum of section {0} is wrong")]
    Checksum(u32),
    /// The content of a section is wrong.
    #[error("section {section}: {message}")]
    Section {
        /// The section, counted from 1.
        section: u32,
        /// The fault, in words.
        message: String,
    },
}
