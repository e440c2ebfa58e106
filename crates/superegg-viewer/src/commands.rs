//! Lines of the modelling language for changes made in the window.
//!
//! This file is the only one that spells commands; its tests run the lines through the real parser.

use std::path::Path;

use superegg_geom::TransformStep;
use superegg_geom::glam::DVec3;
use superegg_scene::{
    Camera, Daylight, Entity, EnvironmentLight, EnvironmentPicture, Floor, Light, LightKind, Pattern, Sky,
    Texture, TextureChannel, numbered_name,
};

use crate::text::{number_text, vector_text};

/// Decimals of a number in a line.
pub(crate) const DECIMALS: usize = 6;

fn number(x: f64) -> String {
    number_text(x, DECIMALS)
}

fn vector(v: DVec3) -> String {
    vector_text(v, DECIMALS)
}

/// A command with numbers.
pub(crate) fn with_numbers(word: &str, numbers: &[f64]) -> String {
    let words = std::iter::once(word.to_owned()).chain(numbers.iter().map(|x| number(*x)));
    words.collect::<Vec<_>>().join(" ")
}

/// Changes a setting.
pub(crate) fn set(setting: &str, value: &str) -> String {
    format!("set {setting} {value}")
}

pub(crate) fn fresnel(is_on: bool) -> String {
    format!("setFresnel {}", if is_on { "on" } else { "off" })
}

pub(crate) fn pattern(pattern: &Pattern) -> String {
    let word = pattern.word();
    match (pattern, pattern.color(), pattern.size()) {
        (Pattern::Gradient { color, direction }, ..) => {
            format!("setPattern {word} {} {}", vector(*color), vector(*direction))
        }
        (_, Some(color), Some(size)) => format!("setPattern {word} {} {}", vector(color), number(size)),
        _ => format!("setPattern {word}"),
    }
}

/// Sets the texture of a channel, or removes it.
pub(crate) fn texture(channel: TextureChannel, texture: Option<&Texture>) -> String {
    let word = channel.word();
    let Some(Texture { file, mapping, scale, height }) = texture else {
        return format!("setTexture {word} none");
    };
    let height = height.map(|height| format!(" {}", number(height))).unwrap_or_default();
    format!("setTexture {word} \"{file}\" {} {}{height}", number(*scale), mapping.word())
}

/// Sets the light from all around, or removes it.
pub(crate) fn surroundings(light: Option<&EnvironmentLight>) -> String {
    match light {
        None => "unenvironment".to_owned(),
        Some(EnvironmentLight::Picture(EnvironmentPicture { file, rotation_deg, scale })) => {
            format!("environment \"{file}\" {} {}", number(*rotation_deg), number(*scale))
        }
        Some(EnvironmentLight::Daylight(Daylight { elevation_deg, turbidity, azimuth_deg })) => {
            with_numbers("daylight", &[*elevation_deg, *turbidity, *azimuth_deg])
        }
    }
}

pub(crate) fn sky(sky: &Sky) -> String {
    format!("sky {} {} {}", vector(sky.horizon), vector(sky.zenith), vector(sky.up))
}

pub(crate) fn floor(floor: &Floor) -> Vec<String> {
    let height = number(floor.height);
    match &floor.surface {
        Some(surface) => vec![format!("floor {height} {surface} {}", vector(floor.up))],
        None => vec![format!("floor {height}"), format!("floorUp {}", vector(floor.up))],
    }
}

/// Begins a new scene.
pub(crate) fn new_scene() -> String {
    "new".to_owned()
}

pub(crate) fn recover() -> String {
    "recover".to_owned()
}

/// Stops the picture that is rendered.
pub(crate) fn stop_render() -> String {
    "stop render".to_owned()
}

/// Discards the last session that ended without a save.
pub(crate) fn discard_unsaved() -> String {
    "recover discard 1".to_owned()
}

/// A command with a file. `None` for a name that no line can have.
pub(crate) fn with_file(command: &str, path: &Path) -> Option<String> {
    let name = path.to_str().filter(|name| !name.contains(['"', '\n', '\r']))?;
    Some(format!("{command} \"{name}\""))
}

pub(crate) fn undo() -> String {
    "undo".to_owned()
}

pub(crate) fn redo() -> String {
    "redo".to_owned()
}

/// Selects a primitive or an object.
pub(crate) fn select(name: &str, entity: &Entity) -> String {
    match entity {
        Entity::Object(_) | Entity::Table(_) => format!("object {name}"),
        Entity::Primitive(_) => select_primitive(name),
    }
}

pub(crate) fn select_primitive(name: &str) -> String {
    format!("primitive {name}")
}

