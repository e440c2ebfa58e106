//! A POV-Ray scene as lines of the modelling language.

use std::collections::HashMap;
use std::rc::Rc;

use superegg_geom::TransformStep;
use superegg_geom::glam::DVec3;

use super::model::{LightSource, Node, NodeKind, Plane, PovCamera, PovScene, Surface, mirror, mirrored};
use crate::read::script::{Names, Script};

/// A picture of other proportions than this, width by height, sets its size.
const USUAL_ASPECT: f64 = 4.0 / 3.0;
/// The height of a picture that is set, in pixels.
const PICTURE_HEIGHT: f64 = 960.0;
/// The index of refraction of a surface that sets none.
const DEFAULT_INDEX: f64 = 1.5;

/// Writes a scene. Scenes of a left-handed camera are mirrored, z -> -z, so that they look the
/// same.
pub(crate) fn script_of(scene: &PovScene, ambient_light: f64, is_size_free: bool) -> (String, Vec<String>) {
    let is_mirrored = is_left_handed(scene.camera.as_ref().unwrap_or(&PovCamera::default()));
    let mut emitter = Emitter {
        script: Script::default(),
        is_mirrored,
        ambient_light,
        primitives: HashMap::new(),
        objects: HashMap::new(),
        warnings: Vec::new(),
    };
    if let Some(camera) = &scene.camera {
        emitter.camera(camera, is_size_free);
    }
    if let Some(background) = scene.background {
        emitter.script.numbers("background", "", &background.max(DVec3::ZERO).to_array());
    }
    for (index, light) in scene.lights.iter().enumerate() {
        emitter.light(&format!("light{}", index + 1), light);
    }
    if let Some(plane) = &scene.plane {
        emitter.floor(plane);
    }
    emitter.objects(&scene.objects);
    let levels = scene.objects.iter().map(|node| node.levels).max().unwrap_or(0);
    emitter.script.depth(levels + 1);
    (emitter.script.into_text(), emitter.warnings)
}

/// Whether the picture shows the world left-handed, as POV-Ray's own camera does.
pub(crate) fn is_left_handed(camera: &PovCamera) -> bool {
    camera.right.cross(camera.up).dot(camera.direction) > 0.0
}

/// The result of an object of the scene: a primitive or object, and its transforms.
struct Placement {
    is_primitive: bool,
    name: String,
    steps: Vec<TransformStep>,
}

/// The bits of a shape and the address of its surface: shapes of the same key are one primitive.
type ShapeKey = ([u64; 5], usize);

struct Emitter {
    script: Script,
    is_mirrored: bool,
    ambient_light: f64,
    primitives: HashMap<ShapeKey, String>,
    /// By the addresses of the union and of the surface that it inherits.
    objects: HashMap<(usize, usize), String>,
    warnings: Vec<String>,
}

fn address<T>(shared: Option<&Rc<T>>) -> usize {
    shared.map_or(0, |shared| Rc::as_ptr(shared) as usize)
}

impl Emitter {
    fn seen(&self, v: DVec3) -> DVec3 {
        if self.is_mirrored { mirror(v) } else { v }
    }

    fn camera(&mut self, camera: &PovCamera, is_size_free: bool) {
        let PovCamera { location, direction, right, up, .. } = *camera;
        let (width, height, reach) = (right.length(), up.length(), direction.length());
        let aspect = width / height;
        if !is_size_free && (aspect / USUAL_ASPECT - 1.0).abs() > 1e-3 && aspect.is_finite() {
            let pixels = (aspect * PICTURE_HEIGHT).round().clamp(1.0, 1e4);
            self.script.line(&["set", "size", &format!("{pixels}x{PICTURE_HEIGHT}")]);
        }
        let unit = |v: DVec3| v.normalize_or_zero();
        let square = unit(right).cross(unit(up)).dot(unit(direction)).abs();
        if square.is_nan() || square <= 1.0 - 1e-6 {
            self.warnings.push("the camera's vectors are not at right angles, which is not kept".to_owned());
        }
        let fov_deg = (2.0 * (0.5 * height / reach).atan().to_degrees()).clamp(1e-6, 179.999);
        let position = self.seen(location);
        let target = self.seen(location + direction / reach);
        let mut numbers = [position, target].map(|v| v.to_array()).concat();
        numbers.push(fov_deg);
        self.script.numbers("camera", "", &numbers);
        self.script.numbers("cameraUp", "", &self.seen(up / height).to_array());
        if camera.is_orthographic {
            self.script.numbers("orthographic", "", &[height]);
        }
        let focus = camera.focal_point.map(|point| (point - location).dot(direction / reach));
        if let Some(focus) = focus.filter(|focus| *focus > 0.0 && camera.aperture > 0.0) {
            self.script.numbers("lens", "", &[0.5 * camera.aperture, focus]);
        }
    }

