//! The name of the selected entity: rename, copy and delete.

use egui::{Key, TextEdit, Ui};

use super::model::{PanelEvent, PanelModel};
use crate::commands::{self, free_name};

/// The field of the name while it is edited.
#[derive(Debug, Default)]
pub(super) struct Naming {
    /// The entity and the name that is being typed.
    typed: Option<(String, String)>,
}

impl Naming {
    pub(super) fn show(
        &mut self,
        ui: &mut Ui,
        name: &str,
        model: &PanelModel<'_>,
        events: &mut Vec<PanelEvent>,
    ) {
        let typed = self.typed.take().filter(|(of, _)| of == name);
        let mut text = typed.map_or_else(|| name.to_owned(), |(_, text)| text);
        ui.horizontal(|ui| {
            let field = ui.add(TextEdit::singleline(&mut text).desired_width(110.0));
            let field = field.on_hover_text("the name; Enter renames");
            let is_entered = field.lost_focus() && ui.input(|input| input.key_pressed(Key::Enter));
            if is_entered && text != name && commands::is_name(&text) {
                events.push(PanelEvent::Command(commands::rename(name, &text)));
            } else if field.has_focus() {
                self.typed = Some((name.to_owned(), text));
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
