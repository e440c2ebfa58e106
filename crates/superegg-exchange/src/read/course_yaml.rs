//! Scenes of the course program's YAML edition (2020 on).
//!
//! - `exp0` is e, `exp1` is n. Transforms act in the order written, those of an assembly after
//!   those of its children.
//! - The camera is the view of OpenGL: the world is turned by `rotate`, then moved by `translate`.
//!   `fov` is vertical, in degrees; near and far planes are left out.
//! - A light's attenuation k is that of `1 / (1 + k d^2)`; with a fourth coordinate of 0 it is
//!   directional.
//! - A material has three colours, ours one with weights: the diffuse colour is kept, the weights
//!   of the others come from their best fit to it.

use std::collections::HashMap;

use superegg_geom::TransformStep;
use superegg_geom::glam::{DQuat, DVec3};
use superegg_geom::unit_vector;

use super::error::ReadError;
use super::format::Format;
use super::import::{Content, Import};
use super::options::ReadOptions;
use super::script::{Names, Script, color_and_weight};
use super::yaml::{self, Node};

/// The height of the program's picture, in pixels.
const PICTURE_HEIGHT: f64 = 500.0;
/// Colours that differ by no more than this are the same but for their brightness.
const COLOR_TOLERANCE: f64 = 1e-6;
/// The most warnings of a file.
const MOST_WARNINGS: usize = 50;

/// The format, if these first bytes are of such a scene.
pub(crate) fn recognize(head: &[u8]) -> Result<Option<Format>, ReadError> {
    let text = String::from_utf8_lossy(head);
    let text = text.strip_prefix('\u{feff}').unwrap_or(&text);
    let has = |key: &str| {
        text.lines().any(|line| {
            line.strip_prefix(key)
                .and_then(|rest| rest.trim_start().strip_prefix(':'))
                .is_some_and(|rest| rest.is_empty() || rest.starts_with([' ', '\t', '\r']))
        })
    };
    let keys = ["camera", "lights", "objects"].into_iter().filter(|key| has(key)).count();
    Ok((keys >= 2).then_some(Format::CourseYaml))
}

/// Reads a scene as lines of the modelling language.
///
/// # Errors
/// The text is no YAML, or a value is missing or wrong; the error names the line.
pub(crate) fn read(bytes: &[u8], _options: &ReadOptions) -> Result<Import, ReadError> {
    let text = std::str::from_utf8(bytes).map_err(|_| ReadError::File("the file is not text".to_owned()))?;
    let root = yaml::parse(text.strip_prefix('\u{feff}').unwrap_or(text))?;
    let mut writer = Writer::default();
    writer.unknown_keys(&root, &["camera", "lights", "objects"])?;
    if let Some(camera) = root.get("camera") {
        writer.camera(camera)?;
    }
    writer.lights(root.get("lights"))?;
    writer.objects(root.needed("objects")?)?;
    let Writer { script, mut warnings, .. } = writer;
    if warnings.len() > MOST_WARNINGS {
        let more = warnings.len() - MOST_WARNINGS;
        warnings.truncate(MOST_WARNINGS);
        warnings.push(format!("{more} more warnings"));
    }
    let reading = "exp0 = e, exp1 = n, transforms in the order written, \
                   the camera as a view of the world, colours as their diffuse part";
    Ok(Import { warnings, ..Import::new(Content::Script(script.into_text()), reading) })
}

/// An object of the file.
struct Object<'a> {
    /// Its name in the script.
    name: String,
    steps: Vec<TransformStep>,
    kind: Kind<'a>,
    is_root: bool,
}

enum Kind<'a> {
    Superquadric {
        exponents: [f64; 2],
        material: Option<&'a Node>,
    },
    /// The names of the children, with their nodes.
    Assembly(Vec<(&'a str, &'a Node)>),
}

#[derive(Default)]
struct Writer {
    script: Script,
    warnings: Vec<String>,
}

