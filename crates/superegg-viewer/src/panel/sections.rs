//! The panel and its sections.

use egui::{Color32, DragValue, RichText, Ui};
use superegg_geom::TransformStep;
use superegg_geom::glam::DVec3;
use superegg_lang::Session;
use superegg_scene::{Entity, Object, Scene};

use super::edit::edit_primitive;
use super::eye::eye_button;
use super::fields::{help, number};
use super::handles::{compass, handles};
use super::menu::{menu, offer_recovery, progress};
use super::model::{PanelEvent, PanelModel};
use super::naming::{NameField, Naming};
use super::scene::{self, Lines};
use super::texts::{help as key_list, texts};
use super::tree::{MOST_LISTED, tree};
use super::view::{frame_slider, intersection, io_settings, passes, switches, theme};
use crate::commands;
use crate::input::ViewState;
use crate::input::keys::Action;

/// A change in progress: a held slider, or a field with the keyboard.
#[derive(Debug)]
struct Pending {
    /// The lines of the change.
    lines: Vec<String>,
    draft: Scene,
}

/// The state of the panel.
#[derive(Debug, Default)]
pub(crate) struct Panel {
    pending: Option<Pending>,
    /// The values of the transform fields.
    nudge: Nudge,
    naming: Naming,
    /// The name of the child that is chosen.
    child_naming: NameField,
    /// The session that ended without a save is not offered again.
    pub(crate) recovers_later: bool,
}

/// A transform in progress of the child at the cursor, or of the whole object.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Nudge {
    translate: DVec3,
    axis: usize,
    angle_deg: f64,
    scale: f64,
}

impl Default for Nudge {
    fn default() -> Self {
        Self { translate: DVec3::ZERO, axis: 2, angle_deg: 0.0, scale: 1.0 }
    }
}

const PANEL_WIDTH: f32 = 290.0;

impl Panel {
    /// Draws the panel, the texts and the help. The rest of `ui` is left for the scene.
    pub(crate) fn show(
        &mut self,
        ui: &mut Ui,
        view: &mut ViewState,
        model: &PanelModel<'_>,
    ) -> Vec<PanelEvent> {
        let mut events = Vec::new();
        if let Some(unsaved) = model.document.unsaved_before.as_deref().filter(|_| !self.recovers_later) {
            egui::Panel::top("recovery").show(ui, |ui| offer_recovery(ui, unsaved, &mut events));
        }
        if let Some(text) = model.rendering {
            egui::Panel::top("rendering").show(ui, |ui| progress(ui, text, &mut events));
        }
        if view.has_panel {
            egui::Panel::top("menu").show(ui, |ui| menu(ui, model, &mut events));
            // The theme's own grey is hard to read on a dark panel.
            if ui.visuals().dark_mode {
                ui.visuals_mut().override_text_color = Some(Color32::from_gray(215));
            }
            egui::Panel::right("panel").default_size(PANEL_WIDTH).show(ui, |ui| {
                egui::ScrollArea::vertical().auto_shrink([false; 2]).show(ui, |ui| {
                    self.sections(ui, view, model, &mut events);
                });
            });
        }
        let view_rect = ui.available_rect_before_wrap();
        if let Some(shown) = &model.handles {
            handles(ui, view_rect, shown);
        }
        if view.has_panel {
            compass(ui, view_rect, model, &mut events);
        }
        texts(ui, model);
        if view.has_help {
            key_list(ui, model);
        }
        // A change becomes a command once, when it is over.
        let is_held =
            ui.input(|input| input.pointer.any_down()) || ui.memory(|memory| memory.focused().is_some());
        match self.pending.take() {
            Some(pending) if is_held => {
                events.push(PanelEvent::Draft(Box::new(pending.draft.clone())));
                self.pending = Some(pending);
            }
            Some(pending) => {
                self.nudge = Nudge { axis: self.nudge.axis, ..Nudge::default() };
                events.push(PanelEvent::Lines(pending.lines));
            }
            None => (),
        }
        events
    }

