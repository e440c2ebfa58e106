//! The writer: a session as text that loads to the same session.

use std::collections::HashSet;
use std::fmt::Write;

use superegg_geom::glam::{DQuat, DVec3};
use superegg_geom::{Superquadric, TransformStep};
use superegg_scene::{
    Camera, Daylight, Entity, EnvironmentLight, EnvironmentPicture, Floor, InstanceTable, Light, LightKind,
    Material, Object, Pattern, Primitive, Scene, Sky, Track,
};

use crate::parse::material_words::{pattern_words, texture_words};
use crate::parse::number::{format_number, matrix_words, quaternion_words, vector};
use crate::session::interpreter::Session;
use crate::session::keys::line_of;
use crate::session::settings;

/// The session as commands. Loading the text gives the same session; numbers read back to the same
/// bits.
///
/// The text has the settings, a block for each primitive and object, the floor (which names a
/// primitive), the keys, and the selection. Default values are omitted. A block follows those of
/// its children; otherwise blocks are in the order of creation. For objects that contain each other,
/// one is created before its block.
///
/// ```
/// let (session, _) = superegg_lang::load_text("egg.scn", "prm egg\ncoeff 1 1 1.3\n");
/// let text = superegg_lang::write_session(&session);
/// assert_eq!(text, "# superegg scene\n\nprimitive egg\nsetCoeff 1 1 1.3\n");
/// ```
pub fn write_session(session: &Session) -> String {
    write_scene(session.scene(), session.selected())
}

/// As [`write_session`], for a scene with this selection. A table of instances becomes an object
/// with a child for each row.
pub fn write_scene(scene: &Scene, selected: Option<&str>) -> String {
    write_blocks(scene, selected, Tables::AsChildren)
}

/// As [`write_scene`], but without the tables of instances: the text loads into a scene that has
/// them already.
pub fn write_without_tables(scene: &Scene, selected: Option<&str>) -> String {
    write_blocks(scene, selected, Tables::Omitted)
}

/// A text that is equal for equal scenes: [`write_scene`], with the rows of tables as one number
/// each. For checksums of pictures.
pub fn fingerprint_text(scene: &Scene, selected: Option<&str>) -> String {
    let mut text = write_without_tables(scene, selected);
    for (name, table) in scene.tables() {
        line(&mut text, &format!("# table {name} {} {:016x}", table.len(), table.fingerprint()));
    }
    text
}

/// How tables of instances are written.
#[derive(Clone, Copy)]
enum Tables {
    AsChildren,
    Omitted,
}

fn write_blocks(scene: &Scene, selected: Option<&str>, tables: Tables) -> String {
    let mut text = String::from("# superegg scene\n");
    if bits(scene.up()) != bits(Scene::default().up()) {
        line(&mut text, &format!("up {}", vector(scene.up())));
    }
    write_settings(&mut text, scene);
    let mut blocks = Blocks { scene, text, tables, begun: HashSet::new(), named: HashSet::new(), last: None };
    for (name, _) in scene.entities() {
        blocks.write(name);
    }
    let Blocks { mut text, mut last, .. } = blocks;
    if let Some(floor) = &scene.floor {
        text.push('\n');
        write_floor(&mut text, floor, scene.up());
    }
    if scene.tracks().len() > 0 {
        text.push('\n');
        last = write_keys(&mut text, scene, last, |_| true);
    }
    match selected.and_then(|name| Some((name, scene.get(name)?))) {
        Some((name, _)) if last == Some(name) => {}
        Some((name, entity)) => line(&mut text, &format!("\n{}", select(name, entity))),
        None if last.is_none() => {}
        None => line(&mut text, "\ndeselect"),
    }
    text
}

/// The lines that add the entities and keys of a scene to another one, for which `is_new` holds.
/// The other entities exist there.
pub(crate) fn write_new(
    scene: &Scene,
    is_new: impl Fn(&str) -> bool,
    is_new_track: impl Fn(&Track) -> bool,
) -> String {
    let existing = || scene.entities().map(|(name, _)| name).filter(|name| !is_new(name));
    let (begun, named) = (existing().collect(), existing().collect());
    let mut blocks =
        Blocks { scene, text: String::new(), tables: Tables::AsChildren, begun, named, last: None };
    for (name, _) in scene.entities() {
        blocks.write(name);
    }
    let Blocks { mut text, last, .. } = blocks;
    write_keys(&mut text, scene, last, is_new_track);
    text
}

