//! Export to POV-Ray 3.7 and later.
//!
//! - Exact: shapes and transforms (POV-Ray's superellipsoid has the same exponents), perspective
//!   and orthographic cameras, point and directional lights without a radius, attenuation
//!   (POV-Ray's `fade_power 2` is this program's, times 2), colours, highlights (`specular` is the
//!   same half-vector term, with `roughness` = 1 / exponent), absorption, checkers, gradients,
//!   floor, sky. Coordinates are unchanged, but for scenes of small shapes ([`enlargement`]); the
//!   camera's own vectors correct the handedness.
//! - Approximate: glass (POV-Ray filters light by the colour of the surface, this program by its
//!   square root), the rim of a spot light (POV-Ray fades it in the cosine, this program in the
//!   angle), soft shadows (a disc that faces the target instead of a sphere), Fresnel reflection
//!   (it reduces the local colour by its value at normal incidence), depth of field (POV-Ray
//!   samples a polygonal aperture).
//! - Missing: ambient occlusion, glossy reflection, reconstruction filters, exposure and tone
//!   mapping.
//!
//! An object is declared once for each recursion depth. POV-Ray copies declared objects, so scenes
//! with very many instances are rejected.

use std::collections::HashMap;
use std::fmt::Write;

use superegg_geom::glam::{DAffine3, DMat3, DVec3};
use superegg_geom::unit_vector;
use superegg_geom::{Superquadric, Transform};
use superegg_scene::{
    Camera, Entity, Floor, InstanceTable, Light, LightKind, LightModel, MAX_DEPTH, Material, Object, Pattern,
    Primitive, Scene,
};
use thiserror::Error;

use super::enlarge::enlargement;

/// The maximal number of instances: POV-Ray holds each in memory, at some kilobytes.
pub const MOST_INSTANCES: u64 = 2_000_000;

/// Why a scene cannot be exported.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[non_exhaustive]
pub enum PovError {
    /// Nothing has this name.
    #[error("nothing is named '{0}'")]
    Unknown(String),
    /// More than [`MOST_INSTANCES`] instances.
    #[error(
        "opened {depth} levels deep the picture has more than {MOST_INSTANCES} instances, and POV-Ray makes a copy for each; take fewer levels (--depth)"
    )]
    TooMany {
        /// The requested recursion depth.
        depth: u32,
    },
}

/// The scene below `root`, to the recursion depth `depth`, in POV-Ray's language.
///
/// # Errors
/// `root` is unknown, or there are too many instances.
///
/// ```
/// use superegg_exchange::povray::to_povray;
/// use superegg_scene::{Scene, SceneError};
///
/// let mut scene = Scene::default();
/// scene.ensure_primitive("egg")?;
/// let text = to_povray(&scene, "egg", 25).unwrap();
/// assert!(text.contains("sphere { 0, 1"));
/// assert_eq!(to_povray(&scene, "nest", 25).unwrap_err().to_string(), "nothing is named 'nest'");
/// # Ok::<(), SceneError>(())
/// ```
pub fn to_povray(scene: &Scene, root: &str, depth: u32) -> Result<String, PovError> {
    to_povray_enlarged(scene, root, depth, enlargement(scene, root, depth))
}

/// [`to_povray`] with all lengths multiplied by `factor`.
pub(super) fn to_povray_enlarged(
    scene: &Scene,
    root: &str,
    depth: u32,
    factor: f64,
) -> Result<String, PovError> {
    let mut writer = Writer { scene, factor, text: String::new(), declared: HashMap::new() };
    writer.head();
    let (name, count) = writer.declare(root, depth.min(MAX_DEPTH))?;
    if count > MOST_INSTANCES {
        return Err(PovError::TooMany { depth });
    }
    if let Some(name) = name {
        let scale = writer.scale();
        let _ = writeln!(writer.text, "object {{ {name}{scale} }}");
    }
    Ok(writer.text)
}