impl Writer {
    fn warn(&mut self, node: &Node, message: &str) {
        self.warnings.push(format!("line {}: {message}", node.line));
    }

    fn unknown_keys(&mut self, node: &Node, known: &[&str]) -> Result<(), ReadError> {
        for (key, value) in node.entries()? {
            if !known.contains(&key.as_str()) {
                let shown: String = key.chars().take(40).collect();
                self.warn(value, &format!("the key '{shown}' is not known and left out"));
            }
        }
        Ok(())
    }

    fn camera(&mut self, node: &Node) -> Result<(), ReadError> {
        self.unknown_keys(node, &["translate", "rotate", "frustum"])?;
        let delta = match node.get("translate") {
            Some(translate) => DVec3::from_array(translate.needed("delta")?.numbers()?),
            None => DVec3::ZERO,
        };
        let turn = match node.get("rotate") {
            Some(rotate) => match rotation(rotate)? {
                Some((axis, angle_deg)) => DQuat::from_axis_angle(axis, angle_deg.to_radians()),
                None => DQuat::IDENTITY,
            },
            None => DQuat::IDENTITY,
        };
        // The view is p -> turn p + delta.
        let back = turn.inverse();
        let position = back * -delta;
        let forward = back * DVec3::NEG_Z;
        // The target lies at the distance of the world's origin, if it is in front.
        let ahead = forward.dot(-position);
        let distance = if ahead > 0.0 { ahead } else { 1.0 };
        let mut numbers = [position, position + distance * forward].map(|v| v.to_array()).concat();
        if let Some(frustum) = node.get("frustum") {
            self.unknown_keys(frustum, &["aspect_ratio", "fov", "near", "far"])?;
            if let Some(fov) = frustum.get("fov") {
                numbers.push(within(fov, 0.0, 180.0)?);
            }
            if let Some(aspect) = frustum.get("aspect_ratio") {
                let aspect = within(aspect, 0.01, 100.0)?;
                let width = (aspect * PICTURE_HEIGHT).round();
                self.script.line(&["set", "size", &format!("{width}x{PICTURE_HEIGHT}")]);
            }
        }
        self.script.numbers("camera", "", &numbers);
        self.script.numbers("cameraUp", "", &(back * DVec3::Y).to_array());
        Ok(())
    }

    fn lights(&mut self, node: Option<&Node>) -> Result<(), ReadError> {
        let lights = node.map_or(Ok(&[][..]), Node::items)?;
        if lights.is_empty() {
            self.warnings.push("the scene has no lights: the default light shines".to_owned());
        }
        for (index, light) in lights.iter().enumerate() {
            self.unknown_keys(light, &["position", "color", "attenuation"])?;
            let [x, y, z, w] = light.needed("position")?.numbers()?;
            let mut color = DVec3::ONE;
            if let Some(node) = light.get("color") {
                color = self.channels(node, f64::INFINITY)?;
            }
            let attenuation = match light.get("attenuation") {
                Some(node) => {
                    let k = node.number()?;
                    if k < 0.0 {
                        return Err(node.error(format!("an attenuation must not be below 0, found {k}")));
                    }
                    k
                }
                None => 0.0,
            };
            let name = self.script.new_name(&format!("light{}", index + 1));
            let position = DVec3::new(x, y, z);
            if w == 0.0 {
                if unit_vector(position).is_none() {
                    return Err(light.error("a directional light needs a direction"));
                }
                self.script.numbers("sun", &name, &[position, color].map(|v| v.to_array()).concat());
            } else {
                let mut numbers = [position / w, color].map(|v| v.to_array()).concat();
                numbers.push(attenuation);
                self.script.numbers("light", &name, &numbers);
            }
        }
        Ok(())
    }

