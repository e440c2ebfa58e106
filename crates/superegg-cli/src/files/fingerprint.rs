//! The text of a picture for checksums: kept frames, shards and resumed renders belong together only where it is equal.

use std::collections::HashMap;
use std::path::Path;
use std::sync::Arc;

use superegg_lang::{fingerprint_text, picture_files};
use superegg_scene::Scene;

use crate::files::{self, names};

/// Hashes of the picture files that the scenes of one folder name. Each file is read once.
pub(crate) struct PictureHashes<'a> {
    folder: Option<&'a Path>,
    /// `None` for files that cannot be read.
    known: HashMap<Arc<str>, Option<u64>>,
}

impl<'a> PictureHashes<'a> {
    pub(crate) fn new(folder: Option<&'a Path>) -> Self {
        Self { folder, known: HashMap::new() }
    }

    /// The text of a scene, with a line for the content of each picture file that it names. Files that cannot be read are
    /// left out: the render reports them.
    pub(crate) fn text_of_picture(&mut self, scene: &Scene, selected: Option<&str>) -> String {
        let mut text = fingerprint_text(scene, selected);
        for name in picture_files(scene).into_keys() {
            let read = || files::read(&names::found(&name, self.folder)).ok().map(|content| hash(&content));
            if let Some(hash) = *self.known.entry(Arc::clone(&name)).or_insert_with(read) {
                text += &format!("# picture {name} {hash:016x}\n");
            }
        }
        text
    }
}

/// The 64-bit FNV-1a hash (Fowler, Noll, Vo). It is stable between versions, and detects accidents,
/// not attacks.
pub(crate) fn hash(bytes: &[u8]) -> u64 {
    bytes
        .iter()
        .fold(0xcbf2_9ce4_8422_2325, |hash, byte| (hash ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_hash_is_the_published_one() {
        assert_eq!(
            (hash(b""), hash(b"a"), hash(b"foobar")),
            (0xcbf29ce484222325, 0xaf63dc4c8601ec8c, 0x85944171f73967e8)
        );
    }
}