/// The losses of the POV-Ray file of a scene, one sentence each. See the module's text.
///
/// ```
/// use superegg_exchange::povray::losses;
/// use superegg_scene::{AmbientOcclusion, Scene};
///
/// let mut scene = Scene::default();
/// assert!(losses(&scene).is_empty());
/// scene.ambient_occlusion = Some(AmbientOcclusion { samples: 16, distance: 2.0 });
/// assert!(losses(&scene)[0].starts_with("ambient occlusion"));
/// ```
pub fn losses(scene: &Scene) -> Vec<String> {
    let picture = &scene.picture;
    let materials = || {
        let tables = scene.tables().flat_map(|(_, table)| table.materials());
        scene.primitives().map(|(_, primitive)| &primitive.material).chain(tables)
    };
    let is_glass = |material: &Material| material.refracted.is_some_and(|weight| weight > 0.0);
    let losses = [
        (
            scene.ambient_occlusion.is_some(),
            "ambient occlusion is not in the file: corners and undersides are brighter",
        ),
        (
            scene.ambient_occlusion.is_some() && scene.sky.is_some(),
            "light of the sky on surfaces is not in the file: POV-Ray shows the sky, and ambient light is white",
        ),
        (
            scene.lights().iter().any(|light| light.radius > 0.0),
            "soft shadows are approximate: a light is a disc that faces its target",
        ),
        (
            scene.lights().iter().any(|light| matches!(light.kind, LightKind::Spot { .. })),
            "the rim of a spot light fades in another way",
        ),
        (materials().any(is_glass), "glass is approximate: POV-Ray filters light by the colour itself"),
        (
            materials().any(|material| material.fresnel && !is_glass(material)),
            "reflection that depends on the angle is approximate",
        ),
        (scene.camera.lens.is_some(), "depth of field is approximate"),
        (
            picture.light_model == LightModel::Path,
            "light by way of surfaces and from the sky is not in the file: POV-Ray's radiosity is its own",
        ),
        (
            materials().any(|material| material.emission > 0.0),
            "shapes that shine are seen, but light nothing in POV-Ray without its radiosity",
        ),
        (
            materials().any(|material| material.facet_roughness().is_some()),
            "roughness and metal are not in the file",
        ),
        (
            scene.entities().any(|(_, entity)| entity.has_textures()),
            "textures are not in the file: surfaces have their colour and pattern",
        ),
        (picture.gloss_rays > 1, "blurred reflection is not in the file: mirrors are sharp"),
        (
            picture.exposure != 0.0 || picture.tone != superegg_scene::Tone::None,
            "exposure and tone mapping are not in the file",
        ),
        (scene.tracks().len() > 0, "keyframes are not in the file: it shows the scene at rest"),
    ];
    losses.into_iter().filter(|(is_lost, _)| *is_lost).map(|(_, loss)| loss.to_owned()).collect()
}

struct Writer<'a> {
    scene: &'a Scene,
    /// All lengths are multiplied by it.
    factor: f64,
    text: String,
    /// The identifier of (name, remaining depth), `None` if it is empty, and its number of
    /// instances.
    declared: HashMap<(&'a str, u32), (Option<String>, u64)>,
}

impl<'a> Writer<'a> {
    /// The words that enlarge an object with its texture.
    fn scale(&self) -> String {
        if self.factor == 1.0 { String::new() } else { format!(" scale {}", self.factor) }
    }

    fn head(&mut self) {
        let most_levels = self.scene.picture.bounces.saturating_add(1).min(MOST_LEVELS);
        let _ = write!(
            self.text,
            "// Written by superegg. Render with the picture's own size, for example:\n\
             //   povray +W1280 +H960 FILE.pov\n\
             #version 3.7;\n\
             global_settings {{ assumed_gamma 1.0 max_trace_level {most_levels} ambient_light rgb 1 }}\n\
"
        );
        if self.factor != 1.0 {
            let _ = writeln!(self.text, "// All lengths are {} times those of the scene.", self.factor);
        }
        self.text.push_str(&self.sky());
        self.camera(&self.scene.camera);
        self.scene.lights().iter().for_each(|light| self.text.push_str(&light_source(light, self.factor)));
        if let Some(floor) = &self.scene.floor {
            self.floor(floor);
        }
        self.text.push('\n');
    }