    fn sections(
        &mut self,
        ui: &mut Ui,
        view: &mut ViewState,
        model: &PanelModel<'_>,
        events: &mut Vec<PanelEvent>,
    ) {
        ui.horizontal(|ui| {
            for (text, action, help) in [
                ("Undo", Action::Undo, "Ctrl+Z"),
                ("Redo", Action::Redo, "Ctrl+Y"),
                ("Frame", Action::FrameAll, "f"),
                ("Home", Action::Home, "Home"),
                ("Picture", Action::Screenshot, "F12: save the view as a numbered PNG"),
                ("Keys", Action::ToggleHelp, "h"),
            ] {
                if ui.button(text).on_hover_text(help).clicked() {
                    events.push(PanelEvent::Action(action));
                }
            }
        });
        if let Some(frames) = model.frames {
            section(ui, "Frames", true, |ui| frame_slider(ui, frames, model.is_playing, events));
        }
        section(ui, "Objects", true, |ui| tree(ui, model, events));
        let title = match model.selected {
            Some(name) => format!("Selected: {name}"),
            None => "Selected: nothing".to_owned(),
        };
        egui::CollapsingHeader::new(title).id_salt("selected").default_open(true).show(ui, |ui| {
            let entity = model.selected.and_then(|name| Some((name, model.scene.get(name)?)));
            if let Some((name, _)) = entity {
                self.naming.show(ui, name, model, events);
            }
            match entity {
                Some((_, Entity::Primitive(primitive))) => {
                    let line = edit_primitive(ui, primitive);
                    self.change_lines(line.into_iter().collect(), model);
                }
                Some((name, Entity::Object(object))) => {
                    self.object(ui, (name, object), model, events);
                }
                Some((_, Entity::Table(table))) => {
                    ui.label(format!("A table of {} instances from data; it cannot be edited.", table.len()));
                }
                None => {
                    ui.label("Select something in the tree, or by a double click in the scene.");
                }
            }
        });
        section(ui, "View", true, |ui| {
            switches(ui, view, events);
            passes(ui, view);
            theme(ui, view, events);
        });
        section(ui, "Inside-outside test", false, |ui| io_settings(ui, view, events));
        section(ui, "Intersection test", true, |ui| intersection(ui, view, model.hit, events));
        for (title, edit) in [
            ("Lights", scene::lights as fn(&mut Ui, &Scene) -> Lines),
            ("Camera", scene::camera),
            ("Sky, floor, depth", scene::environment),
            ("Picture", scene::picture),
        ] {
            section(ui, title, false, |ui| {
                let lines = edit(ui, model.scene);
                self.change_lines(lines, model);
            });
        }
        ui.separator();
        ui.small(model.device);
    }

    fn change(&mut self, lines: Vec<String>, draft: Scene) {
        self.pending = Some(Pending { lines, draft });
    }

    /// Begins a change: the scene with its lines is shown until it is over.
    fn change_lines(&mut self, lines: Lines, model: &PanelModel<'_>) {
        if lines.is_empty() {
            return;
        }
        let mut session = Session::with_scene(model.scene.clone(), model.selected);
        // Lines that the language rejects are dropped here, before the session rejects them.
        if lines.iter().all(|line| session.run_line(line).is_ok()) {
            self.change(lines, session.scene().clone());
        }
    }

