//! The menu at the top, and the offer of a session that ended without a save.

use std::path::Path;

use egui::{Button, MenuBar, Ui};

use super::add::add_menu;
use super::model::{PanelEvent, PanelModel};
use crate::commands;
use crate::input::FileAction;
use crate::input::keys::{Action, BINDINGS};

/// Draws the menu.
pub(super) fn menu(ui: &mut Ui, model: &PanelModel<'_>, events: &mut Vec<PanelEvent>) {
    MenuBar::new().ui(ui, |ui| {
        ui.menu_button("File", |ui| file_menu(ui, model, events));
        ui.menu_button("Edit", |ui| {
            for (text, act) in [
                ("Undo", Action::Undo),
                ("Redo", Action::Redo),
                ("Duplicate the child", Action::Duplicate),
                ("Remove the child", Action::Delete),
                ("Move", Action::MoveTool),
                ("Rotate", Action::RotateTool),
                ("Scale", Action::ScaleTool),
            ] {
                action(ui, text, act, events);
            }
        });
        ui.menu_button("Add", |ui| add_menu(ui, model, events));
        ui.menu_button("View", |ui| {
            for (text, act) in [
                ("Frame what is selected", Action::FrameSelected),
                ("Frame all", Action::FrameAll),
                ("From the front", Action::FrontView),
                ("From the right", Action::RightView),
                ("From the top", Action::TopView),
                ("The scene's camera", Action::Home),
                ("Use this view as the camera", Action::WriteCamera),
                ("Ray traced, on or off", Action::ToggleTrace),
                ("Wireframe, on or off", Action::ToggleWireframe),
                ("Refresh", Action::Refresh),
                ("Hide menu and panel", Action::TogglePanel),
            ] {
                action(ui, text, act, events);
            }
        });
        ui.menu_button("Render", |ui| {
            action(ui, "Render to a picture ...", Action::Render, events);
            if ui.add_enabled(model.rendering.is_some(), Button::new("Stop")).clicked() {
                events.push(PanelEvent::Command(commands::stop_render()));
            }
        });
        ui.menu_button("Help", |ui| action(ui, "Keys", Action::ToggleHelp, events));
    });
}

fn file_menu(ui: &mut Ui, model: &PanelModel<'_>, events: &mut Vec<PanelEvent>) {
    for (text, act) in [("New", Action::New), ("Open ...", Action::Open)] {
        action(ui, text, act, events);
    }
    ui.add_enabled_ui(!model.document.recent.is_empty(), |ui| {
        ui.menu_button("Open recent", |ui| {
            for path in &model.document.recent {
                let name = path.file_name().unwrap_or_default().to_string_lossy();
                let folder = path.parent().unwrap_or(Path::new("")).display().to_string();
                if ui.button(name).on_hover_text(folder).clicked() {
                    events.push(PanelEvent::File(FileAction::OpenFile(path.clone())));
                }
            }
        });
    });
    ui.separator();
    for (text, act) in [("Save", Action::Save), ("Save as ...", Action::SaveAs)] {
        action(ui, text, act, events);
    }
    ui.separator();
    for (text, act) in
        [("Import ...", FileAction::Import), ("Export ...", FileAction::Export), ("Close", FileAction::Leave)]
    {
        if ui.button(text).clicked() {
            events.push(PanelEvent::File(act));
        }
    }
}

/// A row of a menu with the key of its action.
fn action(ui: &mut Ui, text: &str, action: Action, events: &mut Vec<PanelEvent>) {
    let key = BINDINGS.iter().find(|row| row.action == action).and_then(|row| row.keys.first());
    let button = Button::new(text).shortcut_text(key.copied().unwrap_or_default());
    if ui.add(button).clicked() {
        events.push(PanelEvent::Action(action));
    }
}

/// Shows the progress of a picture with a button that stops it.
pub(super) fn progress(ui: &mut Ui, progress: &str, events: &mut Vec<PanelEvent>) {
    ui.horizontal(|ui| {
        ui.spinner();
        ui.label(format!("rendering {progress}"));
        if ui.button("Stop").clicked() {
            events.push(PanelEvent::Command(commands::stop_render()));
        }
    });
}

/// Offers the session that ended without a save.
pub(super) fn offer_recovery(ui: &mut Ui, unsaved: &str, events: &mut Vec<PanelEvent>) {
    ui.horizontal_wrapped(|ui| {
        ui.label(format!("An earlier session was not saved: {unsaved}."));
        for (text, event) in [
            ("Recover", PanelEvent::Command(commands::recover())),
            ("Discard", PanelEvent::Command(commands::discard_unsaved())),
            ("Later", PanelEvent::RecoverLater),
        ] {
            if ui.button(text).clicked() {
                events.push(event);
            }
        }
    });
}