    fn sky(&self) -> String {
        let Some(sky) = self.scene.sky else {
            return format!("background {{ color rgb {} }}\n", vector(self.scene.background));
        };
        let up = unit_vector(sky.up).unwrap_or(DVec3::Y);
        let (horizon, zenith) = (vector(sky.horizon), vector(sky.zenith));
        // From nadir to zenith; constant below the horizon.
        let colors = format!("[0.5 color rgb {horizon}] [1 color rgb {zenith}]");
        format!("sky_sphere {{ pigment {{ {} }} }}\n", gradient(up, -1.0, 1.0, &colors))
    }

    fn camera(&mut self, camera: &Camera) {
        let (right, up, forward) = camera.frame();
        let kind = if camera.ortho_height.is_some() { "orthographic" } else { "perspective" };
        let of_angle = 2.0 * (0.5 * camera.fov_deg.to_radians()).tan();
        let height = camera.ortho_height.map_or(of_angle, |height| height * self.factor);
        let position = camera.position * self.factor;
        let lens = camera.lens.map_or(String::new(), |lens| {
            let focus = vector(position + forward * lens.focus * self.factor);
            let diameter = 2.0 * lens.radius * self.factor;
            format!("\n  aperture {diameter} focal_point {focus} blur_samples 64 variance 0")
        });
        let [position, right, up, forward] = [position, right * height, up * height, forward].map(vector);
        let _ = writeln!(
            self.text,
            "camera {{ {kind} location {position} direction {forward} up {up}\n  right {right} * (image_width / image_height){lens} }}"
        );
    }

    /// The floor. Its pattern follows its own axes; a checker is offset by half a cell, so that no
    /// cell boundary lies in the plane.
    fn floor(&mut self, floor: &Floor) {
        let [first, second, up] = floor.axes();
        let material = self.scene.floor_material();
        let pigment = match material.pattern {
            Pattern::Checker { size, .. } => {
                let map = DAffine3 {
                    matrix3: DMat3::from_cols(first, second, up),
                    translation: (floor.height - 0.5 * size) * up,
                };
                format!("{} {}", pattern(&material, None), affine(&map))
            }
            Pattern::Gradient { color, direction } => {
                let along = unit_vector(direction).unwrap_or(DVec3::Z);
                let along = DMat3::from_cols(first, second, up) * along;
                let colors = format!("[0 {}] [1 {}]", rgb(&material, material.color), rgb(&material, color));
                // One unit each way.
                format!("gradient {} triangle_wave color_map {{ {colors} }} scale 2", vector(along))
            }
            _ => pattern(&material, None),
        };
        let texture = texture(&material, &pigment, self.factor);
        let scale = self.scale();
        let _ = writeln!(self.text, "plane {{ {}, {}\n  {texture}{scale} }}", vector(up), floor.height);
    }

