//! Fields of a primitive, its material, and a light. Each function edits in place and returns the
//! line of the change.

use std::ops::RangeInclusive;

use egui::{DragValue, Slider, Ui};
use superegg_geom::glam::DVec3;
use superegg_geom::{Exponents, Superquadric};
use superegg_scene::{Light, LightKind, Material, Patches, Primitive};

use super::fields::{color, vector};
use crate::commands;

/// Edits a primitive. Returns `None` without a change.
pub(super) fn edit_primitive(ui: &mut Ui, primitive: &mut Primitive) -> Option<String> {
    let shape = primitive.shape;
    let (mut radii, exponents) = (shape.radii(), shape.exponents());
    let (mut e, mut n) = (exponents.e(), exponents.n());
    let (mut has_radii, mut has_exponents, mut has_patches) = (false, false, false);
    ui.horizontal(|ui| {
        ui.label("semi-axes");
        for axis in 0..3 {
            let field =
                DragValue::new(&mut radii[axis]).speed(0.01).range(1e-3..=1e6).update_while_editing(false);
            has_radii |= ui.add(field).changed();
        }
    });
    for (value, text) in [(&mut e, "e: xy plane"), (&mut n, "n: towards z")] {
        let slider = Slider::new(value, 0.0..=4.0)
            .logarithmic(true)
            .smallest_positive(0.01)
            .text(text)
            .update_while_editing(false);
        has_exponents |= ui.add(slider).changed();
    }
    if let Ok(shape) = Exponents::new(e, n).and_then(|exponents| Superquadric::new(radii, exponents)) {
        primitive.shape = shape;
    }
    let Patches { u, v } = &mut primitive.patches;
    for (value, text) in [(u, "patches around"), (v, "patches pole to pole")] {
        let slider = Slider::new(value, 1..=200).logarithmic(true).text(text).update_while_editing(false);
        has_patches |= ui.add(slider).changed();
    }
    if let Some(line) = edit_material(ui, &mut primitive.material) {
        Some(line)
    } else if has_patches {
        Some(commands::patches(primitive))
    } else if has_exponents {
        Some(commands::exponents(primitive))
    } else {
        has_radii.then(|| commands::radii(primitive))
    }
}

fn edit_material(ui: &mut Ui, material: &mut Material) -> Option<String> {
    let mut line = None;
    ui.horizontal(|ui| {
        ui.label("colour");
        if color(ui, &mut material.color) {
            line = Some(commands::color(material));
        }
    });
    let mut number = |ui: &mut Ui, value: &mut f64, range: RangeInclusive<f64>, word: &str, text: &str| {
        let has_changed = ui.add(Slider::new(value, range).text(text).update_while_editing(false)).changed();
        if has_changed {
            line = Some(commands::material_number(word, *value));
        }
        has_changed
    };
    number(ui, &mut material.ambient, 0.0..=1.0, "setAmbient", "ambient");
    number(ui, &mut material.diffuse, 0.0..=1.0, "setDiffuse", "diffuse");
    number(ui, &mut material.specular, 0.0..=1.0, "setSpecular", "highlight");
    number(ui, &mut material.gloss, 0.0..=1.0, "setGloss", "gloss");
    // `None` stays until it is edited.
    let mut reflected = material.reflected.unwrap_or(0.0);
    if number(ui, &mut reflected, 0.0..=1.0, "setReflected", "reflected") {
        material.reflected = Some(reflected);
    }
    let mut refracted = material.refracted.unwrap_or(0.0);
    if number(ui, &mut refracted, 0.0..=1.0, "setRefracted", "refracted") {
        material.refracted = Some(refracted);
    }
    number(ui, &mut material.index, 1.0..=4.0, "setIndex", "index");
    line
}

/// Edits a light. Returns whether it has changed.
pub(super) fn edit_light(ui: &mut Ui, light: &mut Light) -> bool {
    let before = *light;
    let mut has_changed = match &mut light.kind {
        LightKind::Point { position } => vector(ui, "position", position, 0.05),
        LightKind::Spot { position, target, cone_deg, soft } => {
            let has_moved = vector(ui, "position", position, 0.05);
            let has_turned = vector(ui, "towards", target, 0.05);
            let cone = Slider::new(cone_deg, 1.0..=180.0).text("cone °").update_while_editing(false);
            let rim = Slider::new(soft, 0.0..=1.0).text("soft rim").update_while_editing(false);
            // All must be drawn, whichever has changed.
            [has_moved, has_turned, ui.add(cone).changed(), ui.add(rim).changed()].contains(&true)
        }
        LightKind::Sun { direction } => vector(ui, "from", direction, 0.05),
    };
    // The language rejects a light without a direction.
    if matches!(light.kind, LightKind::Spot { position, target, .. } if position == target)
        || matches!(light.kind, LightKind::Sun { direction } if direction == DVec3::ZERO)
    {
        light.kind = before.kind;
        has_changed = false;
    }
    ui.horizontal(|ui| {
        ui.label("colour");
        has_changed |= color(ui, &mut light.color);
        let falloff = (&mut light.falloff, "falloff", 0.001);
        let radius = (&mut light.radius, "radius", 0.01);
        for (value, text, speed) in [falloff, radius] {
            // A directional light has no attenuation.
            if text == "falloff" && matches!(light.kind, LightKind::Sun { .. }) {
                continue;
            }
            ui.label(text);
            let field = DragValue::new(value).speed(speed).range(0.0..=1e6).update_while_editing(false);
            has_changed |= ui.add(field).changed();
        }
    });
    has_changed
}
