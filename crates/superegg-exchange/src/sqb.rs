//! The binary scene file (.sqb): the text of a scene, and its tables of instances as columns.
//!
//! All numbers are little-endian. The file is the signature, then sections, each of a tag (4
//! bytes), the length of its payload (u64), the payload, and the XXH3-128 checksum of the payload
//! (16 bytes). A section `TABL` for each table, then `TEXT`, then `END ` with an empty payload.
//! The text has the language's commands for everything but the tables; it runs on a scene that has
//! them.

mod bytes;
mod layout;
mod read;
mod write;

pub use layout::{BinaryScene, SIGNATURE, SqbError};
pub use read::read;
pub use write::write;
