//! Reports the entities that a line has created: a misspelt name creates one, too.

use superegg_scene::Entity;

use crate::session::interpreter::Session;
use crate::suggest::nearest;
use crate::text::shorten;

/// A message about a primitive, an object or a light that a line has made, with the name that it may
/// have been meant for; `None` if the line has selected or replaced something that was there.
///
/// ```
/// use superegg_lang::{Session, creation_note};
///
/// let mut session = Session::default();
/// session.run_line("object Foo")?;
/// let before = session.clone();
/// session.run_line("object foo")?;
/// let note = creation_note(&before, &session);
/// assert_eq!(note.as_deref(), Some("new object 'foo'; did you mean 'Foo'?"));
/// # Ok::<(), superegg_lang::Fault>(())
/// ```
pub fn creation_note(before: &Session, after: &Session) -> Option<String> {
    let (old, new) = (before.scene(), after.scene());
    let selected = after.selected().filter(|name| old.get(name).is_none());
    if let Some((name, entity)) = selected.and_then(|name| Some((name, new.get(name)?)))
        && new.entities().len() == old.entities().len() + 1
    {
        let kind = if matches!(entity, Entity::Primitive(_)) { "primitive" } else { "object" };
        return Some(note(kind, name, || old.entities().map(|(name, _)| name)));
    }
    let mut lights = new.named_lights().map(|(name, _)| name);
    let light = lights.find(|name| old.light(name).is_err())?;
    let is_one = new.named_lights().len() == old.named_lights().len() + 1;
    is_one.then(|| note("light", light, || old.named_lights().map(|(name, _)| name)))
}

fn note<'a, I: Iterator<Item = &'a str>>(kind: &str, name: &str, known: impl Fn() -> I) -> String {
    let alike = known().find(|other| other.eq_ignore_ascii_case(name)).or_else(|| nearest(name, known()));
    let meant = alike.map_or_else(String::new, |near| format!("; did you mean '{}'?", shorten(near)));
    format!("new {kind} '{}'{meant}", shorten(name))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_made_is_named_and_nothing_else() {
        let mut session = Session::default();
        for (line, expected) in [
            ("primitive ball", Some("new primitive 'ball'")),
            ("primitive ball", None),
            ("primitive bal", Some("new primitive 'bal'; did you mean 'ball'?")),
            ("object Ball2", Some("new object 'Ball2'; did you mean 'ball'?")),
            ("addPrimitive ball", None),
            ("light key 1 2 3", Some("new light 'key'")),
            ("light kye 1 2 3", Some("new light 'kye'; did you mean 'key'?")),
            ("light key 3 2 1", None),
            ("copy ball other", None),
            ("delete ball", None),
            ("setColor red", None),
        ] {
            let before = session.clone();
            let _ = session.run_line(line);
            assert_eq!(creation_note(&before, &session).as_deref(), expected, "{line}");
        }
    }
}
