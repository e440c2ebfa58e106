//! The tree of objects.

use std::collections::HashSet;

use egui::collapsing_header::CollapsingState;
use egui::{RichText, Ui};
use superegg_scene::{Entity, Object};

use super::model::{PanelEvent, PanelModel};
use crate::commands;

/// Most children that are listed of one object. A longer list is slow and of no use.
pub(super) const MOST_LISTED: usize = 200;
/// Most lines of the tree.
const MOST_LINES: usize = 4 * MOST_LISTED;

/// Shows the tree: the entities that are in no other object, and their children.
pub(super) fn tree(ui: &mut Ui, model: &PanelModel<'_>, events: &mut Vec<PanelEvent>) {
    let used: HashSet<&str> = model
        .scene
        .objects()
        .flat_map(|(name, object)| object.children().map(move |(_, child)| (name, child.target())))
        .filter(|(name, target)| name != target)
        .map(|(_, target)| target)
        .collect();
    egui::ScrollArea::vertical().id_salt("tree").max_height(220.0).show(ui, |ui| {
        let mut tree = Tree { model, ancestors: Vec::new(), listed: 0, events };
        let tops = model.scene.entities().filter(|(name, _)| !used.contains(name));
        for (name, _) in tops.take(MOST_LISTED) {
            tree.branch(ui, name, name);
        }
        let rest = model.scene.entities().len().saturating_sub(MOST_LISTED);
        if tree.listed >= MOST_LISTED && rest > 0 {
            ui.weak("… and more");
        }
    });
}

struct Tree<'a, 'b> {
    model: &'b PanelModel<'a>,
    /// Names of the objects above the current branch.
    ancestors: Vec<&'a str>,
    /// Lines so far.
    listed: usize,
    events: &'b mut Vec<PanelEvent>,
}

impl<'a> Tree<'a, '_> {
    fn branch(&mut self, ui: &mut Ui, alias: &str, name: &'a str) {
        self.listed += 1;
        if self.listed > MOST_LINES {
            return;
        }
        let Some(entity) = self.model.scene.get(name) else { return };
        match entity {
            Entity::Object(object) if !self.ancestors.contains(&name) => {
                let id = ui.make_persistent_id((self.ancestors.clone(), alias));
                let is_open = self.ancestors.is_empty() && self.model.root == Some(name);
                CollapsingState::load_with_default_open(ui.ctx(), id, is_open)
                    .show_header(ui, |ui| self.label(ui, alias, name, entity))
                    .body(|ui| self.children(ui, name, object));
            }
            // An object within itself is a leaf, or the tree would be infinite.
            Entity::Object(_) | Entity::Primitive(_) | Entity::Table(_) => {
                self.label(ui, alias, name, entity);
            }
        }
    }

    /// A label that selects the entity.
    fn label(&mut self, ui: &mut Ui, alias: &str, name: &str, entity: &Entity) {
        let text = if alias == name { name.to_owned() } else { format!("{alias}: {name}") };
        let text =
            if self.model.root == Some(name) { RichText::new(text).strong() } else { RichText::new(text) };
        if ui.selectable_label(self.model.selected == Some(name), text).clicked() {
            self.events.push(PanelEvent::Command(commands::select(name, entity)));
        }
    }

    fn children(&mut self, ui: &mut Ui, name: &'a str, object: &'a Object) {
        self.ancestors.push(name);
        for (alias, child) in object.children().take(MOST_LISTED) {
            ui.scope(|ui| {
                if object.is_hidden(alias) {
                    ui.visuals_mut().override_text_color = Some(ui.visuals().weak_text_color());
                }
                self.branch(ui, alias, child.target());
            });
        }
        let rest = object.children().len().saturating_sub(MOST_LISTED);
        if rest > 0 {
            ui.weak(format!("… and {rest} more"));
        }
        self.ancestors.pop();
    }
}