    fn object(
        &mut self,
        ui: &mut Ui,
        (name, object): (&str, &Object),
        model: &PanelModel<'_>,
        events: &mut Vec<PanelEvent>,
    ) {
        let cursor = object.cursor().map(|(alias, _)| alias.to_owned());
        ui.horizontal(|ui| {
            ui.label(match &cursor {
                Some(alias) => format!("Cursor: child '{alias}'"),
                None => "No children yet.".to_owned(),
            });
            if object.hidden_count() > 0
                && ui.small_button("show all").on_hover_text(help("unhide")).clicked()
            {
                events.push(PanelEvent::Command(commands::unhide_all()));
            }
        });
        let is_root = model.root == Some(name);
        let chosen = model.child.filter(|_| is_root).or(cursor.as_deref());
        egui::ScrollArea::vertical().id_salt("children").max_height(140.0).show(ui, |ui| {
            for (alias, child) in object.children().take(MOST_LISTED) {
                ui.horizontal(|ui| {
                    eye(ui, object, alias, events);
                    let text = child_text(alias, child.target(), object.is_hidden(alias));
                    if ui.selectable_label(chosen == Some(alias), text).clicked() {
                        events.push(if is_root {
                            PanelEvent::SelectChild(alias.to_owned())
                        } else {
                            PanelEvent::Command(commands::set_cursor(alias))
                        });
                    }
                });
            }
            if object.children().len() > MOST_LISTED {
                ui.weak(format!("… and {} more", object.children().len() - MOST_LISTED));
            }
        });
        if let Some(alias) = chosen {
            ui.horizontal(|ui| {
                ui.label("name of the child");
                if let Some(new) = self.child_naming.show(ui, (name, alias)) {
                    events.push(PanelEvent::RenameChild(alias.to_owned(), new));
                }
            });
        }
        if cursor.is_some() {
            ui.label("Transform the child");
            ui.push_id("child", |ui| self.nudges(ui, name, model.scene, false));
        }
        ui.label("Transform the whole object");
        ui.push_id("whole", |ui| self.nudges(ui, name, model.scene, true));
    }

    /// Fields that append a transform step to the child at the cursor, or to the whole object.
    fn nudges(&mut self, ui: &mut Ui, name: &str, scene: &Scene, of_whole: bool) {
        let mut nudge = self.nudge;
        let mut step = None;
        ui.horizontal(|ui| {
            ui.label("move");
            for axis in 0..3 {
                if number(ui, &mut nudge.translate[axis], 0.02, f64::MIN..=f64::MAX) {
                    step = Some(TransformStep::Translate(nudge.translate));
                }
            }
        });
        ui.horizontal(|ui| {
            ui.label("turn");
            for (axis, text) in ["x", "y", "z"].into_iter().enumerate() {
                ui.selectable_value(&mut nudge.axis, axis, text);
            }
            if number(ui, &mut nudge.angle_deg, 1.0, f64::MIN..=f64::MAX) {
                step =
                    Some(TransformStep::Rotate { axis: DVec3::AXES[nudge.axis], angle_deg: nudge.angle_deg });
            }
            ui.label("°  scale");
            let scale =
                DragValue::new(&mut nudge.scale).speed(0.01).range(0.01..=100.0).update_while_editing(false);
            if ui.add(scale).changed() {
                step = Some(TransformStep::Scale(DVec3::splat(nudge.scale)));
            }
        });
        self.nudge = nudge;
        let Some(step) = step else { return };
        let line = commands::transform_step(&step, of_whole);
        let mut draft = scene.clone();
        let changed =
            if of_whole { draft.transform_whole(name, step) } else { draft.transform_child(name, step) };
        if changed.is_ok() {
            self.change(vec![line], draft);
        }
    }
}

/// The button that hides a child of the selected object, or shows it again.
fn eye(ui: &mut Ui, object: &Object, alias: &str, events: &mut Vec<PanelEvent>) {
    let is_hidden = object.is_hidden(alias);
    let (tip, line) = if is_hidden {
        (help("unhide"), commands::unhide(alias))
    } else {
        (help("hide"), commands::hide(alias))
    };
    if eye_button(ui, !is_hidden, alias).on_hover_text(tip).clicked() {
        events.push(PanelEvent::Command(line));
    }
}

/// The name of a child in a list; faint if it is hidden.
fn child_text(alias: &str, target: &str, is_hidden: bool) -> RichText {
    let text = RichText::new(if alias == target { alias.to_owned() } else { format!("{alias}: {target}") });
    if is_hidden { text.weak() } else { text }
}

fn section(ui: &mut Ui, title: &str, is_open: bool, content: impl FnOnce(&mut Ui)) {
    egui::CollapsingHeader::new(title).default_open(is_open).show(ui, content);
}