    /// Declares the entity of a name with `remaining` levels left. Returns its identifier and its
    /// number of instances.
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
            Entity::Object(_) | Entity::Table(_) if remaining == 0 => (None, 0),
            Entity::Table(table) => self.table(identifier, table, remaining)?,
            Entity::Object(object) => {
                // Terminates: `remaining` decreases, so a declaration never needs itself.
                self.object(identifier, object, remaining)?
            }
        };
        self.declared.insert(key, answer.clone());
        Ok(answer)
    }

    fn primitive(&mut self, identifier: &str, primitive: &Primitive) {
        let exponents = primitive.shape.exponents();
        let (e, n) = (exponents.e(), exponents.n());
        let shape = solid(e, n);
        let radii = vector(primitive.shape.radii());
        let reach = |direction: DVec3| {
            let linear = DMat3::from_cols(direction, DVec3::ZERO, DVec3::ZERO).transpose();
            primitive.shape.half_extent_under(&linear).x
        };
        let texture = texture(&primitive.material, &pattern(&primitive.material, Some(&reach)), self.factor);
        let _ = writeln!(self.text, "#declare {identifier} = {shape} scale {radii}\n  {texture} }}");
    }

    /// A table: one shape for each row.
    fn table(
        &mut self,
        identifier: String,
        table: &InstanceTable,
        remaining: u32,
    ) -> Result<(Option<String>, u64), PovError> {
        let count = table.len() as u64;
        if count > MOST_INSTANCES {
            return Err(PovError::TooMany { depth: remaining });
        }
        for (number, shape) in table.shapes().enumerate() {
            let row = Primitive {
                shape: Superquadric::new(shape.radii, shape.exponents)
                    .unwrap_or_else(|_| Superquadric::unit(shape.exponents)),
                material: table.materials()[shape.material as usize],
                ..Primitive::default()
            };
            self.primitive(&format!("{identifier}_{number}"), &row);
        }
        if table.len() < 2 {
            let Some(row) = (!table.is_empty()).then_some(0) else { return Ok((None, 0)) };
            let (shape, map) = (table.shape_index(row), matrix(&table.transform(row)));
            let _ = writeln!(self.text, "#declare {identifier} = object {{ {identifier}_{shape} {map} }}");
            return Ok((Some(identifier), 1));
        }
        let _ = writeln!(self.text, "#declare {identifier} = union {{");
        for row in 0..table.len() {
            let (shape, map) = (table.shape_index(row), matrix(&table.transform(row)));
            let _ = writeln!(self.text, "  object {{ {identifier}_{shape} {map} }}");
        }
        self.text.push_str("}\n");
        Ok((Some(identifier), count))
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
        for (_, child) in object.visible_children() {
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
        // POV-Ray warns of a union of one.
        let body = if children == 1 {
            format!("#declare {identifier} =\n{body}")
        } else {
            format!("#declare {identifier} = union {{\n{body}}}\n")
        };
        self.text.push_str(&body);
        Ok((Some(identifier), count))
    }

    /// The name, if the scene has it.
    fn declared_name(&self, name: &'a str) -> Option<&'a str> {
        self.scene.get(name).map(|_| name)
    }
}

/// A POV-Ray identifier: letters, digits and underscores. It starts with a capital, so it is no
/// keyword.
fn identifier(name: &str) -> String {
    let plain: String =
        name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).take(24).collect();
    format!("S_{plain}")
}

fn vector(v: DVec3) -> String {
    format!("<{}, {}, {}>", v.x, v.y, v.z)
}

/// A transform as images of the axes and of the origin; empty for the identity.
fn matrix(map: &Transform) -> String {
    if *map == Transform::IDENTITY { String::new() } else { affine(map.forward()) }
}

fn affine(map: &DAffine3) -> String {
    let DAffine3 { matrix3: m, translation } = *map;
    let rows = [m.x_axis, m.y_axis, m.z_axis, translation].map(|v| format!("{},{},{}", v.x, v.y, v.z));
    format!("matrix <{}>", rows.join(", "))
}

/// The distance of directional lights, in units of the file: POV-Ray has no light at infinity.
const SUN_DISTANCE: f64 = 1e6;
/// POV-Ray's limit of the recursion of rays.
const MOST_LEVELS: u32 = 256;
/// Shadow rays along each side of an area light.
const LIGHT_RAYS: u32 = 9;

/// A light in a file whose lengths are multiplied by `factor`.
fn light_source(light: &Light, factor: f64) -> String {
    let mut color = light.color;
    let mut words = String::new();
    let (position, radius) = match light.kind {
        LightKind::Point { position } => (position * factor, light.radius * factor),
        LightKind::Spot { position, target, cone_deg, soft } => {
            let half_deg = 0.5 * cone_deg;
            let _ = write!(
                words,
                " spotlight point_at {} radius {} falloff {half_deg} tightness 0",
                vector(target * factor),
                half_deg * (1.0 - soft)
            );
            (position * factor, light.radius * factor)
        }
        LightKind::Sun { direction } => {
            if light.radius == 0.0 {
                words.push_str(" parallel point_at <0, 0, 0>");
            }
            let towards = unit_vector(direction).unwrap_or(DVec3::Y);
            (SUN_DISTANCE * towards, SUN_DISTANCE * light.radius)
        }
    };
    if light.falloff > 0.0 && light.position().is_some() {
        color *= 0.5;
        let _ = write!(words, " fade_distance {} fade_power 2", factor / light.falloff.sqrt());
    }
    if radius > 0.0 {
        let width = 2.0 * radius;
        let _ = write!(
            words,
            " area_light <{width}, 0, 0>, <0, 0, {width}>, {LIGHT_RAYS}, {LIGHT_RAYS} adaptive 1 jitter circular orient"
        );
    }
    format!("light_source {{ {} color rgb {}{words} }}\n", vector(position), vector(color))
}

