//! Rows of a label and fields. Labels are the language's words, and their tooltips its help.

use std::ops::RangeInclusive;

use egui::{Color32, DragValue, RichText, Slider, Ui, WidgetText};
use superegg_geom::glam::DVec3;
use superegg_lang::{SETTINGS, SettingSpec, find_command};

use crate::text::{number_text, vector_text};

const LABEL_WIDTH: f32 = 78.0;

/// The help of a command: its first line, and its default.
pub(super) fn help(word: &str) -> String {
    let Some(spec) = find_command(word) else { return String::new() };
    let default =
        if spec.default.is_empty() { String::new() } else { format!("\ndefault: {}", spec.default) };
    format!("{} {}\n{}{default}", spec.name, spec.usage(), spec.summary)
}

/// The settings that belong to the scene.
pub(super) fn scene_settings() -> impl Iterator<Item = &'static SettingSpec> {
    SETTINGS.iter().filter(|spec| spec.is_of_scene)
}

/// A row: a label with a tooltip, and its fields.
pub(super) fn row<R>(
    ui: &mut Ui,
    label: impl Into<WidgetText>,
    help: String,
    fields: impl FnOnce(&mut Ui) -> R,
) -> R {
    ui.horizontal(|ui| {
        let size = egui::vec2(LABEL_WIDTH, ui.spacing().interact_size.y);
        let label = egui::Label::new(label).truncate();
        let layout = egui::Layout::left_to_right(egui::Align::Center);
        let response = ui.allocate_ui_with_layout(size, layout, |ui| {
            ui.set_min_width(LABEL_WIDTH);
            ui.add(label)
        });
        if !help.is_empty() {
            response.inner.on_hover_text(help);
        }
        fields(ui)
    })
    .inner
}

/// A field for a number. Returns whether it has changed.
pub(super) fn number(ui: &mut Ui, value: &mut f64, speed: f64, range: RangeInclusive<f64>) -> bool {
    let field = DragValue::new(value).speed(speed).range(range).max_decimals(4).update_while_editing(false);
    ui.add(field).changed()
}

/// A slider from 0 to 1 for a number of a command. Returns whether it has changed.
pub(super) fn slider(
    ui: &mut Ui,
    word: &str,
    label: &str,
    value: &mut f64,
    range: RangeInclusive<f64>,
) -> bool {
    row(ui, label, help(word), |ui| {
        ui.add(Slider::new(value, range).max_decimals(4).update_while_editing(false)).changed()
    })
}

/// A row of a number of a command.
pub(super) fn number_row(
    ui: &mut Ui,
    word: &str,
    label: &str,
    value: &mut f64,
    speed: f64,
    range: RangeInclusive<f64>,
) -> bool {
    row(ui, label, help(word), |ui| number(ui, value, speed, range))
}

/// A row of a vector of a command.
pub(super) fn vector(ui: &mut Ui, word: &str, label: &str, value: &mut DVec3, speed: f64) -> bool {
    row(ui, label, help(word), |ui| {
        // All three must be drawn, whichever has changed.
        let fields = [0, 1, 2].map(|axis| number(ui, &mut value[axis], speed, f64::MIN..=f64::MAX));
        fields.contains(&true)
    })
}

/// A row of a colour of a command: a picker of sRGB values, and the linear value that the language
/// has. Components above 1 stay until it is edited.
pub(super) fn color(ui: &mut Ui, word: &str, label: &str, value: &mut DVec3) -> bool {
    row(ui, label, help(word), |ui| {
        let shown = value.clamp(DVec3::ZERO, DVec3::ONE).as_vec3();
        let before: Color32 = egui::Rgba::from_rgb(shown.x, shown.y, shown.z).into();
        let mut srgb = [before.r(), before.g(), before.b()];
        let has_changed = ui.color_edit_button_srgb(&mut srgb).changed();
        if has_changed {
            let rgba = egui::Rgba::from(Color32::from_rgb(srgb[0], srgb[1], srgb[2]));
            let round = |part: f32| (f64::from(part) * 1e4).round() / 1e4;
            *value = DVec3::new(round(rgba.r()), round(rgba.g()), round(rgba.b()));
        }
        let [r, g, b] = srgb;
        let text = format!("#{r:02x}{g:02x}{b:02x}  linear {}", vector_text(*value, 3));
        ui.add(egui::Label::new(RichText::new(text).small()).truncate()).on_hover_text(format!(
            "sRGB {r} {g} {b}; linear, as in the language: {}",
            value.to_array().map(|part| number_text(part, 4)).join(" ")
        ));
        has_changed
    })
}
