//! POV-Ray scenes: superellipsoids and spheres with plain transforms and colours, in unions and
//! declared objects; cameras, lights, a floor and the background.
//!
//! - Coordinates are kept if the camera is right-handed, as our own export writes it. For
//!   POV-Ray's usual left-handed camera the scene is mirrored, z -> -z, so that it looks as
//!   POV-Ray shows it.
//! - Rotations are turns about x, then y, then z; `matrix` holds the images of the axes.
//! - Variables, arithmetic, `#if`, `#while` and `#for` are carried out. Macros are not.
//! - A pattern becomes its first colour. What is not understood is skipped with a warning.

mod emit;
mod expression;
mod items;
mod lexer;
mod model;
mod parser;
mod value;

use super::error::ReadError;
use super::format::Format;
use super::options::ReadOptions;
use super::import::{Content, Import};

/// Words with a block that scenes of POV-Ray have.
const BLOCKS: [&str; 12] = [
    "superellipsoid",
    "sphere",
    "camera",
    "light_source",
    "union",
    "merge",
    "object",
    "global_settings",
    "background",
    "intersection",
    "difference",
    "plane",
];

/// The format, if these first bytes are of a POV-Ray scene: a known word with a block, or a
/// directive that only POV-Ray has.
pub(crate) fn recognize(head: &[u8]) -> Result<Option<Format>, ReadError> {
    let text = String::from_utf8_lossy(head);
    let has_directive = text.lines().any(|line| {
        let line = line.trim_start();
        line.starts_with("#declare ") || (line.starts_with("#version ") && line.trim_end().ends_with(';'))
    });
    let has_block = BLOCKS.iter().any(|word| {
        text.match_indices(word).any(|(at, _)| {
            let before = text[..at].chars().next_back();
            let is_start = before.is_none_or(|c| !(c.is_alphanumeric() || matches!(c, '_' | '"' | '\'')));
            is_start && text[at + word.len()..].trim_start().starts_with('{')
        })
    });
    Ok((has_directive || has_block).then_some(Format::Povray))
}

/// Reads a scene as lines of the modelling language.
///
/// # Errors
/// A comment, text or brace has no end, the loops of the scene do not end, or it has no shape that
/// is read.
pub(crate) fn read(bytes: &[u8], _options: &ReadOptions) -> Result<Import, ReadError> {
    // Old scenes have names in other encodings than UTF-8.
    let text = String::from_utf8_lossy(bytes);
    let tokens = lexer::tokens(text.strip_prefix('\u{feff}').unwrap_or(&text))?;
    let mut parser = parser::Parser::new(tokens);
    parser.run()?;
    let mut warnings = parser.take_warnings();
    if parser.scene.objects.is_empty() {
        let detail = warnings.first().map_or(String::new(), |warning| format!(" ({warning})"));
        return Err(ReadError::File(format!("the scene shows no superellipsoid or sphere{detail}")));
    }
    let is_left = emit::is_left_handed(&parser.scene.camera.unwrap_or_default());
    let (script, more) = emit::script_of(&parser.scene, parser.ambient_light, parser.uses_picture_size);
    warnings.extend(more);
    let handed = match (is_left, parser.scene.camera.is_some()) {
        (true, true) => "the camera is left-handed, so z is mirrored",
        (true, false) => "POV-Ray's own camera is left-handed, so z is mirrored",
        (false, _) => "the camera is right-handed, so coordinates are kept",
    };
    let reading = format!("a POV-Ray scene: superellipsoid <e, n> of half width 1; {handed}");
    Ok(Import { warnings, ..Import::new(Content::Script(script), reading) })
}
