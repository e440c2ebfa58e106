//! Texts over the scene: status, notice, help.

use egui::{Align2, Color32, RichText, Ui};

use super::model::PanelModel;
use crate::input::keys::{BINDINGS, POINTER_HELP};

/// The status at the bottom of the scene, and a notice at its top.
pub(super) fn texts(ui: &Ui, model: &PanelModel<'_>) {
    let scene = ui.available_rect_before_wrap();
    let text_box = |id: &str, pivot: Align2, at: egui::Pos2, lines: &[&str], color: Color32| {
        let area = egui::Area::new(egui::Id::unique(id)).interactable(false).pivot(pivot).fixed_pos(at);
        let shown = area.show(ui.ctx(), |ui| {
            let frame =
                egui::Frame::new().fill(Color32::from_black_alpha(150)).inner_margin(5).corner_radius(4);
            let lines = frame.show(ui, |ui| {
                ui.set_max_width((scene.width() - 24.0).max(80.0));
                for line in lines {
                    ui.label(RichText::new(*line).color(color));
                }
            });
            lines.response.rect
        });
        // The library puts a box in its place by the size that it had in the frame before.
        if (pivot.pos_in_rect(&shown.inner) - at).length() > 1.0 {
            ui.ctx().request_discard("the size of a text has changed");
        }
    };
    let status: Vec<&str> = model.status.iter().map(String::as_str).collect();
    if !status.is_empty() {
        let at = scene.left_bottom() + egui::vec2(8.0, -8.0);
        text_box("status", Align2::LEFT_BOTTOM, at, &status, Color32::from_gray(220));
    }
    if let Some(notice) = model.notice {
        let at = scene.center_top() + egui::vec2(0.0, 10.0);
        text_box("notice", Align2::CENTER_TOP, at, &[notice], Color32::from_rgb(255, 224, 150));
    }
}

/// The key bindings, over the middle of the scene.
pub(super) fn help(ui: &Ui, model: &PanelModel<'_>) {
    let scene = ui.available_rect_before_wrap();
    egui::Area::new(egui::Id::unique("help"))
        .order(egui::Order::Foreground)
        .pivot(Align2::CENTER_CENTER)
        .fixed_pos(scene.center())
        .show(ui.ctx(), |ui| {
            egui::Frame::new().fill(Color32::from_black_alpha(225)).inner_margin(16).corner_radius(8).show(
                ui,
                |ui| {
                    ui.visuals_mut().override_text_color = Some(Color32::from_gray(225));
                    ui.heading("Keys");
                    let height = (scene.height() - 90.0).max(60.0);
                    let keys = egui::ScrollArea::vertical().max_height(height).min_scrolled_height(height);
                    keys.show(ui, |ui| {
                        egui::Grid::new("keys").num_columns(2).spacing([18.0, 3.0]).show(ui, |ui| {
                            for row in BINDINGS {
                                ui.label(RichText::new(row.keys.join("  ")).strong().monospace());
                                ui.label(row.help);
                                ui.end_row();
                            }
                            for (gesture, effect) in POINTER_HELP {
                                ui.label(RichText::new(*gesture).strong());
                                ui.label(*effect);
                                ui.end_row();
                            }
                        });
                    });
                    ui.small(model.device);
                },
            );
        });
}
