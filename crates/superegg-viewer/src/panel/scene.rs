//! The sections of the scene: lights, camera, environment, picture. Each function returns the lines of
//! a change.

use egui::{ComboBox, DragValue, Ui};
use superegg_geom::glam::DVec3;
use superegg_lang::{Range, SettingKind, SettingSpec, Settings};
use superegg_scene::{AmbientOcclusion, Camera, Floor, Lens, Light, LightKind, MAX_DEPTH, Scene, Sky};

use super::fields::{color, help, number, number_row, row, scene_settings, slider, vector};
use super::pictures;
use crate::commands::{self, with_numbers};

/// Lines of a change; empty without one.
pub(super) type Lines = Vec<String>;

pub(super) fn lights(ui: &mut Ui, scene: &Scene) -> Lines {
    let mut lines = Lines::new();
    if scene.named_lights().len() == 0 {
        ui.label("The default light: white at 3 4 5. The menu Add has lights, which replace it.");
    }
    for (name, light) in scene.named_lights() {
        ui.horizontal(|ui| {
            ui.strong(name);
            if ui.small_button("remove").on_hover_text(help("unlight")).clicked() {
                lines = vec![commands::remove_light(name)];
            }
        });
        let mut edited = *light;
        if ui.push_id(name, |ui| edit_light(ui, &mut edited)).inner {
            lines = commands::light(name, &edited);
        }
    }
    lines
}

/// Edits a light. Returns whether it has changed.
fn edit_light(ui: &mut Ui, light: &mut Light) -> bool {
    let before = *light;
    match &mut light.kind {
        LightKind::Point { position } => {
            vector(ui, "light", "position", position, 0.05);
        }
        LightKind::Spot { position, target, cone_deg, soft } => {
            vector(ui, "spot", "position", position, 0.05);
            vector(ui, "spot", "towards", target, 0.05);
            slider(ui, "spot", "cone, degrees", cone_deg, 1.0..=180.0);
            slider(ui, "spot", "soft rim", soft, 0.0..=1.0);
        }
        LightKind::Sun { direction } => {
            vector(ui, "sun", "direction", direction, 0.05);
        }
    }
    color(ui, "light", "color", &mut light.color);
    if !matches!(light.kind, LightKind::Sun { .. }) {
        number_row(ui, "light", "k: falloff", &mut light.falloff, 0.001, 0.0..=1e6);
    }
    number_row(ui, "lightRadius", "radius", &mut light.radius, 0.01, 0.0..=1e6);
    // The language rejects a light without a direction.
    if matches!(light.kind, LightKind::Spot { position, target, .. } if position == target)
        || matches!(light.kind, LightKind::Sun { direction } if direction == DVec3::ZERO)
    {
        light.kind = before.kind;
    }
    *light != before
}

pub(super) fn camera(ui: &mut Ui, scene: &Scene) -> Lines {
    let mut camera: Camera = scene.camera;
    let has_moved = [
        vector(ui, "camera", "position", &mut camera.position, 0.05),
        vector(ui, "camera", "target", &mut camera.target, 0.05),
        slider(ui, "camera", "fov, degrees", &mut camera.fov_deg, 1.0..=170.0),
    ]
    .contains(&true);
    let has_turned = vector(ui, "cameraUp", "up", &mut camera.up, 0.02);
    let mut height = camera.ortho_height.unwrap_or(0.0);
    if number_row(ui, "orthographic", "orthographic", &mut height, 0.05, 0.0..=1e9) {
        return vec![with_numbers("orthographic", &[height])];
    }
    let distance = (camera.target - camera.position).length();
    let mut lens = camera.lens.unwrap_or(Lens { radius: 0.0, focus: distance });
    let has_lens = row(ui, "lens, focus", help("lens"), |ui| {
        let fields =
            [number(ui, &mut lens.radius, 0.005, 0.0..=1e6), number(ui, &mut lens.focus, 0.05, 1e-6..=1e9)];
        fields.contains(&true)
    });
    if has_lens {
        return vec![with_numbers("lens", &[lens.radius, lens.focus])];
    }
    // The language rejects a camera without a direction.
    let is_valid = camera.position != camera.target && camera.up != DVec3::ZERO;
    match (has_turned, has_moved) {
        _ if !is_valid => Lines::new(),
        (true, _) => vec![commands::camera_up(&camera)],
        (_, true) => vec![commands::camera(&camera)],
        _ => Lines::new(),
    }
}