pub(crate) fn select_object(name: &str) -> String {
    format!("object {name}")
}

/// Adds a child to the selected object.
pub(crate) fn add_child(target: &str, entity: &Entity, alias: &str) -> String {
    let word = match entity {
        Entity::Primitive(_) => "addPrimitive",
        Entity::Object(_) | Entity::Table(_) => "addObject",
    };
    format!("{word} {target} {alias}")
}

/// Adds a primitive to the selected object.
pub(crate) fn add_primitive(name: &str) -> String {
    format!("addPrimitive {name}")
}

/// Adds an object to the selected object.
pub(crate) fn add_object(name: &str) -> String {
    format!("addObject {name}")
}

/// Removes a child of the selected object.
pub(crate) fn remove_child(alias: &str) -> String {
    format!("remove {alias}")
}

pub(crate) fn rename_child(alias: &str, new: &str) -> String {
    format!("renameChild {alias} {new}")
}

/// Hides a child of the selected object.
pub(crate) fn hide(alias: &str) -> String {
    format!("hide {alias}")
}

/// Shows a child of the selected object again.
pub(crate) fn unhide(alias: &str) -> String {
    format!("unhide {alias}")
}

/// Shows all children of the selected object.
pub(crate) fn unhide_all() -> String {
    "unhide".to_owned()
}

pub(crate) fn delete(name: &str) -> String {
    format!("delete {name}")
}

pub(crate) fn rename(name: &str, new: &str) -> String {
    format!("rename {name} {new}")
}

pub(crate) fn copy(name: &str, new: &str) -> String {
    format!("copy {name} {new}")
}

pub(crate) fn set_exponents(e: f64, n: f64) -> String {
    format!("setExponent {} {}", number(e), number(n))
}

/// A name that is not taken: the word itself, or with the first number that makes it free.
pub(crate) fn free_name(word: &str, is_taken: impl Fn(&str) -> bool) -> String {
    let stem = word.trim_end_matches(|c: char| c.is_ascii_digit());
    let stem = if stem.is_empty() { word } else { stem };
    if is_taken(word) { numbered_name(stem, 2, is_taken) } else { word.to_owned() }
}

/// Whether a word can be the name of something new.
pub(crate) fn is_name(word: &str) -> bool {
    !word.is_empty()
        && !word.contains(|c: char| c.is_whitespace() || c.is_control() || matches!(c, '#' | '"' | ';'))
}

/// Moves the cursor of the selected object to a child.
pub(crate) fn set_cursor(alias: &str) -> String {
    format!("setCursor {alias}")
}

/// Defines a light. A second line sets its radius if it has one.
pub(crate) fn light(name: &str, light: &Light) -> Vec<String> {
    let (color, falloff) = (vector(light.color), number(light.falloff));
    let mut lines = vec![match light.kind {
        LightKind::Point { position } => format!("light {name} {} {color} {falloff}", vector(position)),
        LightKind::Spot { position, target, cone_deg, soft } => format!(
            "spot {name} {} {} {} {color} {falloff} {}",
            vector(position),
            vector(target),
            number(cone_deg),
            number(soft)
        ),
        LightKind::Sun { direction } => format!("sun {name} {} {color}", vector(direction)),
    }];
    if light.radius > 0.0 {
        lines.push(format!("lightRadius {name} {}", number(light.radius)));
    }
    lines
}

pub(crate) fn remove_light(name: &str) -> String {
    format!("unlight {name}")
}

/// Sets position, target and field of view.
pub(crate) fn camera(camera: &Camera) -> String {
    let (position, target) = (vector(camera.position), vector(camera.target));
    format!("camera {position} {target} {}", number(camera.fov_deg))
}

pub(crate) fn camera_up(camera: &Camera) -> String {
    format!("cameraUp {}", vector(camera.up))
}

/// Makes a view the scene's camera, in place of the camera `before`. Positions are rounded to a
/// millionth of the distance to the target, which cannot be seen.
pub(crate) fn view_as_camera(camera: &Camera, before: &Camera) -> Vec<String> {
    let distance = (camera.position - camera.target).length();
    let decimals = (6.0 - distance.log10().floor()).clamp(0.0, 17.0) as usize;
    let (position, target) = (vector_text(camera.position, decimals), vector_text(camera.target, decimals));
    let mut lines = vec![format!("camera {position} {target} {}", number_text(camera.fov_deg, 6))];
    if let Some(height) = camera.ortho_height.filter(|_| camera.ortho_height != before.ortho_height) {
        lines.push(format!("orthographic {}", number_text(height, decimals)));
    }
    if (camera.up - before.up).length() > 1e-9 {
        lines.insert(0, format!("cameraUp {}", vector_text(camera.up, 7)));
    }
    lines
}

