//! Losses of formats, in words.

use superegg_scene::{Pattern, Scene};

use super::flatten::Instances;

/// The parts of a material that a format keeps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum MaterialKept {
    /// Nothing.
    None,
    /// The base colour.
    Color,
    /// The base colour, the highlight, the mirror weight and the opacity, about.
    Reflection,
}

/// The losses of formats of surfaces or particles.
pub(super) fn of_scene(scene: &Scene) -> Vec<String> {
    let mut lost = vec!["camera"];
    if scene.named_lights().len() > 0 {
        lost.push("lights");
    }
    if scene.floor.is_some() {
        lost.push("floor");
    }
    if scene.sky.is_some() {
        lost.push("sky");
    }
    if scene.ambient_occlusion.is_some() {
        lost.push("ambient occlusion");
    }
    let mut losses = vec![format!("not in the file: {}", lost.join(", "))];
    if scene.entities().any(|(_, entity)| entity.has_textures()) {
        losses.push("textures are not in the file: surfaces have their colour".to_owned());
    }
    losses.extend(of_animation(scene));
    losses
}

/// The loss of keyframes.
pub(super) fn of_animation(scene: &Scene) -> Option<String> {
    (scene.tracks().len() > 0).then(|| "keyframes are not in the file: it shows the scene at rest".to_owned())
}

/// The losses of a format in the materials that instances use.
pub(super) fn of_materials(instances: &Instances, kept: MaterialKept) -> Vec<String> {
    let any =
        |test: fn(&superegg_scene::Material) -> bool| instances.parts.iter().any(|part| test(&part.material));
    let mut losses = Vec::new();
    match kept {
        MaterialKept::None => losses.push("colours and materials are not in the file".to_owned()),
        MaterialKept::Color => {
            losses.push("of the materials only the base colour is in the file".to_owned());
        }
        MaterialKept::Reflection => {
            if any(|material| material.refracted.is_some_and(|weight| weight > 0.0)) {
                losses.push("refraction and absorption become partial opacity".to_owned());
            }
        }
    }
    if kept != MaterialKept::None && any(|material| material.pattern != Pattern::None) {
        losses.push("patterns are not in the file: surfaces have their base colour".to_owned());
    }
    if kept != MaterialKept::None && any(|material| material.emission > 0.0) {
        losses.push("emission is not in the file: surfaces give off no light".to_owned());
    }
    if kept == MaterialKept::Color && any(|material| material.facet_roughness().is_some()) {
        losses.push("roughness and metal are not in the file".to_owned());
    }
    losses
}