    fn objects(&mut self, node: &Node) -> Result<(), ReadError> {
        let items = node.items()?;
        let mut objects = Vec::with_capacity(items.len());
        let mut by_name: HashMap<&str, usize> = HashMap::new();
        for item in items {
            let name = item.needed("name")?.text()?;
            if by_name.insert(name, objects.len()).is_some() {
                let shown: String = name.chars().take(40).collect();
                return Err(item.error(format!("an object is named '{shown}' already")));
            }
            objects.push(self.object(item, name)?);
        }
        for object in &objects {
            if let Kind::Superquadric { exponents, material } = object.kind {
                self.primitive(&object.name, exponents, material)?;
            }
        }
        // Objects exist before the blocks that name them.
        let assemblies = objects.iter().filter(|object| matches!(object.kind, Kind::Assembly(_)));
        self.script.gap();
        for assembly in assemblies.clone() {
            self.script.line(&["object", &assembly.name]);
        }
        for assembly in assemblies {
            let Kind::Assembly(children) = &assembly.kind else { continue };
            let mut members = Vec::with_capacity(children.len());
            for (name, node) in children {
                let Some(&index) = by_name.get(name) else {
                    let shown: String = name.chars().take(40).collect();
                    return Err(node.error(format!("no object is named '{shown}'")));
                };
                members.push(&objects[index]);
            }
            self.block(&assembly.name, &members);
            self.script.steps(&assembly.steps, "All");
        }
        self.roots(&objects, node);
        self.depth(&objects, &by_name);
        Ok(())
    }