/// Appends a transform step to the child at the cursor, or to the whole object.
pub(crate) fn transform_step(step: &TransformStep, of_whole: bool) -> String {
    let all = if of_whole { "All" } else { "" };
    match step {
        TransformStep::Translate(by) => format!("translate{all} {}", vector(*by)),
        TransformStep::Rotate { axis, angle_deg } => {
            format!("rotate{all} {} {}", vector(*axis), number(*angle_deg))
        }
        TransformStep::Scale(factors) => format!("scale{all} {}", vector(*factors)),
        TransformStep::Orient(q) => {
            format!("orient{all} {}", [q.w, q.x, q.y, q.z].map(number).join(" "))
        }
        TransformStep::Affine(map) => {
            let rows = map.matrix3.transpose();
            let row = |row: DVec3, offset: f64| format!("{} {}", vector(row), number(offset));
            let by = map.translation;
            let rows = [row(rows.x_axis, by.x), row(rows.y_axis, by.y), row(rows.z_axis, by.z)];
            format!("matrix{all} {}", rows.join(" "))
        }
    }
}

#[cfg(test)]
mod tests {
    use superegg_geom::glam::{DAffine3, DMat3, DQuat};
    use superegg_geom::{Exponents, Superquadric};
    use superegg_lang::Session;
    use superegg_scene::{Patches, TextureMapping};

    use super::*;

    /// Every line runs, and the session's scene equals the draft that the window showed.
    #[test]
    fn lines_of_the_panel_are_commands() {
        let mut session = Session::default();
        for line in ["prm ball", "obj o", "ap ball"] {
            assert!(session.run_line(line).is_ok());
        }
        let light = Light {
            kind: LightKind::Point { position: DVec3::new(1.5, -2.0, 0.0) },
            color: DVec3::splat(0.25),
            ..Light::DEFAULT
        };
        let camera = Camera { position: DVec3::new(1.0, 2.0, -3.0), fov_deg: 45.5, ..Camera::default() };
        let steps = [
            TransformStep::Translate(DVec3::new(0.1, 0.0, -2.0)),
            TransformStep::Rotate { axis: DVec3::Y, angle_deg: -30.0 },
            TransformStep::Scale(DVec3::splat(1.5)),
            TransformStep::Orient(DQuat::from_xyzw(0.5, -0.5, 0.25, 0.75)),
            TransformStep::Affine(Box::new(DAffine3 {
                matrix3: DMat3::from_cols(DVec3::Y, DVec3::new(0.5, 0.25, 0.0), DVec3::Z * 2.0),
                translation: DVec3::new(1.0, -2.0, 3.5),
            })),
        ];
        let mut expected = session.scene().clone();
        let spot = Light {
            kind: LightKind::Spot { position: DVec3::Y * 4.0, target: DVec3::X, cone_deg: 35.5, soft: 0.25 },
            radius: 0.5,
            ..light
        };
        let sun = Light {
            kind: LightKind::Sun { direction: DVec3::new(1.0, 3.0, 2.0) },
            falloff: 0.0,
            radius: 0.0047,
            ..light
        };
        for (name, light) in [("light1", light), ("spot1", spot), ("sun1", sun)] {
            expected.set_light(name, light);
        }
        expected.camera = camera;
        expected.sets_camera = true;
        let mut lines = vec![super::camera(&camera)];
        for (name, light) in [("light1", light), ("spot1", spot), ("sun1", sun)] {
            lines.extend(super::light(name, &light));
        }
        for of_whole in [false, true] {
            for step in steps.clone() {
                lines.push(transform_step(&step, of_whole));
                let done = if of_whole {
                    expected.transform_whole("o", step)
                } else {
                    expected.transform_child("o", step)
                };
                assert!(done.is_ok());
            }
        }
        for line in &lines {
            assert!(session.run_line(line).is_ok(), "{line}");
        }
        assert_eq!(*session.scene(), expected);
    }

