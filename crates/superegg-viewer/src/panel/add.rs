//! Adds primitives, objects, lights and existing things: each addition is one change.

use egui::Ui;
use superegg_geom::glam::DVec3;
use superegg_scene::{Entity, Light, LightKind, Scene};

use super::model::{PanelEvent, PanelModel};
use crate::commands::{self, free_name};

/// Name and exponents of new primitives.
const SHAPES: [(&str, f64, f64); 6] = [
    ("ball", 1.0, 1.0),
    ("cube", 0.1, 0.1),
    ("cylinder", 1.0, 0.1),
    ("pillow", 0.5, 0.5),
    ("octahedron", 2.0, 2.0),
    ("star", 3.0, 3.0),
];
/// Most existing things that are listed.
const MOST_LISTED: usize = 40;

/// The rows of the menu.
pub(super) fn add_menu(ui: &mut Ui, model: &PanelModel<'_>, events: &mut Vec<PanelEvent>) {
    for (shape, e, n) in SHAPES {
        if ui.button(format!("Primitive: {shape}")).clicked() {
            let name = free(model.scene, shape);
            let mut lines = vec![commands::select_primitive(&name)];
            if (e, n) != (1.0, 1.0) {
                lines.push(commands::set_exponents(e, n));
            }
            lines.extend(lines_to_add(model, &name, true));
            events.push(PanelEvent::Change(format!("add {name}"), lines));
        }
    }
    ui.separator();
    if ui.button("Object").on_hover_text("an empty object").clicked() {
        let name = free(model.scene, "object");
        let mut lines = vec![commands::select_object(&name)];
        lines.extend(lines_to_add(model, &name, false));
        events.push(PanelEvent::Change(format!("add {name}"), lines));
    }
    let others = || {
        let is_other = |(name, _): &(&str, &Entity)| Some(*name) != model.root;
        model.scene.entities().filter(is_other).take(MOST_LISTED)
    };
    ui.add_enabled_ui(others().next().is_some(), |ui| {
        ui.menu_button("One more of", |ui| {
            for (name, entity) in others() {
                if ui.button(name).clicked() {
                    let is_primitive = matches!(entity, Entity::Primitive(_));
                    let lines = lines_to_add(model, name, is_primitive);
                    events.push(PanelEvent::Change(format!("add {name}"), lines));
                }
            }
        });
    });
    ui.separator();
    for (text, kind) in lights() {
        if ui.button(text).clicked() {
            let is_taken = |name: &str| model.scene.named_lights().any(|(other, _)| other == name);
            let name = free_name("light1", is_taken);
            let light = Light { kind, falloff: 0.0, ..Light::DEFAULT };
            events.push(PanelEvent::Change(format!("add {name}"), commands::light(&name, &light)));
        }
    }
}

fn lights() -> [(&'static str, LightKind); 3] {
    let position = DVec3::new(3.0, 4.0, 5.0);
    [
        ("Point light", LightKind::Point { position }),
        ("Spot light", LightKind::Spot { position, target: DVec3::ZERO, cone_deg: 40.0, soft: 0.2 }),
        ("Sun", LightKind::Sun { direction: DVec3::new(1.0, 3.0, 2.0) }),
    ]
}

fn free(scene: &Scene, word: &str) -> String {
    free_name(word, |name| scene.get(name).is_some())
}

/// The lines that add an entity to the root. A root that is no object becomes a child of a new one.
fn lines_to_add(model: &PanelModel<'_>, name: &str, is_primitive: bool) -> Vec<String> {
    let root = model.root.and_then(|root| Some((root, model.scene.get(root)?)));
    let mut lines = Vec::new();
    let mut is_taken: Vec<String> = Vec::new();
    match root {
        Some((root, Entity::Object(object))) => {
            lines.push(commands::select_object(root));
            is_taken = object.children().map(|(alias, _)| alias.to_owned()).collect();
        }
        Some((root, entity)) => {
            lines.push(commands::select_object(&free(model.scene, "scene")));
            lines.push(commands::add_child(root, entity, root));
            is_taken.push(root.to_owned());
        }
        None => lines.push(commands::select_object(&free(model.scene, "scene"))),
    }
    let alias = free_name(name, |alias| is_taken.iter().any(|taken| taken == alias));
    let line = if is_primitive { commands::add_primitive(name) } else { commands::add_object(name) };
    lines.push(if alias == name { line } else { format!("{line} {alias}") });
    lines
}
