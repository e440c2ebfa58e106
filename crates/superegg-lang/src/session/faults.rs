//! Conversion of scene errors to faults.

use superegg_scene::{Scene, SceneError};

use crate::diagnostic::{Fault, FaultCode};
use crate::grammar::spec::{ArgKind, NameKind};
use crate::parse::parser::Parsed;
use crate::suggest::Suggestions;
use crate::text::shorten;

/// The help of a fault about a table that was to be changed.
pub(super) fn table_help(table: &str) -> String {
    let table = shorten(table);
    format!(
        "its rows come from data and stay; 'object NAME', then 'addObject {table}' make an object of it, which can be moved"
    )
}

/// The fault of a scene error, with the columns of the word that caused it.
pub(crate) fn scene_fault(
    scene: &Scene,
    error: &SceneError,
    parsed: &Parsed,
    suggestions: Suggestions,
) -> Fault {
    let names = || scene.entities().map(|(name, _)| name);
    // The first argument that names something existing.
    let named =
        parsed.spec.all_args().position(|arg| matches!(arg.kind, ArgKind::Name(of) if of != NameKind::New));
    let named = named.unwrap_or(0) + 1;
    let (code, word, help) = match error {
        SceneError::Unknown(name) => (
            FaultCode::UnknownName,
            named,
            suggestions.did_you_mean(name, names(), "'info' lists what there is"),
        ),
        SceneError::NotAnObject(_) => (
            FaultCode::WrongKind,
            1,
            "addPrimitive adds a primitive, and 'primitive NAME' selects one".to_owned(),
        ),
        SceneError::NotAPrimitive(_) | SceneError::IsTable(_) if parsed.spec.name == "floor" => {
            (FaultCode::WrongKind, named, "a floor has the surface of a primitive".to_owned())
        }
        SceneError::NotAPrimitive(_) => (
            FaultCode::WrongKind,
            named,
            "addObject adds an object, and 'object NAME' selects one".to_owned(),
        ),
        SceneError::IsTable(name) => (FaultCode::WrongKind, named, table_help(name)),
        SceneError::AliasExists { .. } => (
            FaultCode::AliasExists,
            parsed.columns.len() - 1,
            format!("give another alias as the last word, such as: {} NAME ALIAS", parsed.spec.name),
        ),
        SceneError::UnknownAlias { object, alias } => {
            let children = scene.object(object).ok();
            let aliases = children.iter().flat_map(|object| object.children()).map(|(alias, _)| alias);
            (
                FaultCode::UnknownName,
                1,
                suggestions.did_you_mean(alias, aliases, "'info selected' lists the children"),
            )
        }
        SceneError::NoChild(_) => {
            (FaultCode::NoChild, 0, "addPrimitive or addObject adds a child".to_owned())
        }
        SceneError::NameExists(name) => (
            FaultCode::NameExists,
            2,
            format!("take another name; 'show {}' shows what has it", shorten(name)),
        ),
        SceneError::UnknownLight(name) => {
            let lights = scene.named_lights().map(|(name, _)| name);
            (FaultCode::UnknownName, 1, suggestions.did_you_mean(name, lights, "'info' lists the lights"))
        }
        SceneError::KeyNumbers { .. } => (FaultCode::KeyNumbers, 0, "'info' lists the keys".to_owned()),
        SceneError::Transform(_) => {
            let fault = Fault::new(FaultCode::Transform, error.to_string()).at(parsed.argument_columns());
            return fault.help(format!("for example: {}", parsed.spec.example));
        }
    };
    Fault::new(code, error.to_string()).help(help).at(parsed.word_columns(word))
}
