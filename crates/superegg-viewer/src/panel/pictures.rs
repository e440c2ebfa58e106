//! Fields of pictures in files and of light from all around: textures, environment, daylight. Each function returns the
//! line of a change.

use egui::{ComboBox, Key, TextEdit, Ui};
use superegg_scene::{
    Daylight, EnvironmentLight, EnvironmentPicture, Scene, Texture, TextureChannel, TextureMapping, Textures,
};

use super::fields::{help, number, number_row, row, slider};
use crate::commands;

const FILE_WIDTH: f32 = 120.0;

/// Edits the textures of a primitive.
pub(super) fn textures(ui: &mut Ui, textures: Option<&Textures>) -> Option<String> {
    let mut line = None;
    ui.label("texture").on_hover_text(help("setTexture"));
    for channel in TextureChannel::ALL {
        let before = textures.and_then(|textures| textures.get(channel));
        let edited = ui.push_id(channel.word(), |ui| texture(ui, channel, before)).inner;
        line = edited.map(|after| commands::texture(channel, after.as_ref())).or(line);
    }
    line
}

/// Edits a texture. Returns it if it has changed; `Some(None)` removes it.
fn texture(ui: &mut Ui, channel: TextureChannel, before: Option<&Texture>) -> Option<Option<Texture>> {
    let file = before.map_or("", |texture| &*texture.file);
    let label = format!("  {}", channel.word());
    if let Some(file) = row(ui, label, help("setTexture"), |ui| file_field(ui, file)) {
        if file.is_empty() {
            return Some(None);
        }
        let plain = Texture { file: "".into(), mapping: TextureMapping::Around, scale: 1.0, height: None };
        return Some(Some(Texture { file: file.into(), ..before.cloned().unwrap_or(plain) }));
    }
    let mut texture = before?.clone();
    row(ui, "    scale", help("setTexture"), |ui| {
        number(ui, &mut texture.scale, 0.01, 1e-6..=1e6);
        ComboBox::from_id_salt("mapping").selected_text(texture.mapping.word()).show_ui(ui, |ui| {
            for mapping in [TextureMapping::Around, TextureMapping::Box] {
                ui.selectable_value(&mut texture.mapping, mapping, mapping.word());
            }
        });
    });
    if channel == TextureChannel::Bump {
        let mut height = texture.height.unwrap_or(Texture::HEIGHT);
        if number_row(ui, "setTexture", "    height", &mut height, 0.002, -1e6..=1e6) {
            texture.height = Some(height);
        }
    }
    (Some(&texture) != before).then_some(Some(texture))
}

/// Edits the light from all around.
pub(super) fn surroundings(ui: &mut Ui, scene: &Scene) -> Option<String> {
    let before = scene.environment.as_ref();
    let mut after = before.cloned();
    let mut has_daylight = matches!(before, Some(EnvironmentLight::Daylight(_)));
    if row(ui, "daylight", help("daylight"), |ui| ui.checkbox(&mut has_daylight, "").changed()) {
        let morning = Daylight { elevation_deg: 30.0, turbidity: 3.0, azimuth_deg: 0.0 };
        after = has_daylight.then_some(EnvironmentLight::Daylight(morning));
    }
    if let Some(EnvironmentLight::Daylight(light)) = &mut after {
        slider(ui, "daylight", "  elevation", &mut light.elevation_deg, 0.0..=90.0);
        slider(ui, "daylight", "  turbidity", &mut light.turbidity, 1.7..=10.0);
        slider(ui, "daylight", "  azimuth", &mut light.azimuth_deg, -180.0..=180.0);
    }
    let file = match before {
        Some(EnvironmentLight::Picture(picture)) => &*picture.file,
        _ => "",
    };
    if let Some(file) = row(ui, "environment", help("environment"), |ui| file_field(ui, file)) {
        after = match after {
            _ if file.is_empty() => None,
            Some(EnvironmentLight::Picture(picture)) => {
                Some(EnvironmentLight::Picture(EnvironmentPicture { file: file.into(), ..picture }))
            }
            _ => {
                let picture = EnvironmentPicture { file: file.into(), rotation_deg: 0.0, scale: 1.0 };
                Some(EnvironmentLight::Picture(picture))
            }
        };
    }
    if let Some(EnvironmentLight::Picture(picture)) = &mut after {
        slider(ui, "environment", "  rotation", &mut picture.rotation_deg, -360.0..=360.0);
        number_row(ui, "environment", "  scale", &mut picture.scale, 0.01, 0.0..=1e6);
    }
    (after.as_ref() != before).then(|| commands::surroundings(after.as_ref()))
}

/// A field for the name of a file. Returns the name when the field is left; it is empty to remove the picture.
fn file_field(ui: &mut Ui, file: &str) -> Option<String> {
    let id = ui.unique_id().with("typed");
    let mut text = ui.data(|data| data.get_temp::<String>(id)).unwrap_or_else(|| file.to_owned());
    let response = ui.add(TextEdit::singleline(&mut text).hint_text("a file").desired_width(FILE_WIDTH));
    if response.has_focus() {
        ui.data_mut(|data| data.insert_temp(id, text));
        return None;
    }
    if !response.lost_focus() {
        return None;
    }
    ui.data_mut(|data| data.remove::<String>(id));
    let name = text.trim();
    let is_taken = !ui.input(|input| input.key_pressed(Key::Escape)) && name != file;
    // No line can hold a quotation mark in a name.
    (is_taken && !name.contains('"')).then(|| name.to_owned())
}
