//! The panel and its sections.

use egui::{Color32, DragValue, Slider, Ui};
use superegg_geom::TransformStep;
use superegg_geom::glam::DVec3;
use superegg_scene::{Encoding, Entity, Light, MAX_DEPTH, Object, Primitive, Scene};

use super::edit::{edit_light, edit_primitive};
use super::fields::{color, number, vector};
use super::handles::{compass, handles};
use super::menu::{menu, offer_recovery};
use super::model::{PanelEvent, PanelModel};
use super::naming::Naming;
use super::texts::{help, texts};
use super::tree::{MOST_LISTED, tree};
use super::view::{frame_slider, intersection, io_settings, switches};
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
        if view.has_panel {
            egui::Panel::top("menu").show(ui, |ui| menu(ui, model, &mut events));
            // The theme's own grey is hard to read on a dark panel.
            ui.visuals_mut().override_text_color = Some(Color32::from_gray(215));
            egui::Panel::right("panel").default_size(PANEL_WIDTH).show(ui, |ui| {
                egui::ScrollArea::vertical().auto_shrink([false; 2]).show(ui, |ui| {
                    self.sections(ui, view, model, &mut events);
                });
            });
        }
        let scene = ui.available_rect_before_wrap();
        if let Some(shown) = &model.handles {
            handles(ui, scene, shown);
        }
        if view.has_panel {
            compass(ui, scene, model, &mut events);
        }
        texts(ui, model);
        if view.has_help {
            help(ui, model);
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
                events.extend(pending.lines.into_iter().map(PanelEvent::Command));
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
            section(ui, "Frames", true, |ui| frame_slider(ui, frames, events));
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
                Some((name, Entity::Primitive(primitive))) => {
                    self.primitive(ui, name, primitive, model.scene);
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
        section(ui, "View", true, |ui| switches(ui, view, events));
        section(ui, "Inside-outside test", false, |ui| io_settings(ui, view, events));
        section(ui, "Intersection test", true, |ui| intersection(ui, view, model.hit, events));
        section(ui, "Lights", false, |ui| self.lights(ui, model.scene, events));
        section(ui, "Camera", false, |ui| self.camera(ui, model.scene, events));
        section(ui, "Picture", false, |ui| self.picture(ui, model.scene));
        ui.separator();
        ui.small(model.device);
    }

    fn change(&mut self, lines: Vec<String>, draft: Scene) {
        self.pending = Some(Pending { lines, draft });
    }

    fn primitive(&mut self, ui: &mut Ui, name: &str, primitive: &Primitive, scene: &Scene) {
        let mut edited = primitive.clone();
        let Some(line) = edit_primitive(ui, &mut edited) else { return };
        let mut draft = scene.clone();
        if let Ok(primitive) = draft.primitive_mut(name) {
            *primitive = edited;
            self.change(vec![line], draft);
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
        ui.label(match &cursor {
            Some(alias) => format!("Cursor: child '{alias}'"),
            None => "No children yet.".to_owned(),
        });
        let is_root = model.root == Some(name);
        let chosen = model.child.filter(|_| is_root).or(cursor.as_deref());
        egui::ScrollArea::vertical().id_salt("children").max_height(140.0).show(ui, |ui| {
            for (alias, child) in object.children().take(MOST_LISTED) {
                let text = if alias == child.target() {
                    alias.to_owned()
                } else {
                    format!("{alias}: {}", child.target())
                };
                if ui.selectable_label(chosen == Some(alias), text).clicked() {
                    events.push(if is_root {
                        PanelEvent::SelectChild(alias.to_owned())
                    } else {
                        PanelEvent::Command(commands::set_cursor(alias))
                    });
                }
            }
        });
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
                if number(ui, &mut nudge.translate[axis], 0.02).changed() {
                    step = Some(TransformStep::Translate(nudge.translate));
                }
            }
        });
        ui.horizontal(|ui| {
            ui.label("turn");
            for (axis, text) in ["x", "y", "z"].into_iter().enumerate() {
                ui.selectable_value(&mut nudge.axis, axis, text);
            }
            if number(ui, &mut nudge.angle_deg, 1.0).changed() {
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

    fn lights(&mut self, ui: &mut Ui, scene: &Scene, events: &mut Vec<PanelEvent>) {
        if scene.named_lights().len() == 0 {
            ui.label("The default light: white at 3 4 5. Lights of your own replace it.");
        }
        for (name, light) in scene.named_lights() {
            let mut edited = *light;
            ui.horizontal(|ui| {
                ui.strong(name);
                if ui.small_button("remove").clicked() {
                    events.push(PanelEvent::Command(commands::remove_light(name)));
                }
            });
            let has_changed = ui.push_id(name, |ui| edit_light(ui, &mut edited)).inner;
            if has_changed {
                let mut draft = scene.clone();
                draft.set_light(name, edited);
                self.change(commands::light(name, &edited), draft);
            }
        }
        if ui.button("Add a light").clicked() {
            let is_free = |name: &String| scene.named_lights().all(|(other, _)| other != name);
            let name = (1..).map(|i| format!("light{i}")).find(is_free).unwrap_or_default();
            let lines = commands::light(&name, &Light { falloff: 0.0, ..Light::DEFAULT });
            events.extend(lines.into_iter().map(PanelEvent::Command));
        }
    }

    fn camera(&mut self, ui: &mut Ui, scene: &Scene, events: &mut Vec<PanelEvent>) {
        let mut camera = scene.camera;
        let mut has_moved = false;
        for (label, value) in [("position", &mut camera.position), ("target", &mut camera.target)] {
            has_moved |= vector(ui, label, value, 0.05);
        }
        let fov =
            Slider::new(&mut camera.fov_deg, 1.0..=170.0).text("field of view °").update_while_editing(false);
        has_moved |= ui.add(fov).changed();
        let has_turned = vector(ui, "up", &mut camera.up, 0.02);
        // The language rejects a camera without a direction.
        let is_valid = camera.position != camera.target && camera.up != DVec3::ZERO;
        if (has_moved || has_turned) && is_valid {
            let line = if has_turned { commands::camera_up(&camera) } else { commands::camera(&camera) };
            let mut draft = scene.clone();
            draft.camera = camera;
            draft.sets_camera = true;
            self.change(vec![line], draft);
        }
        if ui.button("Use this view as the camera").on_hover_text("c").clicked() {
            events.push(PanelEvent::Action(Action::WriteCamera));
        }
    }

    fn picture(&mut self, ui: &mut Ui, scene: &Scene) {
        let mut draft = scene.clone();
        let mut line = None;
        ui.horizontal(|ui| {
            ui.label("background");
            if color(ui, &mut draft.background) {
                line = Some(commands::background(draft.background));
            }
        });
        if ui.add(Slider::new(&mut draft.depth, 0..=MAX_DEPTH).text("depth")).changed() {
            line = Some(commands::depth(draft.depth));
        }
        let picture = &mut draft.picture;
        ui.horizontal(|ui| {
            ui.label("size");
            let side = |value| DragValue::new(value).range(1..=8192).update_while_editing(false);
            let has_changed = ui.add(side(&mut picture.width)).changed();
            if ui.add(side(&mut picture.height)).changed() || has_changed {
                line = Some(commands::picture_size(picture));
            }
        });
        if ui
            .add(Slider::new(&mut picture.samples, 1..=64).logarithmic(true).text("samples per pixel"))
            .changed()
        {
            line = Some(commands::samples(picture));
        }
        ui.horizontal(|ui| {
            ui.label("encoding");
            for encoding in [Encoding::Srgb, Encoding::Linear] {
                let word = commands::encoding_word(encoding);
                if ui.selectable_value(&mut picture.encoding, encoding, word).changed() {
                    line = Some(commands::encoding(encoding));
                }
            }
        });
        if let Some(line) = line {
            self.change(vec![line], draft);
        }
    }
}

fn section(ui: &mut Ui, title: &str, is_open: bool, content: impl FnOnce(&mut Ui)) {
    egui::CollapsingHeader::new(title).default_open(is_open).show(ui, content);
}