    fn light(&mut self, name: &str, light: &LightSource) {
        let name = self.script.new_name(name);
        let (position, target) = (self.seen(light.position), self.seen(light.target));
        let color = light.color.to_array();
        if light.is_parallel {
            let towards = position - target;
            if towards == DVec3::ZERO {
                self.warnings
                    .push(format!("'{name}' is parallel light without a direction, and is left out"));
                return;
            }
            self.script.numbers("sun", &name, &[towards.to_array(), color].concat());
            return;
        }
        if let Some([full, none]) = light.cone {
            let degrees = (2.0 * none).clamp(1e-3, 180.0);
            let soft = if none > 0.0 { (1.0 - full / none).clamp(0.0, 1.0) } else { 0.0 };
            let mut numbers = [position, target].map(|v| v.to_array()).concat();
            numbers.push(degrees);
            numbers.extend(color);
            numbers.extend([light.attenuation, soft]);
            self.script.numbers("spot", &name, &numbers);
        } else {
            let mut numbers = [position.to_array(), color].concat();
            numbers.push(light.attenuation);
            self.script.numbers("light", &name, &numbers);
        }
        if light.radius > 0.0 {
            self.script.numbers("lightRadius", &name, &[light.radius]);
        }
    }

    fn floor(&mut self, plane: &Plane) {
        let name = self.script.new_name("floor_surface");
        self.script.gap();
        self.script.line(&["primitive", &name]);
        let surface = plane.surface.clone().unwrap_or_default();
        self.surface(&surface);
        let up = self.seen(plane.normal);
        let height = plane.height.to_string();
        let words = up.to_array().map(|number| number.to_string());
        self.script.line(&["floor", &height, &name, &words[0], &words[1], &words[2]]);
    }

    fn objects(&mut self, objects: &[Rc<Node>]) {
        let placements: Vec<Placement> = objects.iter().map(|node| self.place(node, None, None)).collect();
        match &placements[..] {
            [Placement { is_primitive: false, name, steps }] if steps.is_empty() => {
                let name = name.clone();
                self.script.gap();
                self.script.line(&["object", &name]);
            }
            _ => {
                let name = self.script.new_name("scene");
                self.group(&name, &placements);
            }
        }
    }

    /// Writes an object with these children.
    fn group(&mut self, name: &str, placements: &[Placement]) {
        self.script.gap();
        self.script.line(&["object", name]);
        let mut aliases = Names::default();
        for Placement { is_primitive, name, steps } in placements {
            let command = if *is_primitive { "addPrimitive" } else { "addObject" };
            let alias = aliases.add(name);
            self.script.line(&[command, name, &alias]);
            let seen: Vec<TransformStep> = steps
                .iter()
                .map(|step| if self.is_mirrored { mirrored(step) } else { step.clone() })
                .collect();
            self.script.steps(&seen, "");
        }
    }

    /// Writes what an object needs. `outer` is the surface that replaces its own, `inherited` the
    /// one of a union around it. The depth of objects bounds the recursion.
    fn place(
        &mut self,
        node: &Rc<Node>,
        outer: Option<&Rc<Surface>>,
        inherited: Option<&Rc<Surface>>,
    ) -> Placement {
        let own = outer.or(node.surface.as_ref());
        match &node.kind {
            NodeKind::Shape(exponents) => {
                let surface = own.or(inherited);
                self.shape(node, *exponents, surface)
            }
            NodeKind::Use(target) => {
                let mut placement = self.place(target, own, inherited);
                placement.steps.extend(node.steps.iter().cloned());
                placement
            }
            NodeKind::Union(children) => {
                let surface = own.or(inherited);
                let key = (Rc::as_ptr(node) as usize, address(surface));
                let name = match self.objects.get(&key) {
                    Some(name) => name.clone(),
                    None => {
                        let placements: Vec<Placement> =
                            children.iter().map(|child| self.place(child, None, surface)).collect();
                        let name = self.script.new_name(node.name.as_deref().unwrap_or("union"));
                        self.group(&name, &placements);
                        self.objects.insert(key, name.clone());
                        name
                    }
                };
                Placement { is_primitive: false, name, steps: node.steps.clone() }
            }
        }
    }