/// A gradient from `least` to `most` along a unit direction.
fn gradient(along: DVec3, least: f64, most: f64, colors: &str) -> String {
    // Slightly wider, because the pattern repeats at its end.
    let width = (most - least) * (1.0 + 1e-6);
    let start = vector(along * (least - (most - least) * 5e-7));
    format!("gradient {} color_map {{ {colors} }} scale {width} translate {start}", vector(along))
}

/// A colour with the transmitted weight of the material.
fn rgb(material: &Material, color: DVec3) -> String {
    let (_, through) = lobe_weights(material);
    let filter = if through > 0.0 { format!(" filter {through}") } else { String::new() };
    format!("rgb {}{filter}", vector(color))
}

/// The content of a pigment. `reach` is the half extent of the shape along a unit direction, for a
/// gradient.
fn pattern(material: &Material, reach: Option<&dyn Fn(DVec3) -> f64>) -> String {
    let base = rgb(material, material.color);
    match (material.pattern, reach) {
        (Pattern::Checker { color, size }, _) => {
            format!("checker color {base}, color {} scale {size}", rgb(material, color))
        }
        (Pattern::Gradient { color, direction }, Some(reach)) => {
            let along = unit_vector(direction).unwrap_or(DVec3::Z);
            let colors = format!("[0 color {base}] [1 color {}]", rgb(material, color));
            let reach = reach(along);
            gradient(along, -reach, reach, &colors)
        }
        (Pattern::Noise { color, size }, _) => {
            format!("bozo color_map {{ [0 {base}] [1 {}] }} scale {size}", rgb(material, color))
        }
        (Pattern::Marble { color, size }, _) => {
            let veins = rgb(material, color);
            format!("marble turbulence 0.6 color_map {{ [0 {base}] [1 {veins}] }} scale {size}")
        }
        (Pattern::Wood { color, size }, _) => {
            let late = rgb(material, color);
            format!("wood turbulence 0.06 color_map {{ [0 {base}] [1 {late}] }} scale {size}")
        }
        (Pattern::Gradient { .. } | Pattern::None, _) => base,
    }
}

/// The weights of reflected and transmitted light, normalised to a sum of at most 1.
fn lobe_weights(material: &Material) -> (f64, f64) {
    let mirror = material.reflected.unwrap_or(0.0);
    let through = material.refracted.unwrap_or(0.0);
    let total = (mirror + through).max(1.0);
    (mirror / total, through / total)
}

/// The unit shape, without its closing brace.
fn solid(e: f64, n: f64) -> String {
    /// POV-Ray has no exponent of 0.
    const LEAST: f64 = 1e-4;
    if (e, n) == (1.0, 1.0) {
        "sphere { 0, 1".to_owned()
    } else if (e, n) == (0.0, 0.0) {
        "box { <-1, -1, -1>, <1, 1, 1>".to_owned()
    } else if (e, n) == (1.0, 0.0) {
        "cylinder { <0, 0, -1>, <0, 0, 1>, 1".to_owned()
    } else {
        let positive = |x: f64| if x == 0.0 { LEAST } else { x };
        format!("superellipsoid {{ <{}, {}>", positive(e), positive(n))
    }
}

