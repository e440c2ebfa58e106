//! Fields for numbers, vectors and colours.

use egui::{DragValue, Ui};
use superegg_geom::glam::DVec3;

pub(super) fn number(ui: &mut Ui, value: &mut f64, speed: f64) -> egui::Response {
    ui.add(DragValue::new(value).speed(speed).max_decimals(3).update_while_editing(false))
}

pub(super) fn vector(ui: &mut Ui, label: &str, value: &mut DVec3, speed: f64) -> bool {
    ui.horizontal(|ui| {
        ui.label(label);
        // All three must be drawn, whichever has changed.
        let fields = [0, 1, 2].map(|axis| number(ui, &mut value[axis], speed).changed());
        fields.contains(&true)
    })
    .inner
}

/// A field for a linear colour. Components above 1 stay until it is edited.
pub(super) fn color(ui: &mut Ui, value: &mut DVec3) -> bool {
    let mut rgb = value.as_vec3().to_array();
    let has_changed = ui.color_edit_button_rgb(&mut rgb).changed();
    if has_changed {
        *value = DVec3::from_array(rgb.map(|part| (f64::from(part.clamp(0.0, 1.0)) * 1e4).round() / 1e4));
    }
    has_changed
}
