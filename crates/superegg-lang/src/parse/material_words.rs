//! Patterns and textures as the arguments of their commands.

use superegg_scene::{Pattern, Texture, TextureChannel};

use crate::parse::number::{format_number, vector};

/// The word and the numbers of a pattern.
pub(crate) fn pattern_words(pattern: &Pattern) -> String {
    let detail = match *pattern {
        Pattern::Gradient { direction, .. } => Some(vector(direction)),
        _ => pattern.size().map(format_number),
    };
    let parts = [Some(pattern.word().to_owned()), pattern.color().map(vector), detail];
    parts.into_iter().flatten().collect::<Vec<String>>().join(" ")
}

/// The arguments of a texture.
pub(crate) fn texture_words(channel: TextureChannel, texture: &Texture) -> String {
    let Texture { file, mapping, scale, height } = texture;
    let height = height.map(|height| format!(" {}", format_number(height))).unwrap_or_default();
    format!("{} \"{file}\" {} {}{height}", channel.word(), format_number(*scale), mapping.word())
}