pub(super) fn environment(ui: &mut Ui, scene: &Scene) -> Lines {
    let mut lines = Lines::new();
    let mut background = scene.background;
    if color(ui, "background", "background", &mut background) {
        lines = vec![with_numbers("background", &background.to_array())];
    }
    let mut has_sky = scene.sky.is_some();
    if row(ui, "sky", help("sky"), |ui| ui.checkbox(&mut has_sky, "").changed()) {
        let (horizon, zenith) = (DVec3::new(0.7, 0.8, 0.9), DVec3::new(0.1, 0.2, 0.6));
        let sky = Sky { horizon, zenith, up: scene.up() };
        return vec![if has_sky { commands::sky(&sky) } else { "unsky".to_owned() }];
    }
    if let Some(mut sky) = scene.sky {
        let has_changed = [
            color(ui, "sky", "  horizon", &mut sky.horizon),
            color(ui, "sky", "  zenith", &mut sky.zenith),
            vector(ui, "sky", "  up", &mut sky.up, 0.02),
        ];
        if has_changed.contains(&true) && sky.up != DVec3::ZERO {
            lines = vec![commands::sky(&sky)];
        }
    }
    lines.extend(pictures::surroundings(ui, scene));
    lines.extend(floor(ui, scene));
    let mut occlusion = scene.ambient_occlusion.unwrap_or(AmbientOcclusion { samples: 0, distance: 1.0 });
    let has_occlusion = row(ui, "ao samples", help("ambientOcclusion"), |ui| {
        let samples = DragValue::new(&mut occlusion.samples).range(0..=1024).update_while_editing(false);
        let has_samples = ui.add(samples).changed();
        ui.label("distance");
        number(ui, &mut occlusion.distance, 0.02, 1e-6..=1e9) || has_samples
    });
    if has_occlusion {
        let numbers = [f64::from(occlusion.samples), occlusion.distance];
        lines = vec![with_numbers("ambientOcclusion", &numbers)];
    }
    let mut depth = scene.depth;
    let has_depth = row(ui, "depth, levels", help("setDepth"), |ui| {
        ui.add(egui::Slider::new(&mut depth, 0..=MAX_DEPTH).update_while_editing(false)).changed()
    });
    if has_depth {
        lines = vec![with_numbers("setDepth", &[f64::from(depth)])];
    }
    lines
}

fn floor(ui: &mut Ui, scene: &Scene) -> Lines {
    let mut has_floor = scene.floor.is_some();
    if row(ui, "floor", help("floor"), |ui| ui.checkbox(&mut has_floor, "").changed()) {
        let floor = Floor { height: -1.0, up: scene.up(), surface: None };
        return if has_floor { commands::floor(&floor) } else { vec!["unfloor".to_owned()] };
    }
    let Some(before) = &scene.floor else { return Lines::new() };
    let mut floor = before.clone();
    number_row(ui, "floor", "  height", &mut floor.height, 0.02, -1e9..=1e9);
    vector(ui, "floorUp", "  up", &mut floor.up, 0.02);
    row(ui, "  surface", help("floor"), |ui| {
        let name = floor.surface.as_deref().unwrap_or("default").to_owned();
        ComboBox::from_id_salt("surface").selected_text(name).show_ui(ui, |ui| {
            for (name, _) in scene.primitives().take(MOST_SURFACES) {
                if ui.selectable_label(floor.surface.as_deref() == Some(name), name).clicked() {
                    floor.surface = Some(name.into());
                }
            }
        });
    });
    if floor == *before || floor.up == DVec3::ZERO { Lines::new() } else { commands::floor(&floor) }
}

/// Most primitives that are listed as surfaces.
const MOST_SURFACES: usize = 200;

/// All settings of the picture, from the language's table.
pub(super) fn picture(ui: &mut Ui, scene: &Scene) -> Lines {
    let mut lines = Lines::new();
    for spec in scene_settings() {
        let value = spec.value(&scene.picture, &Settings::default());
        let tip = format!("set {}: {} ({})", spec.name, spec.summary, spec.kind.describe());
        let changed = row(ui, spec.name, tip, |ui| edit_setting(ui, spec, &value));
        if let Some(value) = changed {
            lines = vec![commands::set(spec.name, &value)];
        }
    }
    lines
}

fn edit_setting(ui: &mut Ui, spec: &SettingSpec, value: &str) -> Option<String> {
    match spec.kind {
        SettingKind::Switch => {
            let mut is_on = value == "on";
            let has_changed = ui.checkbox(&mut is_on, "").changed();
            has_changed.then(|| if is_on { "on" } else { "off" }.to_owned())
        }
        SettingKind::Choice(words) => {
            let mut chosen = None;
            ComboBox::from_id_salt(spec.name).selected_text(value).show_ui(ui, |ui| {
                for word in words {
                    if ui.selectable_label(*word == value, *word).clicked() {
                        chosen = Some((*word).to_owned());
                    }
                }
            });
            chosen
        }
        SettingKind::Size => {
            let (width, height) = value.split_once('x')?;
            let (mut width, mut height): (u32, u32) = (width.parse().ok()?, height.parse().ok()?);
            let mut side = |value| ui.add(DragValue::new(value).range(1..=32768).update_while_editing(false));
            let has_changed = [side(&mut width).changed(), side(&mut height).changed()].contains(&true);
            has_changed.then(|| format!("{width}x{height}"))
        }
        SettingKind::Number(range) => {
            let mut number: f64 = value.parse().ok()?;
            let (range, speed) = match range {
                Range::Whole(least, most) => (f64::from(least)..=f64::from(most), 0.2),
                Range::Within(least, most) if most - least <= 1.0 => (least..=most, 0.001),
                Range::Within(least, most) => (least..=most, 0.02),
                _ => (f64::MIN..=f64::MAX, 0.01),
            };
            let is_whole = matches!(spec.kind, SettingKind::Number(Range::Whole(..)));
            let field = DragValue::new(&mut number).speed(speed).range(range).update_while_editing(false);
            let field = if is_whole { field.max_decimals(0) } else { field };
            let has_changed = ui.add(field).changed();
            if is_whole {
                number = number.round();
            }
            has_changed.then(|| crate::text::number_text(number, commands::DECIMALS))
        }
    }
}