    fn object<'a>(&mut self, item: &'a Node, name: &str) -> Result<Object<'a>, ReadError> {
        let kind_node = item.needed("type")?;
        let kind = match kind_node.text()? {
            "superquadric" => {
                self.unknown_keys(item, &["name", "type", "root", "exp0", "exp1", "material", "transforms"])?;
                let exponent = |key: &str| {
                    let node = item.needed(key)?;
                    let value = node.number()?;
                    if value < 0.0 {
                        return Err(node.error(format!("an exponent must not be below 0, found {value}")));
                    }
                    Ok(value)
                };
                Kind::Superquadric {
                    exponents: [exponent("exp0")?, exponent("exp1")?],
                    material: item.get("material"),
                }
            }
            "assembly" => {
                self.unknown_keys(item, &["name", "type", "root", "children", "transforms"])?;
                let children = item.needed("children")?.items()?.iter();
                Kind::Assembly(
                    children.map(|child| Ok((child.text()?, child))).collect::<Result<_, ReadError>>()?,
                )
            }
            other => {
                let shown: String = other.chars().take(40).collect();
                let message = format!("expected 'superquadric' or 'assembly', found '{shown}'");
                return Err(kind_node.error(message));
            }
        };
        let mut steps = Vec::new();
        for transform in item.get("transforms").map_or(Ok(&[][..]), Node::items)? {
            steps.extend(self.step(transform)?);
        }
        let is_root = item.get("root").map_or(Ok(false), truth)?;
        Ok(Object { name: self.script.new_name(name), steps, kind, is_root })
    }

    fn step(&mut self, node: &Node) -> Result<Option<TransformStep>, ReadError> {
        let kind = node.needed("type")?;
        Ok(match kind.text()? {
            "translate" => {
                self.unknown_keys(node, &["type", "delta"])?;
                Some(TransformStep::Translate(DVec3::from_array(node.needed("delta")?.numbers()?)))
            }
            "scale" => {
                self.unknown_keys(node, &["type", "scale"])?;
                let scale = node.needed("scale")?;
                let factors = DVec3::from_array(scale.numbers()?);
                if factors.to_array().contains(&0.0) {
                    return Err(scale.error("a scale of 0 flattens the shape"));
                }
                Some(TransformStep::Scale(factors))
            }
            "rotate" => {
                self.unknown_keys(node, &["type", "axis", "angle"])?;
                let axis = DVec3::from_array(node.needed("axis")?.numbers()?);
                // The axis keeps its digits; only its direction counts.
                rotation(node)?.map(|(_, angle_deg)| TransformStep::Rotate { axis, angle_deg })
            }
            other => {
                let shown: String = other.chars().take(40).collect();
                let message = format!("expected 'translate', 'scale' or 'rotate', found '{shown}'");
                return Err(kind.error(message));
            }
        })
    }

    fn primitive(
        &mut self,
        name: &str,
        exponents: [f64; 2],
        material: Option<&Node>,
    ) -> Result<(), ReadError> {
        self.script.gap();
        self.script.line(&["primitive", name]);
        self.script.numbers("setExponent", "", &exponents);
        let Some(material) = material else { return Ok(()) };
        self.unknown_keys(material, &["ambient", "diffuse", "specular", "shininess"])?;
        let mut color_of = |key: &str| match material.get(key) {
            Some(node) => self.channels(node, 1.0),
            None => Ok(DVec3::ZERO),
        };
        let (ambient, diffuse, specular) =
            (color_of("ambient")?, color_of("diffuse")?, color_of("specular")?);
        // A black diffuse part leaves the colour to the ambient one.
        let base = if diffuse == DVec3::ZERO { ambient } else { diffuse };
        let (color, _) = color_and_weight(base);
        let diffuse_weight = diffuse.max_element();
        let ambient_weight = self.weight_along(material, "ambient", ambient, color);
        let specular_weight = self.weight_along(material, "specular", specular, DVec3::ONE);
        self.script.numbers("setColor", "", &color.to_array());
        self.script.numbers("setAmbient", "", &[ambient_weight]);
        self.script.numbers("setDiffuse", "", &[diffuse_weight]);
        self.script.numbers("setSpecular", "", &[specular_weight]);
        if let Some(node) = material.get("shininess") {
            let shininess = node.number()?;
            if shininess < 0.0 {
                return Err(node.error(format!("a shininess must not be below 0, found {shininess}")));
            }
            self.script.numbers("setShininess", "", &[shininess]);
        }
        Ok(())
    }

    /// The weight w in [0, 1] with the least distance of `w * color` from a part of a material.
    fn weight_along(&mut self, material: &Node, key: &str, part: DVec3, color: DVec3) -> f64 {
        let weight = part.dot(color) / color.dot(color);
        if (part - weight * color).abs().max_element() > COLOR_TOLERANCE {
            let node = material.get(key).unwrap_or(material);
            self.warn(node, &format!("the colour of '{key}' is not kept, only its brightness"));
        }
        weight.clamp(0.0, 1.0)
    }

    /// The channels of a colour, clamped to `most`.
    fn channels(&mut self, node: &Node, most: f64) -> Result<DVec3, ReadError> {
        let color = DVec3::from_array(node.numbers()?);
        let clamped = color.clamp(DVec3::ZERO, DVec3::splat(most));
        if clamped != color {
            self.warn(node, "a colour channel out of range is clamped");
        }
        Ok(clamped)
    }

    /// Adds children to an object, each under an alias of its own.
    fn block(&mut self, name: &str, members: &[&Object<'_>]) {
        self.script.gap();
        self.script.line(&["object", name]);
        let mut aliases = Names::default();
        for member in members {
            let alias = aliases.add(&member.name);
            match member.kind {
                Kind::Superquadric { .. } => {
                    self.script.line(&["addPrimitive", &member.name, &alias]);
                    self.script.steps(&member.steps, "");
                }
                Kind::Assembly(_) => self.script.line(&["addObject", &member.name, &alias]),
            }
        }
    }

    /// Selects what the scene shows: the only root if it is an assembly, else an object of all.
    fn roots(&mut self, objects: &[Object<'_>], node: &Node) {
        let roots: Vec<&Object<'_>> = objects.iter().filter(|object| object.is_root).collect();
        if roots.is_empty() {
            self.warn(node, "no object is a root: the picture is empty");
        }
        if let [Object { name, kind: Kind::Assembly(_), .. }] = roots[..] {
            self.script.gap();
            self.script.line(&["object", name]);
            return;
        }
        let name = self.script.new_name("scene");
        self.block(&name, &roots);
    }

    /// Sets the recursion depth that the deepest nesting needs. Assemblies in circles end at the
    /// default depth.
    fn depth(&mut self, objects: &[Object<'_>], by_name: &HashMap<&str, usize>) {
        let children = |index: usize| {
            let names = match &objects[index].kind {
                Kind::Assembly(names) => names.as_slice(),
                Kind::Superquadric { .. } => &[],
            };
            names.iter().filter_map(|(name, _)| by_name.get(name).copied())
        };
        let mut waiting_for: Vec<usize> = vec![0; objects.len()];
        (0..objects.len()).flat_map(children).for_each(|child| waiting_for[child] += 1);
        let mut ready: Vec<usize> = (0..objects.len()).filter(|&index| waiting_for[index] == 0).collect();
        // The object of all roots is the first level.
        let mut level = vec![2_usize; objects.len()];
        let mut deepest = 0;
        while let Some(index) = ready.pop() {
            deepest = deepest.max(level[index]);
            for child in children(index) {
                level[child] = level[child].max(level[index] + 1);
                waiting_for[child] -= 1;
                if waiting_for[child] == 0 {
                    ready.push(child);
                }
            }
        }
        self.script.depth(deepest);
    }
}

/// The axis, of unit length, and angle of a rotation; `None` if the angle is 0.
fn rotation(node: &Node) -> Result<Option<(DVec3, f64)>, ReadError> {
    let angle_deg = node.needed("angle")?.number()?;
    let axis = node.needed("axis")?;
    match unit_vector(DVec3::from_array(axis.numbers()?)) {
        Some(unit) => Ok((angle_deg != 0.0).then_some((unit, angle_deg))),
        None if angle_deg == 0.0 => Ok(None),
        None => Err(axis.error("the rotation axis 0 0 0 has no direction")),
    }
}

/// A number between two bounds, which are excluded.
fn within(node: &Node, above: f64, below: f64) -> Result<f64, ReadError> {
    let value = node.number()?;
    if value > above && value < below {
        return Ok(value);
    }
    Err(node.error(format!("expected a number between {above} and {below}, found {value}")))
}

fn truth(node: &Node) -> Result<bool, ReadError> {
    match node.text()?.to_ascii_lowercase().as_str() {
        "true" | "yes" | "y" | "on" => Ok(true),
        "false" | "no" | "n" | "off" => Ok(false),
        _ => Err(node.error("expected true or false")),
    }
}

#[cfg(test)]
mod tests {
    use superegg_geom::glam::DMat4;
    use superegg_lang::{Session, load_text};

    use super::*;

    const SCENE: &str = "\
camera:
  translate: { delta: [ 1, -2, -5 ] }
  rotate: { axis: [0, 2, 0 ], angle: 30 }
  frustum: { aspect_ratio: 1.5, fov: 40.0, near: 0.2, far: 20 }
lights:
- { position: [ -2, 2, 2, 2 ], color: [ 1, 1, 0.5 ], attenuation: 0.1 }
- { position: [ 2, 0, 2, 0 ], color: [ 0, 0, 3 ], attenuation: 0 }
objects:
- name: all of it
  type: assembly
  root: true
  children: [ part, box, part ]
  transforms:
  - { type: translate, delta: [1, 2, 3] }
  - { type: rotate, axis: [0, 0, 1], angle: 90 }
- { name: part, type: assembly, root: false, children: [box], transforms: [ { type: scale, scale: [2, 3, 4] } ] }
- name: box
  type: superquadric
  root: false
  exp0: 0.1
  exp1: 1.5
  material:
    ambient: [ 0.05, 0.1, 0.0 ]
    diffuse: [ 0.4, 0.8, 0.0 ]
    specular: [ 0.5, 0.5, 0.5 ]
    shininess: 15
  transforms:
  - { type: scale, scale: [ 0.8, 0.7, 0.6 ] }
  - { type: rotate, axis: [ 1.0, 1.0, 0.0 ], angle: 20.0 }
";

    fn import(text: &str) -> Import {
        assert_eq!(recognize(text.as_bytes()).unwrap(), Some(Format::CourseYaml));
        read(text.as_bytes(), &ReadOptions::default()).unwrap()
    }

    fn session(import: &Import) -> Session {
        let Content::Script(script) = &import.content else { panic!("no script") };
        let (session, diagnostics) = load_text("scene", script);
        assert!(diagnostics.is_empty(), "{diagnostics:?} in\n{script}");
        session
    }

    fn message(text: &str) -> String {
        read(text.as_bytes(), &ReadOptions::default()).unwrap_err().to_string()
    }

    #[test]
    fn a_scene_is_a_script_without_errors() {
        let import = import(SCENE);
        assert!(import.warnings.is_empty(), "{:?}", import.warnings);
        let session = session(&import);
        assert_eq!(session.selected(), Some("all_of_it"));
        let scene = session.scene();
        let children = |name: &str| -> Vec<String> {
            scene.object(name).unwrap().children().map(|(alias, _)| alias.to_owned()).collect()
        };
        assert_eq!(children("all_of_it"), ["part", "box", "part_2"]);
        let all = scene.object("all_of_it").unwrap();
        let (_, child) = all.children().nth(1).unwrap();
        let map = *all.parent_from_child(child).unwrap().forward();
        // By matrices: the whole after the child.
        let axis = DVec3::new(1.0, 1.0, 0.0).normalize();
        let expected = DMat4::from_axis_angle(DVec3::Z, 90_f64.to_radians())
            * DMat4::from_translation(DVec3::new(1.0, 2.0, 3.0))
            * DMat4::from_axis_angle(axis, 20_f64.to_radians())
            * DMat4::from_scale(DVec3::new(0.8, 0.7, 0.6));
        for point in [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z] {
            assert!((map.transform_point3(point) - expected.transform_point3(point)).length() < 1e-14);
        }
        let cube = scene.primitive("box").unwrap();
        assert_eq!((cube.shape.exponents().e(), cube.shape.exponents().n()), (0.1, 1.5));
        let material = &cube.material;
        assert_eq!(material.color, DVec3::new(0.5, 1.0, 0.0));
        assert!((material.ambient - 0.1).abs() < 1e-15 && material.diffuse == 0.8);
        assert_eq!((material.specular, material.shininess), (0.5, Some(15.0)));
        assert_eq!((scene.picture.width, scene.picture.height), (750, 500));
        assert_eq!(scene.lights().len(), 2);
        assert_eq!(scene.lights()[0].position(), Some(DVec3::new(-1.0, 1.0, 1.0)));
    }

    #[test]
    fn the_camera_is_the_view_of_opengl() {
        let camera = session(&import(SCENE)).scene().camera;
        let view = DMat4::from_translation(DVec3::new(1.0, -2.0, -5.0))
            * DMat4::from_axis_angle(DVec3::Y, 30_f64.to_radians());
        let (right, up, forward) = camera.frame();
        let seen = |world: DVec3| view.transform_point3(camera.position + world);
        for (world, eye) in
            [(DVec3::ZERO, DVec3::ZERO), (right, DVec3::X), (up, DVec3::Y), (forward, DVec3::NEG_Z)]
        {
            assert!((seen(world) - eye).length() < 1e-14, "{world}");
        }
        assert_eq!(camera.fov_deg, 40.0);
    }

    #[test]
    fn deep_nesting_sets_the_depth() {
        let mut text = "camera: {}\nobjects:\n- {name: b, type: superquadric, exp0: 1, exp1: 1}\n".to_owned();
        text += "- {name: a0, type: assembly, children: [b]}\n";
        for level in 1..30 {
            let root = level == 29;
            text +=
                &format!("- {{name: a{level}, type: assembly, root: {root}, children: [a{}]}}\n", level - 1);
        }
        let import = import(&text);
        assert_eq!(import.warnings, ["the scene has no lights: the default light shines"]);
        assert!(session(&import).scene().depth >= 31);
    }

    #[test]
    fn an_exponent_of_0_is_the_limit() {
        let session = session(&import(&SCENE.replace("exp0: 0.1", "exp0: 0")));
        let zero = |primitive: &superegg_scene::Primitive| primitive.shape.exponents().e() == 0.0;
        assert_eq!(session.scene().primitives().filter(|(_, primitive)| zero(primitive)).count(), 1);
    }

    #[test]
    fn wrong_values_are_named_by_their_line() {
        let with = |from: &str, to: &str| message(&SCENE.replace(from, to));
        assert_eq!(with("exp0: 0.1", "exp0: zero"), "line 20: expected a number, found 'zero'");
        assert_eq!(with("exp0: 0.1", "exp0: -1"), "line 20: an exponent must not be below 0, found -1");
        assert_eq!(with("  exp1: 1.5\n", ""), "line 17: expected the key 'exp1'");
        assert_eq!(with("scale: [2, 3, 4]", "scale: [2, 3]"), "line 16: expected 3 numbers, found 2");
        assert_eq!(with("children: [box]", "children: [bax]"), "line 16: no object is named 'bax'");
        assert_eq!(with("name: part", "name: box"), "line 17: an object is named 'box' already");
        assert!(with("type: superquadric", "type: mesh").contains("found 'mesh'"));
        assert!(with("fov: 40.0", "fov: 180").contains("between 0 and 180"));
        assert!(with("angle: 90", "angle: .nan").contains("expected a number"));
        assert!(with("axis: [0, 0, 1], angle: 90", "axis: [0, 0, 0], angle: 90").contains("no direction"));
        assert!(message("camera: {}\nlights: []\n").contains("expected the key 'objects'"));
    }

    #[test]
    fn what_is_not_kept_is_a_warning() {
        let warnings = |from: &str, to: &str| import(&SCENE.replace(from, to)).warnings.join("\n");
        assert!(
            warnings("ambient: [ 0.05, 0.1, 0.0 ]", "ambient: [ 0, 0, 0.1 ]")
                .contains("line 23: the colour of 'ambient'")
        );
        assert!(warnings("diffuse: [ 0.4, 0.8, 0.0 ]", "diffuse: [ 0.4, 1.8, -1 ]").contains("clamped"));
        assert!(warnings("shininess: 15", "shine: 15").contains("the key 'shine' is not known"));
        assert!(warnings("root: true", "root: off").contains("no object is a root"));
        assert_eq!(recognize(b"camera 0 0 10 0 0 0\nobject lights\n").unwrap(), None);
        assert_eq!(recognize(b"{\"camera\": 1}").unwrap(), None);
    }

    #[allow(clippy::print_stderr, reason = "a test that is skipped says so")]
    #[test]
    fn real_scenes_load_without_errors() {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/scenes");
        for (file, root, instances) in [("sphere.yaml", "scene", 1), ("sphere_cube.yaml", "assembly", 2)] {
            let Ok(text) = std::fs::read_to_string(format!("{folder}/{file}")) else {
                eprintln!("skipped: {folder}/{file} is missing");
                continue;
            };
            let import = import(&text);
            assert!(import.warnings.is_empty(), "{:?}", import.warnings);
            let session = session(&import);
            assert_eq!(session.selected(), Some(root));
            assert_eq!(session.scene().object(root).unwrap().children().len(), instances);
            assert_eq!(session.scene().camera.position, DVec3::new(0.0, 0.0, 5.0));
            assert_eq!(session.scene().camera.target, DVec3::ZERO);
        }
    }
}
