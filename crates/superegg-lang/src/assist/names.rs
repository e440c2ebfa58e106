//! The known names of each kind, and the argument at a position in a line.

use superegg_scene::Entity;

use crate::grammar::spec::{Arg, CommandSpec, NameKind};
use crate::grammar::table::COMMANDS;
use crate::parse::number::parse_number;
use crate::parse::words::Word;
use crate::session::help::help_words;
use crate::session::interpreter::Session;
use crate::session::keys::key_frames;
use crate::session::settings::SETTINGS;

/// Every existing name of a kind, in the order of the scene or the table.
pub(crate) fn names_of(session: &Session, of: NameKind) -> Vec<&str> {
    let scene = session.scene();
    match of {
        NameKind::New => Vec::new(),
        NameKind::Primitive | NameKind::PrimitiveOrNew => scene.primitives().map(|(name, _)| name).collect(),
        NameKind::Object | NameKind::ObjectOrNew => {
            let objects = scene.objects().map(|(name, _)| name);
            objects.chain(scene.tables().map(|(name, _)| name)).collect()
        }
        NameKind::Entity => scene.entities().map(|(name, _)| name).collect(),
        NameKind::Child => {
            let selected = session.selected().and_then(|name| scene.object(name).ok());
            selected.into_iter().flat_map(superegg_scene::Object::children).map(|(alias, _)| alias).collect()
        }
        NameKind::HiddenChild => {
            let selected = session.selected().and_then(|name| scene.object(name).ok());
            selected.into_iter().flat_map(superegg_scene::Object::hidden_children).collect()
        }
        NameKind::Light => scene.named_lights().map(|(name, _)| name).collect(),
        NameKind::Command => COMMANDS.iter().map(|spec| spec.name).collect(),
        NameKind::HelpWord => help_words().collect(),
        NameKind::Setting => SETTINGS.iter().map(|spec| spec.name).collect(),
        // Frames are not completed: there may be thousands.
        NameKind::KeyFrame => vec!["all"],
    }
}

/// Whether a name of a kind exists; cheaper than listing them.
pub(crate) fn is_name_of(session: &Session, of: NameKind, name: &str) -> bool {
    let scene = session.scene();
    match of {
        NameKind::New => false,
        NameKind::Primitive | NameKind::PrimitiveOrNew => {
            matches!(scene.get(name), Some(Entity::Primitive(_)))
        }
        NameKind::Object | NameKind::ObjectOrNew => {
            matches!(scene.get(name), Some(Entity::Object(_) | Entity::Table(_)))
        }
        NameKind::Entity => scene.get(name).is_some(),
        NameKind::Child | NameKind::HiddenChild => session
            .selected()
            .and_then(|name| scene.object(name).ok())
            .is_some_and(|object| object.child(name).is_some()),
        NameKind::Command => crate::grammar::table::find_command(name).is_some(),
        NameKind::KeyFrame if parse_number(name).is_ok() => {
            let frame = parse_number(name);
            key_frames(scene).iter().any(|held| Ok(*held) == frame)
        }
        NameKind::Light | NameKind::Setting | NameKind::HelpWord | NameKind::KeyFrame => {
            names_of(session, of).iter().any(|known| known.eq_ignore_ascii_case(name))
        }
    }
}

/// The argument that follows these words of a command (without its own word), if there is one.
pub(crate) fn next_arg<'s>(spec: &'s CommandSpec, before: &[Word<'_>]) -> Option<&'s Arg> {
    let index = spec.position_after(before.iter().map(|word| word.text));
    let last_repeated = spec.all_args().last().filter(|_| spec.is_variadic());
    spec.positional_args().nth(index).or(last_repeated)
}
