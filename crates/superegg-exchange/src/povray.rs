//! Scenes for POV-Ray 3.7 and later.
//!
//! Shapes, transforms, camera, lights with their falloff, colours and highlights mean the same there: POV-Ray's superellipsoid has the same exponents, its
//! `specular` is the same half-vector term with `roughness` = 1 / exponent, and its fading light of power 2 is ours times 2. Coordinates stay as they
//! are; the camera's own vectors make the picture come out the right way round. Glass is near, not the same: POV-Ray filters light by the surface's
//! colour where this program takes its root.
//!
//! An object is declared once for each depth that it is opened to. POV-Ray copies what it refers to, so a scene of very many instances is refused.

use std::collections::HashMap;
use std::fmt::Write;

use superegg_geom::Transform;
use superegg_geom::glam::{DAffine3, DVec3};
use superegg_scene::{Camera, Entity, Light, Material, Object, Primitive, Scene};
use thiserror::Error;

/// POV-Ray holds every instance in memory, some kilobytes each.
pub const MOST_INSTANCES: u64 = 2_000_000;

/// Why a scene cannot be written.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
pub enum PovError {
    /// Nothing has this name.
    #[error("nothing is named '{0}'")]
    Unknown(String),
    /// Too many copies.
    #[error(
        "opened {depth} levels deep the picture has more than {MOST_INSTANCES} instances, and POV-Ray makes a copy for each; take fewer levels (--depth)"
    )]
    TooMany {
        /// The depth that was asked for.
        depth: u32,
    },
}

/// The scene below `root`, opened `depth` levels deep, in POV-Ray's language.
///
/// # Errors
/// A name that the scene does not have, or too many instances.
pub fn to_povray(scene: &Scene, root: &str, depth: u32) -> Result<String, PovError> {
    let mut writer = Writer { scene, text: String::new(), declared: HashMap::new() };
    writer.head();
    let (name, count) = writer.declare(root, depth)?;
    if count > MOST_INSTANCES {
        return Err(PovError::TooMany { depth });
    }
    if let Some(name) = name {
        let _ = writeln!(writer.text, "object {{ {name} }}");
    }
    Ok(writer.text)
}

struct Writer<'a> {
    scene: &'a Scene,
    text: String,
    /// The identifier of (name, remaining depth), `None` where it comes to nothing, and its instances.
    declared: HashMap<(&'a str, u32), (Option<String>, u64)>,
}

impl<'a> Writer<'a> {
    fn head(&mut self) {
        let background = vector(self.scene.background);
        let _ = write!(
            self.text,
            "// Written by superegg. Render with the picture's own size, for example:\n\
             //   povray +W1280 +H960 FILE.pov\n\
             #version 3.7;\n\
             global_settings {{ assumed_gamma 1.0 max_trace_level 17 ambient_light rgb 1 }}\n\
             background {{ color rgb {background} }}\n"
        );
        self.camera(&self.scene.camera);
        self.scene.lights().iter().for_each(|light| self.light(light));
        self.text.push('\n');
    }

    fn camera(&mut self, camera: &Camera) {
        let (right, up, forward) = camera.frame();
        let height = 2.0 * (0.5 * camera.fov_deg.to_radians()).tan();
        let [position, right, up, forward] =
            [camera.position, right * height, up * height, forward].map(vector);
        let _ = writeln!(
            self.text,
            "camera {{ perspective location {position} direction {forward} up {up}\n  right {right} * (image_width / image_height) }}"
        );
    }

    fn light(&mut self, light: &Light) {
        let position = vector(light.position().unwrap_or_default());
        let _ = if light.falloff > 0.0 {
            let distance = light.falloff.sqrt().recip();
            let color = vector(0.5 * light.color);
            writeln!(
                self.text,
                "light_source {{ {position} color rgb {color} fade_distance {distance} fade_power 2 }}"
            )
        } else {
            writeln!(self.text, "light_source {{ {position} color rgb {} }}", vector(light.color))
        };
    }

    /// Declares what a name stands for when objects may be opened `remaining` levels deep.
    fn declare(&mut self, name: &str, remaining: u32) -> Result<(Option<String>, u64), PovError> {
        let entry = self.scene.entities().find(|(other, _)| *other == name);
        let Some((name, entity)) = entry else { return Err(PovError::Unknown(name.to_owned())) };
        self.declare_entity(name, entity, remaining)
    }

    fn declare_entity(
        &mut self,
        name: &'a str,
        entity: &'a Entity,
        remaining: u32,
    ) -> Result<(Option<String>, u64), PovError> {
        let key = (name, if matches!(entity, Entity::Primitive(_)) { 0 } else { remaining });
        if let Some(known) = self.declared.get(&key) {
            return Ok(known.clone());
        }
        let identifier = format!("{}_{}", identifier(name), self.declared.len());
        let answer = match entity {
            Entity::Primitive(primitive) => {
                self.primitive(&identifier, primitive);
                (Some(identifier), 1)
            }
            Entity::Object(_) if remaining == 0 => (None, 0),
            Entity::Object(object) => {
                // Known before it is asked for again: levels only go down, so it is not asked for within itself.
                self.object(identifier, object, remaining)?
            }
        };
        self.declared.insert(key, answer.clone());
        Ok(answer)
    }

    fn primitive(&mut self, identifier: &str, primitive: &Primitive) {
        let exponents = primitive.shape.exponents();
        let shape = if (exponents.e, exponents.n) == (1.0, 1.0) {
            "sphere { 0, 1".to_owned()
        } else {
            format!("superellipsoid {{ <{}, {}>", exponents.e, exponents.n)
        };
        let radii = vector(primitive.shape.radii());
        let look = look(&primitive.material);
        let _ = writeln!(self.text, "#declare {identifier} = {shape} scale {radii}\n  {look} }}");
    }

