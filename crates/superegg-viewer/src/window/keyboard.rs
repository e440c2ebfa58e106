//! Keys of the window library as actions.

use winit::event::KeyEvent;
use winit::keyboard::{Key, ModifiersState, NamedKey};

use crate::input::keys::{Action, action_of, action_of_shifted};

/// The action of a pressed key. A held key repeats only where that is useful.
pub(super) fn action(event: &KeyEvent, modifiers: ModifiersState) -> Option<Action> {
    let action = action_of_key(&event.logical_key, modifiers)?;
    (!event.repeat || repeats(action)).then_some(action)
}

/// Whether a held key goes on with its action.
fn repeats(action: Action) -> bool {
    matches!(action, Action::Larger | Action::Smaller | Action::PreviousFrame | Action::NextFrame)
}

fn action_of_key(key: &Key, modifiers: ModifiersState) -> Option<Action> {
    let name = match key {
        Key::Named(NamedKey::Escape) => "Escape",
        Key::Named(NamedKey::Tab) => "Tab",
        Key::Named(NamedKey::Home) => "Home",
        Key::Named(NamedKey::Delete) => "Delete",
        Key::Named(NamedKey::Space) => "Space",
        Key::Named(NamedKey::F6) => "F6",
        Key::Named(NamedKey::F12) => "F12",
        Key::Named(NamedKey::PrintScreen) => "PrintScreen",
        Key::Character(character) => character.as_str(),
        _ => return None,
    };
    if modifiers.alt_key() || modifiers.super_key() {
        return None;
    }
    match (modifiers.control_key(), modifiers.shift_key()) {
        (true, false) => action_of(&format!("Ctrl+{name}")),
        (true, true) => action_of(&format!("Ctrl+Shift+{}", name.to_lowercase())),
        (false, true) => action_of_shifted(name),
        (false, false) => action_of(name),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn modifiers_count() {
        let (control, shift) = (ModifiersState::CONTROL, ModifiersState::SHIFT);
        let z = |modifiers| action_of_key(&Key::Character("Z".into()), modifiers);
        assert_eq!(action_of_key(&Key::Character("z".into()), control), Some(Action::Undo));
        assert_eq!(z(control | shift), Some(Action::Redo));
        assert_eq!(z(ModifiersState::ALT), None);
        let f = |key: &str, modifiers| action_of_key(&Key::Character(key.into()), modifiers);
        assert_eq!(f("F", shift), Some(Action::FrameAll));
        // With Caps Lock a letter is large without Shift.
        assert_eq!(f("F", ModifiersState::empty()), Some(Action::FrameSelected));
        assert_eq!(f("O", shift), Some(Action::ToggleIoTest));
        assert_eq!(action_of_key(&Key::Named(NamedKey::Home), shift), Some(Action::Home));
        assert_eq!(action_of_key(&Key::Named(NamedKey::Enter), shift), None);
    }
}
