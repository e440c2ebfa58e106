//! Who made a file that an output would replace.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use anyhow::{Result, bail};
use superegg_render::{PartHeader, SOFTWARE};

use crate::files::access::{Overwrite, check_plain_file};
use crate::files::picture::PictureFormat;

/// Pictures name the program that made them within their first bytes.
const HEAD_BYTES: u64 = 4096;

/// Whether a file that is there and not empty bears no sign that this program made it: the name of
/// the program in a picture, or the first line of a partial file.
fn is_of_another_maker(path: &Path) -> bool {
    if !path.is_file() || path.metadata().is_ok_and(|metadata| metadata.len() == 0) {
        return false;
    }
    let mut head = Vec::new();
    let mut read = || File::open(path)?.take(HEAD_BYTES).read_to_end(&mut head);
    if check_plain_file(path).is_err() || read().is_err() {
        return true;
    }
    let is_picture = [PictureFormat::Png, PictureFormat::Exr]
        .into_iter()
        .any(|format| head.starts_with(format.signature()));
    let is_ours = is_picture && head.windows(SOFTWARE.len()).any(|bytes| bytes == SOFTWARE.as_bytes());
    !is_ours && !head.starts_with(PartHeader::FAMILY)
}

/// Checks the picture or partial file that an output would replace, before the work for it starts.
/// Returns the note about a file of another maker, if the user has named it.
///
/// # Errors
/// The output has the default name, which the user may not know, and the file is of another maker.
pub(crate) fn check_maker(path: &Path, is_default: bool, overwrite: Overwrite) -> Result<Option<String>> {
    if !is_of_another_maker(path) {
        return Ok(None);
    }
    let name = path.display();
    if is_default && overwrite == Overwrite::Writable {
        bail!("'{name}' is there already, and superegg did not make it");
    }
    Ok(Some(format!("'{name}' is replaced; superegg did not make it")))
}