/// A texture, in a file whose lengths are multiplied by `factor`: POV-Ray does not scale the interior with the shape.
fn texture(material: &Material, pigment: &str, factor: f64) -> String {
    let (mirror, through) = lobe_weights(material);
    // With Fresnel reflectance, only the reflection at normal incidence reduces the local colour.
    let normal_reflectance = ((material.index - 1.0) / (material.index + 1.0)).powi(2);
    let reflected = if material.fresnel { mirror * normal_reflectance } else { mirror };
    let local = (1.0 - reflected - through).max(0.0);
    // POV-Ray reduces the local colour by the transmitted weight as well.
    let own = if through < 1.0 { local / (1.0 - through) } else { 0.0 };
    let roughness = material.highlight_exponent().max(1e-4).recip();
    let mut text = format!(
        "pigment {{ {pigment} }} finish {{ ambient {} diffuse {} specular {} roughness {roughness}",
        material.ambient * own,
        material.diffuse * own,
        material.specular
    );
    if material.emission > 0.0 {
        let _ = write!(text, " emission {}", material.emission);
    }
    if through > 0.0 {
        let _ = write!(text, " reflection {{ {mirror}, 1 fresnel on }} conserve_energy }}");
        let _ =
            write!(text, " interior {{ ior {}{} }}", material.index, absorption(material.absorb / factor));
    } else if mirror > 0.0 && material.fresnel {
        let _ =
            write!(text, " reflection {{ 0, {mirror} fresnel on }} }} interior {{ ior {} }}", material.index);
    } else if mirror > 0.0 {
        let _ = write!(text, " reflection {mirror} }}");
    } else {
        text.push_str(" }");
    }
    text
}

/// Absorption `exp(-absorb * d)`: for powers above 1000 POV-Ray computes `exp(-(1 - color) * d /
/// distance)`.
fn absorption(absorb: DVec3) -> String {
    let most = absorb.max_element();
    if most <= 0.0 {
        return String::new();
    }
    let color = vector(DVec3::ONE - absorb / most);
    format!(" fade_distance {} fade_power 1001 fade_color rgb {color}", most.recip())
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
        let position = |what: &str| text.find(what).unwrap_or_else(|| panic!("no {what} in\n{text}"));
        assert_eq!(text.matches("#declare").count(), 4);
        assert!(position("matrix <1,0,0, 0,1,0, 0,0,1, 0,0,2.5>") < position("\nobject { S_my_tree"));
        assert!(text.matches('{').count() == text.matches('}').count());
        for line in text.lines().filter(|line| line.starts_with("#declare")) {
            let identifier = line.split_whitespace().nth(1).unwrap();
            assert!(
                position(&format!("#declare {identifier}"))
                    < text.rfind(&format!("{{ {identifier} ")).unwrap()
            );
        }
    }

    #[test]
    fn hidden_children_are_not_written() {
        let mut scene = scene();
        scene.set_hidden("my tree", "a", true).unwrap();
        scene.add_child("my tree", "c", "sphere").unwrap();
        let text = to_povray(&scene, "my tree", 1).unwrap();
        assert_eq!((text.matches("object { S_sphere").count(), text.contains("union")), (1, false), "{text}");
        scene.set_hidden("my tree", "c", true).unwrap();
        assert!(!to_povray(&scene, "my tree", 1).unwrap().contains("object {"));
    }

    #[test]
    fn what_is_around_is_written() {
        let mut scene = scene();
        scene.set_light("sun", Light { kind: LightKind::Sun { direction: DVec3::Y }, ..Light::DEFAULT });
        let spot = LightKind::Spot { position: DVec3::Z, target: DVec3::ZERO, cone_deg: 60.0, soft: 0.5 };
        scene.set_light("spot", Light { kind: spot, radius: 0.5, falloff: 0.25, ..Light::DEFAULT });
        scene.floor = Some(Floor { height: -1.0, up: DVec3::Y, surface: Some("sphere".into()) });
        scene.camera.ortho_height = Some(4.0);
        let sphere = scene.primitive_mut("sphere").unwrap();
        sphere.material.pattern = Pattern::Checker { color: DVec3::X, size: 0.25 };
        (sphere.material.refracted, sphere.material.absorb) = (Some(0.5), DVec3::new(0.0, 1.0, 2.0));
        let text = to_povray(&scene, "my tree", 3).unwrap();
        for part in [
            "parallel point_at <0, 0, 0>",
            "radius 15 falloff 30",
            "fade_distance 2 fade_power 2",
            "area_light <1, 0, 0>",
            "plane { <0, 1, 0>, -1",
            "checker color rgb <1, 1, 1> filter 0.5, color rgb <1, 0, 0> filter 0.5 scale 0.25",
            "fade_distance 0.5 fade_power 1001 fade_color rgb <1, 0.5, 0>",
            "camera { orthographic",
        ] {
            assert!(text.contains(part), "no {part} in\n{text}");
        }
        assert_eq!(text.matches('{').count(), text.matches('}').count());
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