    fn shape(&mut self, node: &Node, exponents: [f64; 2], surface: Option<&Rc<Surface>>) -> Placement {
        // Scales that act first are the semi-axes.
        let mut radii = DVec3::ONE;
        let mut rest = &node.steps[..];
        while let [TransformStep::Scale(factors), after @ ..] = rest {
            let product = radii * *factors;
            if factors.min_element() <= 0.0 || !product.is_finite() || product.min_element() <= 0.0 {
                break;
            }
            (radii, rest) = (product, after);
        }
        let bits = [exponents[0], exponents[1], radii.x, radii.y, radii.z].map(f64::to_bits);
        let key = (bits, address(surface));
        let name = match self.primitives.get(&key) {
            Some(name) => name.clone(),
            None => {
                let usual = if exponents == [1.0, 1.0] { "sphere" } else { "superellipsoid" };
                let name = self.script.new_name(node.name.as_deref().unwrap_or(usual));
                self.script.gap();
                self.script.line(&["primitive", &name]);
                self.script.numbers("setCoeff", "", &radii.to_array());
                self.script.numbers("setExponent", "", &exponents);
                let surface = surface.cloned().unwrap_or_default();
                self.surface(&surface);
                self.primitives.insert(key, name.clone());
                name
            }
        };
        Placement { is_primitive: true, name, steps: rest.to_vec() }
    }

    /// Writes the surface of the selected primitive.
    fn surface(&mut self, surface: &Surface) {
        let &Surface { color, through, specular, .. } = surface;
        let color = color.max(DVec3::ZERO);
        let bright = color.max_element().max(1.0);
        let index = surface.index.unwrap_or(DEFAULT_INDEX).clamp(1.0, 4.0);
        // A transparent surface reflects by Fresnel's law anyway.
        let [least, most] = surface.reflection.map(|weight| weight.clamp(0.0, 1.0));
        let fresnel = surface.fresnel && through == 0.0 && least == 0.0 && most > 0.0;
        let mirror = if fresnel { most } else { least };
        // Ours takes what is mirrored and passes off the local part, POV-Ray only what passes.
        let head_on = if fresnel { mirror * ((index - 1.0) / (index + 1.0)).powi(2) } else { mirror };
        let local = 1.0 - head_on - through;
        let factor = if local > 0.0 { bright * (1.0 - through) / local } else { 0.0 };
        let mut weight = |value: f64| {
            let value = (value * factor).max(0.0);
            if value > 1.0 + 1e-9 {
                let message = "a surface is brighter than a weight of 1, which is clamped".to_owned();
                if !self.warnings.contains(&message) {
                    self.warnings.push(message);
                }
            }
            value.min(1.0)
        };
        let (ambient, diffuse) = (weight(surface.ambient * self.ambient_light), weight(surface.diffuse));
        self.script.numbers("setColor", "", &(color / bright).to_array());
        self.script.numbers("setAmbient", "", &[ambient]);
        self.script.numbers("setDiffuse", "", &[diffuse]);
        self.script.numbers("setSpecular", "", &[specular.clamp(0.0, 1.0)]);
        if let Some(shininess) = surface.shininess {
            self.script.numbers("setShininess", "", &[shininess]);
        }
        if mirror > 0.0 {
            self.script.numbers("setReflected", "", &[mirror]);
        }
        if through > 0.0 {
            self.script.numbers("setRefracted", "", &[through]);
        }
        if surface.index.is_some() {
            self.script.numbers("setIndex", "", &[index]);
        }
        if fresnel {
            self.script.line(&["setFresnel", "on"]);
        }
        if surface.absorb != DVec3::ZERO {
            self.script.numbers("setAbsorb", "", &surface.absorb.to_array());
        }
    }
}