/// The blocks written so far.
struct Blocks<'a> {
    scene: &'a Scene,
    text: String,
    tables: Tables,
    /// The entities that are written, or wait for their children.
    begun: HashSet<&'a str>,
    /// The names that exist at this point of the text.
    named: HashSet<&'a str>,
    /// The selection after the last block.
    last: Option<&'a str>,
}

impl<'a> Blocks<'a> {
    /// Writes the block of a name after those of its children. The stack is explicit: nesting has
    /// no limit.
    fn write(&mut self, name: &'a str) {
        let mut waiting: Vec<(&'a str, bool)> = vec![(name, false)];
        while let Some((name, is_ready)) = waiting.pop() {
            if is_ready {
                self.write_block(name);
            } else if self.begun.insert(name) {
                waiting.push((name, true));
                let held = self.scene.object(name).into_iter().flat_map(Object::children);
                waiting.extend(held.rev().map(|(_, child)| (child.target(), false)));
            }
        }
    }

    fn write_block(&mut self, name: &'a str) {
        let Some(entity) = self.scene.get(name) else { return };
        if matches!((entity, self.tables), (Entity::Table(_), Tables::Omitted)) {
            self.named.insert(name);
            return;
        }
        self.text.push('\n');
        match entity {
            Entity::Primitive(primitive) => write_primitive(&mut self.text, name, primitive),
            Entity::Object(object) => {
                self.named.insert(name);
                for (_, child) in object.children() {
                    // A child that contains this object, and whose block follows.
                    if let Some(held) =
                        self.scene.get(child.target()).filter(|_| self.named.insert(child.target()))
                    {
                        line(&mut self.text, &select(child.target(), held));
                    }
                }
                write_object(&mut self.text, self.scene, name, object);
            }
            Entity::Table(table) => write_table(&mut self.text, self.scene, name, table),
        }
        self.named.insert(name);
        self.last = Some(name);
    }
}

/// The command that selects an entity, and creates it if it is new.
pub(crate) fn select(name: &str, entity: &Entity) -> String {
    match entity {
        Entity::Primitive(_) => format!("primitive {name}"),
        Entity::Object(_) | Entity::Table(_) => format!("object {name}"),
    }
}

fn line(text: &mut String, words: &str) {
    text.push_str(words);
    text.push('\n');
}

/// The bits, which distinguish 0 from -0.
fn bits(v: DVec3) -> [u64; 3] {
    v.to_array().map(f64::to_bits)
}

pub(crate) fn write_settings(text: &mut String, scene: &Scene) {
    let default = Scene::default();
    let Camera { position, target, up, fov_deg, .. } = scene.camera;
    let numbers = |camera: &Camera| (bits(camera.position), bits(camera.target), camera.fov_deg.to_bits());
    if scene.sets_camera || numbers(&scene.camera) != numbers(&default.camera) {
        line(text, &format!("camera {} {} {}", vector(position), vector(target), format_number(fov_deg)));
    }
    if bits(up) != bits(scene.up()) {
        line(text, &format!("cameraUp {}", vector(up)));
    }
    if let Some(height) = scene.camera.ortho_height {
        line(text, &format!("orthographic {}", format_number(height)));
    }
    if let Some(lens) = scene.camera.lens {
        line(text, &format!("lens {} {}", format_number(lens.radius), format_number(lens.focus)));
    }
    if bits(scene.background) != bits(default.background) {
        line(text, &format!("background {}", vector(scene.background)));
    }
    if let Some(Sky { horizon, zenith, up }) = scene.sky {
        let mut words = format!("sky {}", vector(horizon));
        if bits(zenith) != bits(horizon) || bits(up) != bits(scene.up()) {
            words += &format!(" {}", vector(zenith));
        }
        if bits(up) != bits(scene.up()) {
            words += &format!(" {}", vector(up));
        }
        line(text, &words);
    }
    match &scene.environment {
        None => {}
        Some(EnvironmentLight::Picture(EnvironmentPicture { file, rotation_deg, scale })) => {
            let [rotation, scale] = [rotation_deg, scale].map(|number| format_number(*number));
            line(text, &format!("environment \"{file}\" {rotation} {scale}"));
        }
        Some(EnvironmentLight::Daylight(Daylight { elevation_deg, turbidity, azimuth_deg })) => {
            let numbers = [elevation_deg, turbidity, azimuth_deg].map(|number| format_number(*number));
            line(text, &format!("daylight {}", numbers.join(" ")));
        }
    }
    if let Some(occlusion) = scene.ambient_occlusion {
        line(text, &format!("ambientOcclusion {} {}", occlusion.samples, format_number(occlusion.distance)));
    }
    if scene.depth != default.depth {
        line(text, &format!("setDepth {}", scene.depth));
    }
    for setting in settings::lines_of_scene(&scene.picture) {
        line(text, &setting);
    }
    for (name, light) in scene.named_lights() {
        write_light(text, name, light);
    }
}

fn write_light(text: &mut String, name: &str, light: &Light) {
    let (color, falloff) = (vector(light.color), format_number(light.falloff));
    let words = match light.kind {
        LightKind::Point { position } => format!("light {name} {} {color} {falloff}", vector(position)),
        LightKind::Spot { position, target, cone_deg, soft } => {
            let (position, target) = (vector(position), vector(target));
            let (degrees, soft) = (format_number(cone_deg), format_number(soft));
            format!("spot {name} {position} {target} {degrees} {color} {falloff} {soft}")
        }
        LightKind::Sun { direction } => format!("sun {name} {} {color}", vector(direction)),
    };
    line(text, &words);
    if light.radius.to_bits() != 0 {
        line(text, &format!("lightRadius {name} {}", format_number(light.radius)));
    }
}

pub(crate) fn write_floor(text: &mut String, floor: &Floor, default_up: DVec3) {
    let Floor { height, up, surface } = floor;
    let height = format_number(*height);
    let has_default_up = bits(*up) == bits(default_up);
    match surface {
        Some(surface) if has_default_up => line(text, &format!("floor {height} {surface}")),
        Some(surface) => line(text, &format!("floor {height} {surface} {}", vector(*up))),
        None => {
            line(text, &format!("floor {height}"));
            if !has_default_up {
                line(text, &format!("floorUp {}", vector(*up)));
            }
        }
    }
}

/// Writes the keys of each of these tracks, with the selection and cursor that they need, and restores the
/// cursors. Returns the selection afterwards.
fn write_keys<'a>(
    text: &mut String,
    scene: &'a Scene,
    mut selected: Option<&'a str>,
    is_written: impl Fn(&Track) -> bool,
) -> Option<&'a str> {
    // The cursors that differ from the scene's at this point: (object, alias).
    let mut moved: Vec<(&str, &str)> = Vec::new();
    let cursor_of = |object: &str| scene.object(object).ok()?.cursor().map(|(alias, _)| alias);
    let mut choose = |text: &mut String, name: &'a str| {
        if let Some(entity) = scene.get(name).filter(|_| selected != Some(name)) {
            line(text, &select(name, entity));
            selected = Some(name);
        }
        selected
    };
    for track in scene.tracks().filter(|track| is_written(track)) {
        let subject = track.subject();
        if let Some(name) = subject.selected.as_deref() {
            choose(text, name);
            if let Some(alias) = subject.cursor.as_deref() {
                let held = moved.iter().position(|(object, _)| *object == name);
                if held.map_or(cursor_of(name), |at| Some(moved[at].1)) != Some(alias) {
                    line(text, &format!("setCursor {alias}"));
                    match held {
                        Some(at) => moved[at].1 = alias,
                        None => moved.push((name, alias)),
                    }
                }
            }
        }
        for key in track.keys() {
            line(text, &format!("key {} {}", format_number(key.frame), line_of(subject, &key.numbers)));
        }
    }
    for (object, alias) in moved {
        if let Some(own) = cursor_of(object).filter(|own| *own != alias) {
            choose(text, object);
            line(text, &format!("setCursor {own}"));
        }
    }
    selected
}