    fn object(
        &mut self,
        identifier: String,
        object: &'a Object,
        remaining: u32,
    ) -> Result<(Option<String>, u64), PovError> {
        let mut body = String::new();
        let mut children = 0;
        let mut count: u64 = 0;
        for (_, child) in object.children() {
            let entity = self.scene.get(child.target());
            let (Some(entity), Ok(map)) = (entity, object.parent_from_child(child)) else { continue };
            let (target, below) = match self.declared_name(child.target()) {
                Some(name) => self.declare_entity(name, entity, remaining - 1)?,
                None => continue,
            };
            let Some(target) = target else { continue };
            count = count.saturating_add(below);
            children += 1;
            let _ = writeln!(body, "  object {{ {target} {} }}", matrix(&map));
        }
        if count > MOST_INSTANCES {
            return Err(PovError::TooMany { depth: remaining });
        }
        if children == 0 {
            return Ok((None, 0));
        }
        // A union of one is a warning there.
        let body = if children == 1 {
            format!("#declare {identifier} =\n{body}")
        } else {
            format!("#declare {identifier} = union {{\n{body}}}\n")
        };
        self.text.push_str(&body);
        Ok((Some(identifier), count))
    }

    /// The scene's own copy of a name.
    fn declared_name(&self, name: &'a str) -> Option<&'a str> {
        self.scene.get(name).map(|_| name)
    }
}

/// A name as POV-Ray takes it: letters, digits and underscores, begun with a capital so that it is no keyword.
fn identifier(name: &str) -> String {
    let plain: String =
        name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).take(24).collect();
    format!("S_{plain}")
}

fn vector(v: DVec3) -> String {
    format!("<{}, {}, {}>", v.x, v.y, v.z)
}

/// The images of the axes, and that of the origin.
fn matrix(map: &Transform) -> String {
    if *map == Transform::IDENTITY {
        return String::new();
    }
    let DAffine3 { matrix3: m, translation } = *map.forward();
    let rows = [m.x_axis, m.y_axis, m.z_axis, translation].map(|v| format!("{},{},{}", v.x, v.y, v.z));
    format!("matrix <{}>", rows.join(", "))
}

fn look(material: &Material) -> String {
    let mirror = material.reflected.unwrap_or(0.0);
    let through = material.refracted.unwrap_or(0.0);
    let total = (mirror + through).max(1.0);
    let (mirror, through) = (mirror / total, through / total);
    let local = (1.0 - mirror - through).max(0.0);
    // The colour's own part is lessened by what is let through there as well.
    let own = if through < 1.0 { local / (1.0 - through) } else { 0.0 };
    let color = material.color;
    let roughness = material.highlight_exponent().max(1e-4).recip();
    let mut text = format!(
        "pigment {{ rgb {} {} }} finish {{ ambient {} diffuse {} specular {} roughness {roughness}",
        vector(color),
        if through > 0.0 { format!("filter {through}") } else { String::new() },
        material.ambient * own,
        material.diffuse * own,
        material.specular
    );
    if through > 0.0 {
        let _ = write!(text, " reflection {{ {mirror}, 1 fresnel on }} conserve_energy }}");
        let _ = write!(text, " interior {{ ior {} }}", material.index);
    } else {
        if mirror > 0.0 {
            let _ = write!(text, " reflection {mirror}");
        }
        text.push_str(" }");
    }
    text
}

#[cfg(test)]
mod tests {
    use superegg_geom::TransformStep;

    use super::*;

    fn scene() -> Scene {
        let mut scene = Scene::default();
        scene.ensure_primitive("sphere").unwrap();
        scene.ensure_object("my tree").unwrap();
        scene.add_child("my tree", "a", "sphere").unwrap();
        scene.add_child("my tree", "b", "my tree").unwrap();
        scene.transform_child("my tree", TransformStep::Translate(DVec3::new(0.0, 0.0, 2.5))).unwrap();
        scene
    }

    #[test]
    fn levels_are_declared_before_they_are_used() {
        let text = to_povray(&scene(), "my tree", 3).unwrap();
        let place = |what: &str| text.find(what).unwrap_or_else(|| panic!("no {what} in\n{text}"));
        assert_eq!(text.matches("#declare").count(), 4);
        assert!(place("matrix <1,0,0, 0,1,0, 0,0,1, 0,0,2.5>") < place("\nobject { S_my_tree"));
        assert!(text.matches('{').count() == text.matches('}').count());
        for line in text.lines().filter(|line| line.starts_with("#declare")) {
            let identifier = line.split_whitespace().nth(1).unwrap();
            assert!(
                place(&format!("#declare {identifier}")) < text.rfind(&format!("{{ {identifier} ")).unwrap()
            );
        }
    }

    #[test]
    fn what_cannot_be_written_says_why() {
        let mut scene = scene();
        assert_eq!(to_povray(&scene, "nobody", 3), Err(PovError::Unknown("nobody".to_owned())));
        scene.add_child("my tree", "c", "my tree").unwrap();
        assert!(matches!(to_povray(&scene, "my tree", 64), Err(PovError::TooMany { .. })));
        assert!(!to_povray(&scene, "my tree", 0).unwrap().contains("\nobject"));
        assert!(to_povray(&scene, "sphere", 0).unwrap().contains("sphere { 0, 1"));
    }
}
