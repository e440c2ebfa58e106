//! Fields of a primitive and its material. Each function returns the lines of a change.

use egui::{ComboBox, Slider, Ui};
use superegg_geom::glam::DVec3;
use superegg_scene::{Material, Patches, Pattern, Primitive};

use super::fields::{color, help, number, row, slider, vector};
use super::pictures;
use crate::commands::{self, with_numbers};

/// Edits a primitive. Returns `None` without a change.
pub(super) fn edit_primitive(ui: &mut Ui, primitive: &Primitive) -> Option<String> {
    let mut line = None;
    let (mut radii, exponents) = (primitive.shape.radii(), primitive.shape.exponents());
    let has_radii = row(ui, "semi-axes", help("setCoeff"), |ui| {
        [0, 1, 2].map(|axis| number(ui, &mut radii[axis], 0.01, 1e-3..=1e6)).contains(&true)
    });
    if has_radii {
        line = Some(with_numbers("setCoeff", &radii.to_array()));
    }
    let (mut e, mut n) = (exponents.e(), exponents.n());
    for (value, label) in [(&mut e, "e: around"), (&mut n, "n: poles")] {
        row(ui, label, help("setExponent"), |ui| {
            let slider = Slider::new(value, 0.0..=4.0).logarithmic(true).smallest_positive(0.01);
            ui.add(slider.update_while_editing(false));
        });
    }
    if (e, n) != (exponents.e(), exponents.n()) {
        line = Some(commands::set_exponents(e, n));
    }
    let Patches { mut u, mut v } = primitive.patches;
    let has_patches = row(ui, "patches", help("setPatch"), |ui| {
        let mut field = |value: &mut u32| {
            ui.add(egui::DragValue::new(value).range(1..=512).update_while_editing(false)).changed()
        };
        [field(&mut u), field(&mut v)].contains(&true)
    });
    if has_patches {
        line = Some(with_numbers("setPatch", &[f64::from(u), f64::from(v)]));
    }
    ui.separator();
    line = edit_material(ui, &primitive.material).or(line);
    pictures::textures(ui, primitive.textures.as_deref()).or(line)
}

fn edit_material(ui: &mut Ui, material: &Material) -> Option<String> {
    let mut line = None;
    let mut base = material.color;
    if color(ui, "setColor", "color", &mut base) {
        line = Some(with_numbers("setColor", &base.to_array()));
    }
    line = edit_pattern(ui, &material.pattern).or(line);
    for (word, label, value) in [
        ("setAmbient", "ambient", material.ambient),
        ("setDiffuse", "diffuse", material.diffuse),
        ("setSpecular", "specular", material.specular),
        ("setGloss", "gloss", material.gloss),
        ("setReflected", "reflected", material.reflected.unwrap_or(0.0)),
        ("setRefracted", "refracted", material.refracted.unwrap_or(0.0)),
        ("setRoughness", "roughness", material.facet_roughness().unwrap_or(1.0)),
        ("setMetallic", "metallic", material.metallic),
    ] {
        let mut value = value;
        if slider(ui, word, label, &mut value, 0.0..=1.0) {
            line = Some(with_numbers(word, &[value]));
        }
    }
    let mut index = material.index;
    if slider(ui, "setIndex", "index", &mut index, 1.0..=4.0) {
        line = Some(with_numbers("setIndex", &[index]));
    }
    let mut has_fresnel = material.fresnel;
    if row(ui, "fresnel", help("setFresnel"), |ui| ui.checkbox(&mut has_fresnel, "").changed()) {
        line = Some(commands::fresnel(has_fresnel));
    }
    let mut exponent = material.highlight_exponent();
    if row(ui, "shininess", help("setShininess"), |ui| number(ui, &mut exponent, 0.5, 0.0..=1e6)) {
        line = Some(with_numbers("setShininess", &[exponent]));
    }
    let mut emission = material.emission;
    if row(ui, "emission", help("setEmission"), |ui| number(ui, &mut emission, 0.05, 0.0..=1e6)) {
        line = Some(with_numbers("setEmission", &[emission]));
    }
    let mut absorb = material.absorb;
    if vector(ui, "setAbsorb", "absorb / unit", &mut absorb, 0.01) {
        line = Some(with_numbers("setAbsorb", &absorb.max(DVec3::ZERO).to_array()));
    }
    line
}

fn edit_pattern(ui: &mut Ui, before: &Pattern) -> Option<String> {
    let mut pattern = *before;
    let (second, kinds) = (DVec3::splat(0.1), ["none", "checker", "gradient", "noise", "marble", "wood"]);
    let kind = kinds.iter().position(|word| *word == pattern.word()).unwrap_or(0);
    row(ui, "pattern", help("setPattern"), |ui| {
        let mut chosen = kind;
        ComboBox::from_id_salt("pattern").selected_text(kinds[kind]).show_ui(ui, |ui| {
            for (i, word) in kinds.iter().enumerate() {
                ui.selectable_value(&mut chosen, i, *word);
            }
        });
        if chosen != kind {
            pattern = match chosen {
                0 => Pattern::None,
                1 => Pattern::Checker { color: second, size: 0.5 },
                2 => Pattern::Gradient { color: second, direction: DVec3::Z },
                3 => Pattern::Noise { color: second, size: 0.5 },
                4 => Pattern::Marble { color: second, size: 0.5 },
                _ => Pattern::Wood { color: second, size: 0.2 },
            };
        }
    });
    match &mut pattern {
        Pattern::None => (),
        Pattern::Checker { color: other, size }
        | Pattern::Noise { color: other, size }
        | Pattern::Marble { color: other, size }
        | Pattern::Wood { color: other, size } => {
            color(ui, "setPattern", "  color", other);
            row(ui, "  size", help("setPattern"), |ui| number(ui, size, 0.01, 1e-3..=1e6));
        }
        Pattern::Gradient { color: other, direction } => {
            color(ui, "setPattern", "  color", other);
            vector(ui, "setPattern", "  direction", direction, 0.02);
        }
    }
    let is_valid = !matches!(pattern, Pattern::Gradient { direction, .. } if direction == DVec3::ZERO);
    (pattern != *before && is_valid).then(|| commands::pattern(&pattern))
}