fn write_primitive(text: &mut String, name: &str, primitive: &Primitive) {
    let Primitive { shape, patches, material, textures } = primitive;
    let default = Primitive::default();
    line(text, &format!("primitive {name}"));
    if shape.radii() != default.shape.radii() {
        line(text, &format!("setCoeff {}", vector(shape.radii())));
    }
    if shape.exponents() != default.shape.exponents() {
        let (e, n) = (format_number(shape.exponents().e()), format_number(shape.exponents().n()));
        line(text, &format!("setExponent {e} {n}"));
    }
    if *patches != default.patches {
        line(text, &format!("setPatch {} {}", patches.u, patches.v));
    }
    if bits(material.color) != bits(default.material.color) {
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
        ("setEmission", Some(material.emission), Some(plain.emission)),
        ("setRoughness", material.roughness, plain.roughness),
        ("setMetallic", Some(material.metallic), Some(plain.metallic)),
    ] {
        // Compared by bits: -0 is not the default 0.
        if let Some(value) = value.filter(|value| Some(value.to_bits()) != default.map(f64::to_bits)) {
            line(text, &format!("{word} {}", format_number(value)));
        }
    }
    write_finish(text, material);
    for (channel, texture) in textures.iter().flat_map(|textures| textures.all()) {
        line(text, &format!("setTexture {}", texture_words(channel, texture)));
    }
}

