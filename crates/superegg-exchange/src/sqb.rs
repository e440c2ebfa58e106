//! The binary scene file (.sqb): the text of a scene, and its tables of instances as columns.
//!
//! All numbers are little-endian. The file is the signature, then sections, each of a tag (4
//! bytes), the length of its payload (u64), the payload, and the XXH3-128 checksum of the payload
//! (16 bytes). A section `TABL` for each table, then `TEXT`, then `END ` with an empty payload.
//! The text has the language's commands for everything but the tables; it runs on a scene that has
//! them.

mod bytes;
mod read;
mod write;

use superegg_scene::InstanceTable;
use thiserror::Error;

pub use read::read;
pub use write::write;

/// The first bytes of a file: the name, the version, and a line end that text transfer would break.
pub const SIGNATURE: [u8; 8] = *b"sqb\x00v1\r\n";

const TABLE: [u8; 4] = *b"TABL";
const TEXT: [u8; 4] = *b"TEXT";
const END: [u8; 4] = *b"END ";

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
        /// What is wrong with it.
        message: String,
    },
}
