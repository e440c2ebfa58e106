//! The eye beside a child: open, or closed if the child is hidden.

use egui::{Pos2, Response, Sense, Stroke, Ui, Vec2, WidgetInfo};

/// Half width and half height of the eye.
const HALF: Vec2 = Vec2::new(7.0, 4.5);
const PUPIL: f32 = 2.0;
/// The pieces of a lid.
const PIECES: u8 = 12;

/// Draws the eye of a thing with this name. A click or the keyboard presses it.
pub(super) fn eye_button(ui: &mut Ui, is_open: bool, name: &str) -> Response {
    let size = Vec2::new(2.0 * HALF.x + 8.0, ui.spacing().interact_size.y);
    let (rect, response) = ui.allocate_exact_size(size, Sense::click());
    response.widget_info(|| {
        WidgetInfo::selected(egui::Role::CheckBox, true, is_open, format!("{name} is visible"))
    });
    let visuals = ui.style().interact(&response);
    let color = if is_open { visuals.fg_stroke.color } else { ui.visuals().weak_text_color() };
    let stroke = Stroke::new(1.2, color);
    let middle = rect.center();
    let lid = |height: f32| -> Vec<Pos2> {
        let point = |i: u8| {
            let x = 2.0 * f32::from(i) / f32::from(PIECES) - 1.0;
            middle + Vec2::new(HALF.x * x, height * (1.0 - x * x))
        };
        (0..=PIECES).map(point).collect()
    };
    let painter = ui.painter();
    if response.hovered() || response.has_focus() {
        painter.rect_filled(rect, visuals.corner_radius, visuals.weak_bg_fill);
    }
    painter.line(lid(HALF.y), stroke);
    if is_open {
        painter.line(lid(-HALF.y), stroke);
        painter.circle_filled(middle, PUPIL, color);
    }
    response
}