fn write_finish(text: &mut String, material: &Material) {
    if material.fresnel {
        line(text, "setFresnel on");
    }
    if bits(material.absorb) != bits(DVec3::ZERO) {
        line(text, &format!("setAbsorb {}", vector(material.absorb)));
    }
    if material.pattern != Pattern::None {
        line(text, &format!("setPattern {}", pattern_words(&material.pattern)));
    }
}

/// Writes a table as an object: a primitive for each shape, and a child for each row.
fn write_table(text: &mut String, scene: &Scene, name: &str, table: &InstanceTable) {
    // The first prefix that no name of the scene begins with.
    let is_free = |prefix: &String| scene.entities().all(|(held, _)| !held.starts_with(prefix.as_str()));
    let prefix =
        (0..).map(|number| format!("{name}{}s", "_".repeat(number))).find(is_free).unwrap_or_default();
    for (number, shape) in table.shapes().enumerate() {
        let Ok(held) = Superquadric::new(shape.radii, shape.exponents) else { continue };
        let material = table.materials()[shape.material as usize];
        let primitive = Primitive { shape: held, material, ..Primitive::default() };
        write_primitive(text, &format!("{prefix}{number}"), &primitive);
    }
    line(text, &format!("object {name}"));
    let mut used = HashSet::new();
    for row in 0..table.len() {
        let mut alias = table.name(row);
        while !used.insert(alias.clone()) {
            alias.push('_');
        }
        line(text, &format!("addPrimitive {prefix}{} {alias}", table.shape_index(row)));
        let rotation = table.raw_rotation(row);
        if rotation != DQuat::IDENTITY {
            line(text, &format!("orient {}", quaternion_words(rotation)));
        }
        if table.position(row) != DVec3::ZERO {
            line(text, &format!("translate {}", vector(table.position(row))));
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
        let of_alias = if alias == target { String::new() } else { format!(" {alias}") };
        line(text, &format!("{add} {target}{of_alias}"));
        write_steps(text, child.steps(), "");
        if object.is_hidden(alias) {
            line(text, "hide");
        }
    }
    write_steps(text, object.overall_steps(), "All");
    if let Some((alias, _)) = object
        .cursor()
        .filter(|(alias, _)| object.children().next_back().is_some_and(|(last, _)| last != *alias))
    {
        line(text, &format!("setCursor {alias}"));
    }
}

/// Writes transform steps; `suffix` is "All" for those of the whole object.
fn write_steps<'a>(text: &mut String, steps: impl Iterator<Item = &'a TransformStep>, suffix: &str) {
    for step in steps {
        // Writing to a String cannot fail.
        let _ = match step {
            TransformStep::Translate(by) => writeln!(text, "translate{suffix} {}", vector(*by)),
            TransformStep::Rotate { axis, angle_deg } => {
                writeln!(text, "rotate{suffix} {} {}", vector(*axis), format_number(*angle_deg))
            }
            TransformStep::Scale(factors) => writeln!(text, "scale{suffix} {}", vector(*factors)),
            TransformStep::Orient(quaternion) => {
                writeln!(text, "orient{suffix} {}", quaternion_words(*quaternion))
            }
            TransformStep::Affine(map) => writeln!(text, "matrix{suffix} {}", matrix_words(map)),
        };
    }
}
