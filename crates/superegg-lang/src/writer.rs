//! A session back to text that loads to the same session.

use std::collections::HashMap;
use std::fmt::Write;

use superegg_geom::TransformStep;
use superegg_scene::{Camera, Entity, Light, Material, Object, Primitive, Scene};

use crate::info::vector;
use crate::number::format_number;
use crate::session::Session;
use crate::settings;

/// The session as commands: the settings, then a block for each primitive and object, then what is selected. What has its default value is
/// left out; numbers read back to the same bits. Loading the text gives the same session.
pub fn write_session(session: &Session) -> String {
    let scene = session.scene();
    let mut text = String::from("# superegg scene\n");
    write_settings(&mut text, scene);
    let entities: Vec<(&str, &Entity)> = scene.entities().collect();
    let places: HashMap<&str, usize> =
        entities.iter().enumerate().map(|(place, (name, _))| (*name, place)).collect();
    let mut declared = 0;
    for (place, (name, entity)) in entities.iter().enumerate() {
        text.push('\n');
        match entity {
            Entity::Primitive(primitive) => write_primitive(&mut text, name, primitive),
            Entity::Object(object) => {
                // A child must exist before it is added. What is missing is made in the scene's order, so that the order stays.
                let last = object.children().filter_map(|(_, child)| places.get(child.target())).max();
                let needed = last.map_or(0, |last| last + 1);
                for (name, entity) in entities[..needed].iter().skip(declared.max(place)) {
                    line(&mut text, &select(name, entity));
                }
                declared = declared.max(needed);
                write_object(&mut text, scene, name, object);
            }
        }
        declared = declared.max(place + 1);
    }
    text.push('\n');
    match session.selected().and_then(|name| Some((name, scene.get(name)?))) {
        Some((name, entity)) => line(&mut text, &select(name, entity)),
        None => line(&mut text, "deselect"),
    }
    text
}

/// The command that selects an entity, and makes it where it is new.
fn select(name: &str, entity: &Entity) -> String {
    match entity {
        Entity::Primitive(_) => format!("primitive {name}"),
        Entity::Object(_) => format!("object {name}"),
    }
}

fn line(text: &mut String, words: &str) {
    text.push_str(words);
    text.push('\n');
}

fn write_settings(text: &mut String, scene: &Scene) {
    let default = Scene::default();
    let Camera { position, target, up, fov_deg } = scene.camera;
    if (Camera { up: default.camera.up, ..scene.camera }) != default.camera {
        line(text, &format!("camera {} {} {}", vector(position), vector(target), format_number(fov_deg)));
    }
    if up != default.camera.up {
        line(text, &format!("cameraUp {}", vector(up)));
    }
    if scene.background != default.background {
        line(text, &format!("background {}", vector(scene.background)));
    }
    if scene.depth != default.depth {
        line(text, &format!("setDepth {}", scene.depth));
    }
    for setting in settings::lines_of_scene(&scene.picture) {
        line(text, &setting);
    }
    for (name, Light { position, color, falloff }) in scene.named_lights() {
        let numbers = [vector(*position), vector(*color), format_number(*falloff)].join(" ");
        line(text, &format!("light {name} {numbers}"));
    }
}

fn write_primitive(text: &mut String, name: &str, primitive: &Primitive) {
    let Primitive { shape, patches, material } = primitive;
    let default = Primitive::default();
    line(text, &format!("primitive {name}"));
    if shape.radii() != default.shape.radii() {
        line(text, &format!("setCoeff {}", vector(shape.radii())));
    }
    if shape.exponents() != default.shape.exponents() {
        let (e, n) = (format_number(shape.exponents().e), format_number(shape.exponents().n));
        line(text, &format!("setExponent {e} {n}"));
    }
    if *patches != default.patches {
        line(text, &format!("setPatch {} {}", patches.u, patches.v));
    }
    if material.color != default.material.color {
        line(text, &format!("setColor {}", vector(material.color)));
    }
    let plain: Material = default.material;
    for (word, value, default) in [
        ("setAmbient", Some(material.ambient), Some(plain.ambient)),
        ("setReflected", material.reflected, plain.reflected),
        ("setRefracted", material.refracted, plain.refracted),
        ("setGloss", Some(material.gloss), Some(plain.gloss)),
        ("setDiffuse", Some(material.diffuse), Some(plain.diffuse)),
        ("setSpecular", Some(material.specular), Some(plain.specular)),
        ("setIndex", Some(material.index), Some(plain.index)),
        ("setShininess", material.shininess, plain.shininess),
    ] {
        if let Some(value) = value.filter(|_| value != default) {
            line(text, &format!("{word} {}", format_number(value)));
        }
    }
}

fn write_object(text: &mut String, scene: &Scene, name: &str, object: &Object) {
    line(text, &format!("object {name}"));
    for (alias, child) in object.children() {
        let target = child.target();
        let add = if matches!(scene.get(target), Some(Entity::Primitive(_))) {
            "addPrimitive"
        } else {
            "addObject"
        };
        let alias = if alias == target { String::new() } else { format!(" {alias}") };
        line(text, &format!("{add} {target}{alias}"));
        write_steps(text, child.steps(), "");
    }
    write_steps(text, object.overall_steps(), "All");
    if let Some((alias, _)) = object
        .cursor()
        .filter(|(alias, _)| object.children().next_back().is_some_and(|(last, _)| last != *alias))
    {
        line(text, &format!("setCursor {alias}"));
    }
}

/// Steps as commands; `suffix` is "All" for those of the whole object.
fn write_steps<'a>(text: &mut String, steps: impl Iterator<Item = &'a TransformStep>, suffix: &str) {
    for step in steps {
        // Writing to a String cannot fail.
        let _ = match step {
            TransformStep::Translate(by) => writeln!(text, "translate{suffix} {}", vector(*by)),
            TransformStep::Rotate { axis, angle_deg } => {
                writeln!(text, "rotate{suffix} {} {}", vector(*axis), format_number(*angle_deg))
            }
            TransformStep::Scale(factors) => writeln!(text, "scale{suffix} {}", vector(*factors)),
        };
    }
}
