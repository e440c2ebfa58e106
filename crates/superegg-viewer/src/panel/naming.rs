//! The name of the selected entity: rename, copy and delete.

use egui::{Key, TextEdit, Ui};

use super::model::{PanelEvent, PanelModel};
use crate::commands::{self, free_name};

/// A field for a name, while it is edited and before.
#[derive(Debug, Default)]
pub(super) struct NameField {
    /// The owner of the name, the name, and what is being typed.
    typed: Option<(String, String, String)>,
}

impl NameField {
    /// Draws the field of a name within its owner. Returns the new name once it is entered.
    pub(super) fn show(&mut self, ui: &mut Ui, (owner, name): (&str, &str)) -> Option<String> {
        let typed = self.typed.take().filter(|(of, old, _)| (of.as_str(), old.as_str()) == (owner, name));
        let mut text = typed.map_or_else(|| name.to_owned(), |(_, _, text)| text);
        let field = ui.add(TextEdit::singleline(&mut text).desired_width(110.0));
        let field = field.on_hover_text("the name; Enter renames");
        let is_entered = field.lost_focus() && ui.input(|input| input.key_pressed(Key::Enter));
        if field.has_focus() {
            self.typed = Some((owner.to_owned(), name.to_owned(), text));
            return None;
        }
        (is_entered && text != name && commands::is_name(&text)).then_some(text)
    }
}

/// The row of the selected entity.
#[derive(Debug, Default)]
pub(super) struct Naming(NameField);

impl Naming {
    pub(super) fn show(
        &mut self,
        ui: &mut Ui,
        name: &str,
        model: &PanelModel<'_>,
        events: &mut Vec<PanelEvent>,
    ) {
        ui.horizontal(|ui| {
            if let Some(new) = self.0.show(ui, ("", name)) {
                events.push(PanelEvent::Command(commands::rename(name, &new)));
            }
            if ui.button("Copy").on_hover_text("copies it under a new name").clicked() {
                let new = free_name(name, |other| model.scene.get(other).is_some());
                events.push(PanelEvent::Command(commands::copy(name, &new)));
            }
            if ui.button("Delete").on_hover_text("deletes it and every child that refers to it").clicked() {
                events.push(PanelEvent::Command(commands::delete(name)));
            }
        });
    }
}
