//! The sections of the view: switches and tests.

use egui::{ComboBox, RichText, Slider, Ui};
use superegg_render::Output;
use superegg_scene::{Shading, Theme};

use super::fields::row;
use super::model::PanelEvent;
use crate::commands::DECIMALS;
use crate::input::ViewState;
use crate::input::keys::Action;
use crate::protocol::Frames;
use crate::queries::CastHit;
use crate::text::{number_text, vector_text};

/// The switches of the view.
pub(super) fn switches(ui: &mut Ui, view: &mut ViewState, events: &mut Vec<PanelEvent>) {
    let settings = view.settings;
    for (is_on, text, action) in [
        (settings.wireframe, "wireframe (t)", Action::ToggleWireframe),
        (settings.normals, "normals in wireframe (n)", Action::ToggleNormals),
        (settings.shading == Shading::Phong, "shading per pixel (m)", Action::ToggleShading),
        (settings.lights_turn, "lights turn with the scene (b)", Action::ToggleLightsTurn),
        (settings.axes, "axes and lights (a)", Action::ToggleAxes),
        (view.is_traced, "ray traced (p)", Action::ToggleTrace),
    ] {
        let mut shown = is_on;
        if ui.checkbox(&mut shown, text).changed() {
            events.push(PanelEvent::Action(action));
        }
    }
}

/// The quantity that the ray traced picture shows.
pub(super) fn passes(ui: &mut Ui, view: &mut ViewState) {
    ui.add_enabled_ui(view.is_traced, |ui| {
        let tip = "the pass that the ray traced picture (p) shows; F12 saves it".to_owned();
        row(ui, "pass", tip, |ui| {
            ComboBox::from_id_salt("pass").selected_text(view.output.word()).show_ui(ui, |ui| {
                for output in Output::ALL {
                    ui.selectable_value(&mut view.output, output, output.word());
                }
            });
        });
    });
}

/// The colours of menus and panels.
pub(super) fn theme(ui: &mut Ui, view: &mut ViewState, events: &mut Vec<PanelEvent>) {
    let tip = "set theme: the colours of menus and panels".to_owned();
    row(ui, "theme", tip, |ui| {
        for (theme, text) in [(Theme::System, "system"), (Theme::Light, "light"), (Theme::Dark, "dark")] {
            if ui.selectable_value(&mut view.settings.theme, theme, text).changed() {
                events.push(PanelEvent::SettingsChanged);
            }
        }
    });
}

/// The slider over the frames of a series.
pub(super) fn frame_slider(ui: &mut Ui, frames: Frames, is_playing: bool, events: &mut Vec<PanelEvent>) {
    let last = frames.count.saturating_sub(1);
    let mut frame = frames.current;
    ui.horizontal(|ui| {
        for (text, action, help) in [
            ("<", Action::PreviousFrame, "the frame before (,)"),
            (">", Action::NextFrame, "the next frame (.)"),
            (if is_playing { "Stop" } else { "Play" }, Action::TogglePlaying, "Space"),
        ] {
            if ui.button(text).on_hover_text(help).clicked() {
                events.push(PanelEvent::Action(action));
            }
        }
        if ui.add(Slider::new(&mut frame, 0..=last).text(format!("of 0 to {last}"))).changed() {
            events.push(PanelEvent::Frame(frame));
        }
    });
}

/// The inside-outside test.
pub(super) fn io_settings(ui: &mut Ui, view: &mut ViewState, events: &mut Vec<PanelEvent>) {
    let mut is_on = view.settings.io_test;
    if ui.checkbox(&mut is_on, "shown (o): red inside, blue outside").changed() {
        events.push(PanelEvent::Action(Action::ToggleIoTest));
    }
    let mut has_outside = view.settings.io_outside;
    if ui.checkbox(&mut has_outside, "points outside (u)").changed() {
        events.push(PanelEvent::Action(Action::ToggleOutside));
    }
    let settings = &mut view.settings;
    if ui.checkbox(&mut settings.io_fit, "the grid suits the scene").changed() {
        events.push(PanelEvent::SettingsChanged);
    }
    if settings.io_fit {
        return;
    }
    for (value, range, text) in [
        (&mut settings.io_step, 0.05..=5.0, "step"),
        (&mut settings.io_half, 0.5..=50.0, "extent"),
        (&mut settings.io_jitter, 0.0..=0.5, "jitter"),
        (&mut settings.io_radius, 0.005..=1.0, "radius"),
    ] {
        if ui
            .add(Slider::new(value, range).logarithmic(true).text(text).update_while_editing(false))
            .changed()
        {
            events.push(PanelEvent::SettingsChanged);
        }
    }
}

/// The intersection test and its hit.
pub(super) fn intersection(
    ui: &mut Ui,
    view: &mut ViewState,
    hit: Option<&CastHit>,
    events: &mut Vec<PanelEvent>,
) {
    let mut is_on = view.settings.intersect_test;
    if ui.checkbox(&mut is_on, "shown (i); a click casts the pixel's ray").changed() {
        events.push(PanelEvent::Action(Action::ToggleIntersectTest));
    }
    if !view.settings.intersect_test {
        return;
    }
    ui.label(if view.cast.is_some() {
        "The ray of the click:"
    } else {
        "The eye's own ray, straight ahead:"
    });
    if view.cast.is_some() && ui.small_button("back to the eye's own ray").clicked() {
        view.cast = None;
    }
    let Some(hit) = hit else {
        ui.label("hits nothing");
        return;
    };
    egui::Grid::new("hit").num_columns(2).show(ui, |ui| {
        let steps = match hit.newton_steps {
            Some(steps) => steps.to_string(),
            None => "none: roots isolated by bounds".to_owned(),
        };
        for (label, text) in [
            ("t", number_text(hit.t, DECIMALS)),
            ("point", vector_text(hit.point, DECIMALS)),
            ("normal", vector_text(hit.normal, DECIMALS)),
            ("path", hit.path.clone()),
            ("Newton steps", steps),
        ] {
            ui.label(label);
            ui.add(egui::Label::new(RichText::new(text).monospace()).wrap());
            ui.end_row();
        }
    });
}
