//! The picture files that lines and scenes name: of the surroundings, and on surfaces.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::Arc;

use superegg_scene::{Entity, EnvironmentLight, Scene, TextureChannel};

use crate::grammar::command::{Command, PrimitiveCommand, SceneCommand};
use crate::parse::parser::{Parsed, parse_line};
use crate::session::keys::line_of;

/// The use of a picture file in a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PictureUse {
    /// As the surroundings.
    Environment,
    /// On a surface.
    Texture(TextureChannel),
}

/// A picture file that a line names.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct NamedPicture {
    /// The name of the file.
    pub file: Arc<str>,
    /// The use of the picture.
    pub used_as: PictureUse,
    /// The columns of the name in the line, with its quotes.
    pub columns: Range<usize>,
}

/// The spellings of commands that may name a picture. Other lines, which are nearly all, need not be parsed.
const SPELLINGS: [&str; 4] = ["environment", "setTexture", "texture", "key"];

/// Whether a line may name a picture, by its first word.
pub(crate) fn may_name_picture(line: &str) -> bool {
    let first = line.split_whitespace().next().unwrap_or_default();
    SPELLINGS.iter().any(|spelling| first.eq_ignore_ascii_case(spelling))
}

/// The picture file that a line names, for the scene or for a key of it; `None` for any other line, valid or not.
///
/// ```
/// use superegg_lang::{PictureUse, picture_of_line};
/// use superegg_scene::TextureChannel;
///
/// let named = picture_of_line("key 8 setTexture bump 'dents.png' 1 box 0.2".replace('\'', "\"").as_str()).unwrap();
/// assert_eq!((&*named.file, named.columns), ("dents.png", 22..33));
/// assert_eq!(named.used_as, PictureUse::Texture(TextureChannel::Bump));
/// assert_eq!(picture_of_line("setTexture color none"), None);
/// ```
pub fn picture_of_line(line: &str) -> Option<NamedPicture> {
    if !may_name_picture(line) {
        return None;
    }
    let parsed = parse_line(line).ok()??;
    let parsed: &Parsed = parsed.keyed.as_deref().unwrap_or(&parsed);
    let (file, used_as, word) = match &parsed.command {
        Command::Scene(SceneCommand::SetEnvironment(picture)) => (&picture.file, PictureUse::Environment, 1),
        Command::Primitive(PrimitiveCommand::SetTexture { channel, texture }) => {
            (&texture.as_ref()?.file, PictureUse::Texture(*channel), 2)
        }
        _ => return None,
    };
    Some(NamedPicture { file: Arc::clone(file), used_as, columns: parsed.word_columns(word) })
}

/// A line with another name for the picture that it names. `new_name` returns `None` for a name that stays.
///
/// ```
/// let far = |name: &str| Some(format!("../{name}"));
/// assert_eq!(superegg_lang::rename_in_line("texture color a.png 2 # red", far), "texture color \"../a.png\" 2 # red");
/// assert_eq!(superegg_lang::rename_in_line("prm a.png", far), "prm a.png");
/// ```
pub fn rename_in_line(line: &str, new_name: impl FnOnce(&str) -> Option<String>) -> Cow<'_, str> {
    let renamed = picture_of_line(line).and_then(|named| Some((new_name(&named.file)?, named.columns)));
    let Some((name, columns)) = renamed else { return Cow::Borrowed(line) };
    let before: String = line.chars().take(columns.start).collect();
    let after: String = line.chars().skip(columns.end).collect();
    Cow::Owned(format!("{before}\"{name}\"{after}"))
}

/// The picture files that a scene and its keys name, by name, with each use once.
pub fn picture_files(scene: &Scene) -> BTreeMap<Arc<str>, Vec<PictureUse>> {
    let mut files = BTreeMap::<_, Vec<PictureUse>>::new();
    let mut add = |file: &Arc<str>, used_as| {
        let uses = files.entry(Arc::clone(file)).or_default();
        if !uses.contains(&used_as) {
            uses.push(used_as);
        }
    };
    if let Some(EnvironmentLight::Picture(picture)) = &scene.environment {
        add(&picture.file, PictureUse::Environment);
    }
    for (_, entity) in scene.entities() {
        let Entity::Primitive(primitive) = entity else { continue };
        let textures = primitive.textures.iter().flat_map(|textures| textures.all());
        textures.for_each(|(channel, texture)| add(&texture.file, PictureUse::Texture(channel)));
    }
    for track in scene.tracks() {
        // The keys of a track name the same file.
        let line = track.keys().next().map(|key| line_of(track.subject(), &key.numbers));
        if let Some(named) = line.as_deref().and_then(picture_of_line) {
            add(&named.file, named.used_as);
        }
    }
    files
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grammar::spec::{ArgKind, Build, CommandSpec};
    use crate::grammar::table::COMMANDS;
    use crate::session::script::load_text;

    #[test]
    fn the_spellings_are_those_of_the_table() {
        let names_picture = |spec: &CommandSpec| {
            let takes_file = spec.all_args().any(|arg| arg.kind == ArgKind::File);
            spec.takes_line() || (takes_file && !matches!(spec.build, Build::Request(_)))
        };
        let specs = COMMANDS.iter().filter(|spec| names_picture(spec));
        let mut found: Vec<&str> = specs.flat_map(CommandSpec::all_spellings).collect();
        found.sort_unstable_by_key(|spelling| SPELLINGS.iter().position(|known| known == spelling));
        assert_eq!(found, SPELLINGS);
    }

    #[test]
    fn files_of_keys_are_files_of_the_scene() {
        let text = "environment a.hdr\nkey 3 environment \"b c.hdr\" 20\nkey 0 xs 1 0 0\nprm p\ntexture color d.png\n\
            key 3 texture bump e.png 2\nkey 9 texture bump e.png 4\nprm q\ntexture bump d.png\ntexture color d.png\n";
        let (session, _) = load_text("s.scn", text);
        let files = picture_files(session.scene());
        assert_eq!(
            files.keys().map(|file| &**file).collect::<Vec<_>>(),
            ["a.hdr", "b c.hdr", "d.png", "e.png"]
        );
        let texture = PictureUse::Texture;
        assert_eq!(files["b c.hdr"], [PictureUse::Environment]);
        assert_eq!(files["d.png"], [texture(TextureChannel::Color), texture(TextureChannel::Bump)]);
        assert_eq!(files["e.png"], [texture(TextureChannel::Bump)]);
    }
}