    #[test]
    fn lines_of_pictures_are_commands() {
        let mut session = Session::default();
        assert!(session.run_line("prm ball").is_ok());
        let bump = Texture {
            file: "old wall.png".into(),
            mapping: TextureMapping::Box,
            scale: 2.5,
            height: Some(-0.125),
        };
        let color = Texture { mapping: TextureMapping::Around, height: None, ..bump.clone() };
        for (channel, texture) in [(TextureChannel::Bump, bump), (TextureChannel::Color, color)] {
            let line = super::texture(channel, Some(&texture));
            assert!(session.run_line(&line).is_ok(), "{line}");
            let found = |session: &Session| {
                let textures = session.scene().primitives().next().unwrap().1.textures.clone();
                textures.and_then(|textures| textures.get(channel).cloned())
            };
            assert_eq!(found(&session), Some(texture), "{line}");
            let line = super::texture(channel, None);
            assert!(session.run_line(&line).is_ok(), "{line}");
            assert_eq!(found(&session), None);
        }
        let picture = EnvironmentPicture { file: "a sky.hdr".into(), rotation_deg: -90.0, scale: 0.5 };
        let daylight = Daylight { elevation_deg: 12.5, turbidity: 3.0, azimuth_deg: -40.0 };
        for light in [EnvironmentLight::Picture(picture), EnvironmentLight::Daylight(daylight)]
            .map(Some)
            .into_iter()
            .chain([None])
        {
            let line = surroundings(light.as_ref());
            assert!(session.run_line(&line).is_ok(), "{line}");
            assert_eq!(session.scene().environment, light, "{line}");
        }
    }

    #[test]
    fn files_are_named_in_quotes() {
        for name in ["a.scn", "a b#c.scn", "größe.scn", "/x/y"] {
            for command in ["load", "save", "save!", "include", "export"] {
                let line = with_file(command, Path::new(name)).unwrap();
                let parsed = superegg_lang::parse_line(&line).unwrap().unwrap();
                assert!(format!("{:?}", parsed.command).contains(&format!("{name:?}")), "{line}");
            }
        }
        assert_eq!(with_file("load", Path::new("a\"b")), None);
    }

    #[test]
    fn lines_of_a_primitive_and_of_the_picture_are_commands() {
        let mut session = Session::default();
        assert!(session.run_line("prm ball").is_ok());
        let mut expected = session.scene().clone();
        let primitive = expected.primitive_mut("ball").unwrap();
        primitive.shape =
            Superquadric::new(DVec3::new(1.0, 2.5, 3.0), Exponents::new(0.5, 1.25).unwrap()).unwrap();
        primitive.patches = Patches { u: 20, v: 11 };
        let material = &mut primitive.material;
        material.color = DVec3::new(0.5, 0.25, 1.0);
        (material.ambient, material.reflected, material.fresnel) = (0.1, Some(0.6), true);
        material.pattern = Pattern::Gradient { color: DVec3::X, direction: DVec3::Y };
        expected.background = DVec3::new(0.0, 0.125, 0.5);
        expected.sky = Some(Sky { horizon: DVec3::ONE, zenith: DVec3::X, up: DVec3::Z });
        expected.floor = Some(Floor { height: -1.5, up: DVec3::Z, surface: Some("ball".into()) });
        expected.picture.samples = 9;
        expected.camera.up = DVec3::X;
        let mut lines = vec![
            with_numbers("setCoeff", &[1.0, 2.5, 3.0]),
            set_exponents(0.5, 1.25),
            with_numbers("setPatch", &[20.0, 11.0]),
            with_numbers("setColor", &[0.5, 0.25, 1.0]),
            with_numbers("setAmbient", &[0.1]),
            with_numbers("setReflected", &[0.6]),
            fresnel(true),
            pattern(&Pattern::Checker { color: DVec3::X, size: 0.25 }),
            pattern(&Pattern::Gradient { color: DVec3::X, direction: DVec3::Y }),
            with_numbers("background", &[0.0, 0.125, 0.5]),
            sky(&expected.sky.unwrap()),
            set("samples", "9"),
            super::camera_up(&expected.camera),
        ];
        lines.extend(super::floor(&Floor { height: 0.0, up: DVec3::Y, surface: None }));
        lines.extend(super::floor(expected.floor.as_ref().unwrap()));
        for line in &lines {
            assert!(session.run_line(line).is_ok(), "{line}");
        }
        assert_eq!(*session.scene(), expected);
        let others = [
            super::light("lamp", &Light::DEFAULT).remove(0),
            remove_light("lamp"),
            "object o".to_owned(),
            "addPrimitive ball".to_owned(),
            set_cursor("ball"),
            select_primitive("ball"),
            select_object("o"),
            add_child("ball", &Entity::Primitive(superegg_scene::Primitive::default()), "two"),
            add_object("o"),
            rename_child("o", "inner"),
            hide("inner"),
            unhide("inner"),
            unhide_all(),
            remove_child("inner"),
            copy("ball", "egg"),
            rename("egg", "nut"),
            delete("nut"),
            select_primitive("cube"),
            set_exponents(0.1, 0.1),
            select_object("o"),
            add_primitive("cube"),
            new_scene(),
            recover(),
            discard_unsaved(),
            stop_render(),
        ];
        for line in &others {
            assert!(session.run_line(line).is_ok(), "{line}");
        }
    }
}
